// Where "block 120", "N2000" and "tool 5" are in a stored program: people name places the way their control
// shows them.
#pragma once

#include <cstdint>
#include <string>

namespace headstock::dnc {

struct StartWish {
  enum By { line, block, sequence, tool } by = line;
  std::int64_t value = 1;       ///< of block: counted from 1, empty lines and % lines left out
  std::int64_t occurrence = 1;  ///< the n-th of them; a sequence number or a tool may come more than once
};

struct StartPlace {
  std::int64_t line = 0;  ///< from 1; 0: there is none
  std::string text;       ///< the line, at most 200 bytes
  std::int64_t occurrences = 0;
};

/// Worker; reads the whole file. The line of a tool is the one that changes to it, so that a start there
/// changes to it again: on a mill the M06, on a lathe the T word.
/// @param mill T5 with an M06 of its own; otherwise T0505 changes at once.
StartPlace find_place(const std::string& file, const StartWish& wish, bool mill);

}  // namespace headstock::dnc

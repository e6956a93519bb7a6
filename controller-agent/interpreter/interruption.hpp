// Interruption macros (0i-D 14.9, K2000TC L20693): a signal calls a program between or inside blocks; its M99 brings
// back what was in force.
#pragma once

#include <cstdint>

#include "interpreter/canonical.hpp"
#include "interpreter/compiled_program.hpp"

namespace headstock::interp {

/// What M96 P and M97 say, and how an interruption that runs has to end.
struct Interruption {
  std::int32_t on_code = -1, off_code = -1;  ///< M codes; -1: the dialect has none, or reads them itself
  std::uint32_t program = 0;
  bool enabled = false;
  bool inside = false;        ///< the signal came inside a block
  bool acted = false;         ///< the program that runs has commanded something: the block it broke into is over
  bool left_block = false;    ///< the last program has returned without commanding anything
  BlockPlace block;           ///< begun last, while interruptions are enabled
  AxisVector place_before{};  ///< machine position the broken block leads to
};

}  // namespace headstock::interp

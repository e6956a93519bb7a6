// Which of a dialect's G and M codes this build of the interpreter carries out.
#pragma once

#include <string_view>
#include <vector>

namespace headstock::offline {

/// One row of a dialect's G table: the code in the G-code systems A, B and C ("" where a system lacks it).
struct GCodeState {
  std::string_view a, b, c, group, handler, meaning;
  bool done = false;

  std::string_view name() const { return !a.empty() ? a : !b.empty() ? b : c; }
};

struct MCodeState {
  std::string_view code;
  bool done = false;
};

std::vector<GCodeState> gcode_states(std::string_view profile);

/// The M codes of the catalogue that are plain numbers. Codes for the machine count as done: the interpreter
/// passes them on and the ladder answers.
std::vector<MCodeState> mcode_states(std::string_view profile);

}  // namespace headstock::offline

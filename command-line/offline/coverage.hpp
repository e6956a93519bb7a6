// What of a controller this build carries out: every G code, M code, alarm, parameter and variable of its
// catalogue as done, as without meaning off the control's panel, or as missing. Derived from the tables and
// the sources (bound handlers, alarms that some code raises, parameters that some code reads); what the
// sources cannot tell (a function that the machine file or the server has instead, a thing of the panel) is
// said by dialects/<folder>/off-panel.tsv.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace headstock::offline {

enum class State { done, off_panel, missing };

struct Covered {
  std::string_view code;
  std::string_view name;  ///< English, short
  State state = State::missing;
  std::string_view reason;  ///< done: where; off the panel: why
};

struct CoverageOf {
  std::string_view kind;  ///< "gcodes", "mcodes", "alarms", "parameters", "variables"
  std::vector<Covered> items;
  std::size_t count(State state) const;
};

/// The five kinds. Empty for an unknown profile.
std::vector<CoverageOf> coverage(std::string_view profile);

/// Rows of off-panel.tsv that say nothing: no such code, or a code that the sources show to be done.
std::vector<std::string> stale_reasons(std::string_view profile);

/// The page of a dialect's folder, Markdown.
std::string coverage_page(std::string_view profile);

/// One row of a dialect's G table: the code in the G-code systems A, B and C ("" where a system lacks it).
struct GCodeState {
  std::string_view a, b, c, group, handler, meaning;
  bool done = false;

  std::string_view name() const { return !a.empty() ? a : !b.empty() ? b : c; }
};
std::vector<GCodeState> gcode_states(std::string_view profile);

}  // namespace headstock::offline

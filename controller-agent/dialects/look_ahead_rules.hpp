// Which codes stop the look-ahead of a control, as data.
#pragma once

#include <array>
#include <string_view>

namespace headstock::dialects {

struct LookAheadRules {
  bool stops = false;         ///< M00, M01, M02, M30
  bool machine_moves = false;  ///< G53
  /// Parameters that hold an M code each, a row of `held_m_count` from this one; range pairs likewise.
  std::string_view held_m, held_m_ranges;
  int held_m_count = 0, held_m_range_count = 0;
};

}  // namespace headstock::dialects

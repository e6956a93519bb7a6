// Codes before which nothing is read ahead: what follows is read when the machine has come so far, so that a macro
// statement behind them sees the machine as the code left it (0i-D 14.8.3, No.3411-3432).
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace headstock::interp {

struct LookAhead {
  std::vector<std::pair<std::int32_t, std::int32_t>> held_m;  ///< M codes, first and last of each range
  bool holds(std::int32_t m) const {
    for (const auto& [first, last] : held_m)
      if (m >= first && m <= last) return true;
    return false;
  }
};

}  // namespace headstock::interp

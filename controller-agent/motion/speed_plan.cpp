#include "motion/speed_plan.hpp"

#include <algorithm>

namespace headstock::motion {

void SpeedPlan::begin(std::uint64_t first, std::uint64_t end) {
  for (std::size_t p = 0; p < kPlanCount; ++p) {
    double ahead = 0;  // v² where the cell ends
    for (std::uint64_t k = end; k-- > first;) {
      Cell& cell = cells_[k];
      if (cell.stop) ahead = 0;
      ahead = std::min(cell.ceiling[p], cell.entry_before(ahead, cell.end - cell.begin));
      cell.entry[p].store(ahead, std::memory_order_release);
    }
  }
}

void SpeedPlan::raise(std::uint64_t oldest, std::uint64_t first) {
  for (std::size_t p = 0; p < kPlanCount; ++p) {
    double ahead = cells_[first].entry[p].load(std::memory_order_relaxed);
    for (std::uint64_t k = first; k-- > oldest;) {
      Cell& cell = cells_[k];
      if (cell.stop) ahead = 0;
      const double entry = std::min(cell.ceiling[p], cell.entry_before(ahead, cell.end - cell.begin));
      // What is behind is unchanged as soon as one entry is.
      if (entry <= cell.entry[p].load(std::memory_order_relaxed)) break;
      cell.entry[p].store(entry, std::memory_order_release);
      ahead = entry;
    }
  }
}

}  // namespace headstock::motion

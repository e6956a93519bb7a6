#include "motion/speed_plan.hpp"

#include <algorithm>

namespace headstock::motion {

void SpeedPlan::extend(std::uint64_t oldest, std::uint64_t first, std::uint64_t end) {
  for (std::size_t p = 0; p < kPlanCount; ++p) {
    double ahead = 0;  // v² where the cell ends
    for (std::uint64_t k = end; k-- > oldest;) {
      Cell& cell = cells_[k];
      if (cell.stop) ahead = 0;
      const double twice = 2 * (cell.end - cell.begin);
      double entry = std::min(cell.ceiling[p], ahead + twice * cell.most_acceleration);
      for (std::size_t i = 0; i < cell.axes; ++i) {
        // Curvature counts where it leaves least: at the entry when it costs, at the end of the cell when it
        // helps.
        const double loss = twice * cell.loss_down[i], gain = ahead + twice * cell.gain[i];
        entry = std::min(entry, loss > 0 ? gain / (1 + loss) : gain - loss * ahead);
      }
      // Older cells: what is behind is unchanged as soon as one entry is.
      if (k < first) {
        if (entry <= cell.entry[p].load(std::memory_order_relaxed)) break;
      }
      cell.entry[p].store(entry, std::memory_order_release);
      ahead = entry;
    }
  }
}

}  // namespace headstock::motion

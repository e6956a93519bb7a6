// The backward pass of the look-ahead: from which speed at the beginning of each cell can the path ahead be
// followed? Look-ahead thread; the real-time thread reads the results while they are raised.
#pragma once

#include "motion/cells.hpp"
#include "motion/ring.hpp"

namespace headstock::motion {

class SpeedPlan {
 public:
  explicit SpeedPlan(Ring<Cell>& cells) : cells_(cells) {}
  /// Cells [first, end) are new; standing still at the end of the last. Raises what the new cells allow for
  /// the older ones down to `oldest`. Order of writing (back to front) is part of the contract with the
  /// reader.
  void extend(std::uint64_t oldest, std::uint64_t first, std::uint64_t end);

 private:
  Ring<Cell>& cells_;
};

}  // namespace headstock::motion

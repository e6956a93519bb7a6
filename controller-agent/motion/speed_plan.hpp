// The backward pass of the look-ahead: from which speed at the beginning of each cell can the path ahead be
// followed? Look-ahead thread; the real-time thread reads the results while they are raised.
#pragma once

#include "motion/cells.hpp"
#include "motion/ring.hpp"

namespace headstock::motion {

class SpeedPlan {
 public:
  explicit SpeedPlan(Ring<Cell>& cells) : cells_(cells) {}
  /// Cells [first, end) are new and not yet published; standing still at the end of the last.
  void begin(std::uint64_t first, std::uint64_t end);
  /// Those from `first` on are published: raises what they allow for the older ones down to `oldest`. Never before: a
  /// reader that comes to the end of what is published must find a plan that stops there, however long the
  /// look-ahead is kept from publishing. Order of writing (back to front) is part of the contract with the reader.
  void raise(std::uint64_t oldest, std::uint64_t first);

 private:
  Ring<Cell>& cells_;
};

}  // namespace headstock::motion

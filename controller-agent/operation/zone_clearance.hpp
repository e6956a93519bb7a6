// Stored stroke checks 2 and 3 look at the programmed path. What is commanded leaves it: corners are rounded
// inside the tolerance, and behind a filter after interpolation the axes lag, which cuts corners and makes
// arcs smaller. Near a zone neither may be, because the way around its corner would lead through it: there
// the axes go the programmed path itself, as gently as the filter would have, and stop at its corners.
#pragma once

#include <vector>

#include "axes/forbidden_zone.hpp"
#include "machine/machine.hpp"
#include "motion/kernel.hpp"

namespace headstock::operation {

using machine::AxisVector;

/// Look-ahead thread.
class ZoneClearance {
 public:
  explicit ZoneClearance(const machine::Machine& machine) : machine_(machine) {}

  /// In force for the moves that follow.
  void set(std::vector<axes::Zone> zones) { zones_ = std::move(zones); }

  /// May the filter of this shape (AccelerationShape::after) take the axes into a zone while this move is
  /// interpolated? Of threads always: a change of shape within a chain of them would be a stop.
  bool forbids_filter(const AxisVector& start, const motion::Move& move,
                      const motion::AccelerationShape& shape) const;

  /// How far corners may be rounded that nothing depends on any more; no stop is needed for it [mm].
  static constexpr double kAlmostExact_mm = 0.001;

  /// Does a corner of the move, rounded by this much, come near a zone?
  bool forbids_rounding(const AxisVector& start, const motion::Move& move, double rounding_mm) const;

 private:
  const machine::Machine& machine_;
  std::vector<axes::Zone> zones_;
};

}  // namespace headstock::operation

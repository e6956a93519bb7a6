#include "operation/zone_clearance.hpp"

#include <algorithm>

namespace headstock::operation {

bool ZoneClearance::forbids_filter(const AxisVector& start, const motion::Move& move,
                                   const motion::AccelerationShape& shape) const {
  if (zones_.empty() || !shape.filters()) return false;
  if (std::holds_alternative<motion::ThreadFeed>(move.feed)) return true;
  // What the filter makes of the axes is within their lag of where the interpolation is, whatever they did
  // before; and nowhere else than between where they were, so that it never leaves a box that the path stays
  // in.
  const double period_s = machine_.period_us * 1e-6;
  AxisVector distance{};
  for (std::size_t i = 0; i < machine_.axes.size(); ++i) {
    const machine::Axis& axis = machine_.axes[i];
    const double fastest_mm_s = std::max(axis.rapid_mm_min, axis.max_feed_mm_min) / 60;
    distance[i] = fastest_mm_s * (shape.lag_s(i) + period_s) + machine_.allowance(i, move.tolerance_mm);
  }
  return std::any_of(zones_.begin(), zones_.end(), [&](const axes::Zone& zone) {
    return !zone.outside_forbidden && axes::comes_near(zone, start, move.geometry, distance);
  });
}

bool ZoneClearance::forbids_rounding(const AxisVector& start, const motion::Move& move,
                                     double rounding_mm) const {
  AxisVector distance{};
  for (std::size_t i = 0; i < machine_.axes.size(); ++i) distance[i] = machine_.allowance(i, rounding_mm);
  return std::any_of(zones_.begin(), zones_.end(), [&](const axes::Zone& zone) {
    return axes::comes_near(zone, start, move.geometry, distance);
  });
}

}  // namespace headstock::operation

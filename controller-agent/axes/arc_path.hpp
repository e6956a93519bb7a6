// Positions along an arc, helix or spiral as the kernel traces it: radius and the axes outside the plane are
// linear in the angle.
#pragma once

#include <cmath>

#include "motion/kernel.hpp"

namespace headstock::axes {

class ArcPath {
 public:
  ArcPath(const machine::AxisVector& start, const motion::Arc& arc)
      : start_(start),
        arc_(arc),
        start_angle_(std::atan2(start[arc.axis_2] - arc.center_2, start[arc.axis_1] - arc.center_1)),
        start_radius_(std::hypot(start[arc.axis_1] - arc.center_1, start[arc.axis_2] - arc.center_2)),
        end_radius_(std::hypot(arc.end[arc.axis_1] - arc.center_1, arc.end[arc.axis_2] - arc.center_2)) {}

  /// @param turned angle passed since the start, rad, of the sign of the sweep.
  double at(std::size_t axis, double turned) const {
    const double share = arc_.angle_rad == 0 ? 1 : turned / arc_.angle_rad;
    if (axis != arc_.axis_1 && axis != arc_.axis_2)
      return start_[axis] + (arc_.end[axis] - start_[axis]) * share;
    const double radius = start_radius_ + (end_radius_ - start_radius_) * share;
    const double angle = start_angle_ + turned;
    return axis == arc_.axis_1 ? arc_.center_1 + radius * std::cos(angle)
                               : arc_.center_2 + radius * std::sin(angle);
  }
  machine::AxisVector position(double turned) const {
    machine::AxisVector p{};
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = at(i, turned);
    return p;
  }
  double sweep() const { return arc_.angle_rad; }
  double start_angle() const { return start_angle_; }
  double start_radius() const { return start_radius_; }
  double end_radius() const { return end_radius_; }
  const motion::Arc& arc() const { return arc_; }

 private:
  machine::AxisVector start_;
  motion::Arc arc_;
  double start_angle_, start_radius_, end_radius_;
};

}  // namespace headstock::axes

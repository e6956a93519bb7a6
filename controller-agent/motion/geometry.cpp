#include "motion/geometry.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::motion {

double distance(const AxisVector& a, const AxisVector& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

AxisVector tolerance_weights(const machine::Machine& machine) {
  AxisVector weights;
  weights.fill(1);
  for (std::size_t i = 0; i < machine.axes.size(); ++i) weights[i] = 1 / machine.allowance(i, 1);
  return weights;
}

Curve Curve::from(const AxisVector& start, const Move& move, std::size_t axes) {
  Curve c;
  c.start = start;
  AxisVector delta{};
  const Arc* arc = std::get_if<Arc>(&move.geometry);
  const AxisVector& target = arc ? arc->end : std::get<Line>(move.geometry).end;
  for (std::size_t i = 0; i < axes; ++i) {
    c.end[i] = target[i];
    delta[i] = target[i] - start[i];
  }
  double linear = 0;
  if (!arc || arc->angle_rad == 0) {
    c.length = distance(c.start, c.end);
  } else {
    c.is_arc = true;
    c.axis_1 = arc->axis_1;
    c.axis_2 = arc->axis_2;
    c.center_1 = arc->center_1;
    c.center_2 = arc->center_2;
    const double x = start[c.axis_1] - c.center_1, y = start[c.axis_2] - c.center_2;
    c.angle_0 = std::atan2(y, x);
    c.radius = std::hypot(x, y);
    const double end_radius = std::hypot(c.end[c.axis_1] - c.center_1, c.end[c.axis_2] - c.center_2);
    // The end point wins over the angle: the few µm a program is off become a slight spiral, not a jump.
    const double end_angle = std::atan2(c.end[c.axis_2] - c.center_2, c.end[c.axis_1] - c.center_1);
    const double signed_sweep =
        end_radius < kNoLength
            ? arc->angle_rad
            : arc->angle_rad + std::remainder(end_angle - c.angle_0 - arc->angle_rad, 2 * M_PI);
    const double sweep = std::abs(signed_sweep);
    delta[c.axis_1] = delta[c.axis_2] = 0;
    for (const double d : delta) linear += d * d;
    const double growth = end_radius - c.radius, largest = std::max(end_radius, c.radius);
    c.length = std::sqrt(largest * largest * sweep * sweep + growth * growth + linear);
    if (c.length > 0) {
      c.angle_per_mm = signed_sweep / c.length;
      c.radius_per_mm = std::abs(growth) < 1e-9 ? 0.0 : growth / c.length;
    }
  }
  if (c.length > 0)
    for (std::size_t i = 0; i < axes; ++i) c.direction[i] = delta[i] / c.length;
  return c;
}

AxisVector Curve::point(double u, double outward) const {
  if (u >= length && outward == 1) return end;
  AxisVector p;
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = start[i] + direction[i] * u;
  if (is_arc) {
    const double angle = angle_0 + angle_per_mm * u, r = (radius + radius_per_mm * u) * outward;
    p[axis_1] = center_1 + r * std::cos(angle);
    p[axis_2] = center_2 + r * std::sin(angle);
  }
  return p;
}

AxisVector Curve::tangent(double u) const {
  AxisVector t = direction;
  if (is_arc) {
    const double angle = angle_0 + angle_per_mm * u, r = radius + radius_per_mm * u;
    t[axis_1] = radius_per_mm * std::cos(angle) - r * angle_per_mm * std::sin(angle);
    t[axis_2] = radius_per_mm * std::sin(angle) + r * angle_per_mm * std::cos(angle);
  }
  return t;
}

}  // namespace headstock::motion

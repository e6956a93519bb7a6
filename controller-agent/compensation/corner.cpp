#include "compensation/corner.hpp"

#include <algorithm>
#include <numbers>

namespace headstock::comp {
namespace {

constexpr double kTangent = 1e-4;    // rad: what rounding of end points does to a tangent
constexpr double kSlack_mm = 0.001;  // a cut that just uses a whole segment up

// The point of the segment at a straight distance from its end or start. @return false: it is not that long.
bool point_at(const Segment& segment, bool from_end, double distance, Point& out) {
  if (!segment.arc) {
    const double whole = length(segment.to - segment.from);
    if (distance > whole + kSlack_mm) return false;
    const Point d = segment.direction_at_start() * std::min(distance, whole);
    out = from_end ? segment.to - d : segment.from + d;
    return true;
  }
  const double radius = from_end ? segment.end_radius() : segment.start_radius();
  const double sine = distance / (2 * radius);
  if (sine > 1) return false;
  const double angle = 2 * std::asin(sine);
  if (angle > segment.sweep + kSlack_mm / radius) return false;
  const Point arm = (from_end ? segment.to : segment.from) - segment.center;
  const double by = segment.turn * (from_end ? -angle : angle);
  out = segment.center +
        Point{arm.u * std::cos(by) - arm.v * std::sin(by), arm.u * std::sin(by) + arm.v * std::cos(by)};
  return true;
}

// Where a circle about `center` that is tangent to the segment touches it; false when that is outside of it.
bool touch_point(const Segment& segment, Point center, bool near_end, Point& out) {
  if (!segment.arc) {
    const Point d = segment.direction_at_start();
    const double at = dot(center - segment.from, d);
    if (at < -kSlack_mm || at > segment.length_mm() + kSlack_mm) return false;
    out = segment.from + d * at;
    return true;
  }
  const Point arm = center - segment.center;
  const double distance = length(arm);
  if (distance < 1e-9) return false;
  const double radius = near_end ? segment.end_radius() : segment.start_radius();
  out = segment.center + arm * (radius / distance);
  const double slack = kSlack_mm / radius;
  const double rest = near_end ? swept(out, segment.to, segment.center, segment.turn)
                               : swept(segment.from, out, segment.center, segment.turn);
  return rest <= segment.sweep + slack || rest >= 2 * std::numbers::pi - slack;
}

bool chamfer(const Segment& a, const Segment& b, double size, ChamferSize meaning, Point& start, Point& end) {
  if (meaning == ChamferSize::cut_back)
    return point_at(a, true, size, start) && point_at(b, false, size, end);
  // Equal distances from the corner whose chord has the length: by halving, for arcs have no formula.
  const double most = std::min(a.length_mm(), b.length_mm()) + kSlack_mm;
  double low = 0, high = size / 2;
  for (;; low = high, high = std::min(high * 1.1, most)) {
    if (!point_at(a, true, high, start) || !point_at(b, false, high, end)) return false;
    if (length(end - start) >= size) break;
    if (high >= most) return false;
  }
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    if (!point_at(a, true, middle, start) || !point_at(b, false, middle, end)) return false;
    (length(end - start) < size ? low : high) = middle;
  }
  return true;
}

}  // namespace

CutCorner cut_corner(const Segment& first, const Segment& second, CornerShape shape, double size,
                     ChamferSize meaning) {
  CutCorner cut;
  const Point before = first.direction_at_end(), after = second.direction_at_start();
  const double turn = std::atan2(cross(before, after), dot(before, after));
  if (std::fabs(turn) < kTangent) {
    cut.fault = CornerFault::not_needed;
    return cut;
  }
  cut.fault = CornerFault::too_large;
  Point start, end;
  if (shape == CornerShape::chamfer) {
    if (!chamfer(first, second, size, meaning, start, end)) return cut;
    cut.inserted = line(start, end);
  } else {
    const double side = turn > 0 ? 1 : -1;  // the arc lies on the side that the path turns to
    const Crossings centers =
        intersect(offset_curve(first, side * size, true), offset_curve(second, side * size, false));
    if (centers.count == 0) return cut;
    Point center = centers.point[0];
    if (centers.count == 2 && length(centers.point[1] - first.to) < length(centers.point[0] - first.to)) {
      center = centers.point[1];
    }
    if (!touch_point(first, center, true, start) || !touch_point(second, center, false, end)) return cut;
    cut.inserted = arc(start, end, center, side);
  }
  cut.first = first.ending_at(start);
  cut.second = second.beginning_at(end);
  cut.fault = CornerFault::none;
  return cut;
}

}  // namespace headstock::comp

#include "compensation/geometry.hpp"

#include <algorithm>
#include <numbers>

namespace headstock::comp {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr double kSameRay = 1e-9;  // rad

}  // namespace

double Segment::length_mm() const {
  return arc ? sweep * (start_radius() + end_radius()) / 2 : length(to - from);
}

Segment Segment::ending_at(Point point) const {
  Segment cut = *this;
  cut.to = point;
  if (arc) cut.sweep = swept(from, point, center, turn);
  return cut;
}

Segment Segment::beginning_at(Point point) const {
  Segment cut = *this;
  cut.from = point;
  if (arc) cut.sweep = swept(point, to, center, turn);
  return cut;
}

Segment arc(Point from, Point to, Point center, double turn) {
  Segment segment;
  segment.from = from;
  segment.to = to;
  segment.arc = true;
  segment.center = center;
  segment.turn = turn;
  segment.sweep = swept(from, to, center, turn);
  if (segment.sweep < kSameRay) segment.sweep = kFullTurn;
  return segment;
}

double swept(Point from, Point to, Point center, double turn) {
  const Point a = from - center, b = to - center;
  double angle = turn * std::atan2(cross(a, b), dot(a, b));
  if (angle < -kSameRay) angle += kFullTurn;
  return std::max(0.0, angle);
}

Curve offset_curve(const Segment& segment, double distance, bool at_end) {
  Curve curve;
  if (segment.arc) {
    curve.circle = true;
    curve.center = segment.center;
    curve.radius = (at_end ? segment.end_radius() : segment.start_radius()) - segment.turn * distance;
  } else {
    curve.direction = segment.direction_at_start();
    curve.point = segment.from + left_of(curve.direction) * distance;
  }
  return curve;
}

Crossings intersect(const Curve& a, const Curve& b) {
  Crossings found;
  if (!a.circle && !b.circle) {
    const double sine = cross(a.direction, b.direction);
    if (std::fabs(sine) < 1e-12) return found;
    found.point[0] = a.point + a.direction * (cross(b.point - a.point, b.direction) / sine);
    found.count = 1;
    return found;
  }
  if (a.circle && b.circle) {
    const Point between = b.center - a.center;
    const double d = length(between);
    if (d < 1e-12 || a.radius <= 0 || b.radius <= 0) return found;
    const double along = (d * d + a.radius * a.radius - b.radius * b.radius) / (2 * d);
    const double square = a.radius * a.radius - along * along;
    // Circles that touch must not miss each other by the last digit.
    if (square < -1e-6 * a.radius) return found;
    const double up = std::sqrt(std::max(0.0, square));
    const Point e = between * (1 / d);
    found.point[0] = a.center + e * along + left_of(e) * up;
    found.point[1] = a.center + e * along - left_of(e) * up;
    found.count = 2;
    return found;
  }
  const Curve& straight = a.circle ? b : a;
  const Curve& round = a.circle ? a : b;
  if (round.radius <= 0) return found;
  const double along = dot(round.center - straight.point, straight.direction);
  const Point foot = straight.point + straight.direction * along;
  const Point out = foot - round.center;
  const double square = round.radius * round.radius - dot(out, out);
  if (square < -1e-6 * round.radius) return found;
  const double half = std::sqrt(std::max(0.0, square));
  found.point[0] = foot + straight.direction * half;
  found.point[1] = foot - straight.direction * half;
  found.count = 2;
  return found;
}

}  // namespace headstock::comp

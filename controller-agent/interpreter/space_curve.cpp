#include "interpreter/space_curve.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headstock::interp {
namespace {

constexpr double kSame_mm = 1e-9;
constexpr double kFullTurn = 2 * std::numbers::pi;

Point3 operator+(const Point3& a, const Point3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Point3 operator-(const Point3& a, const Point3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Point3 operator*(const Point3& a, double k) {
  return {a[0] * k, a[1] * k, a[2] * k};
}
double dot(const Point3& a, const Point3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Point3 cross(const Point3& a, const Point3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Point3& a) {
  return std::sqrt(dot(a, a));
}

// The angle from `along` to a vector in the plane, [0, 2π); dust below a turn's end counts as the start.
double angle_of(const SpaceCurve& curve, const Point3& vector) {
  double angle = std::atan2(dot(vector, curve.across), dot(vector, curve.along));
  if (angle < 0) angle += kFullTurn;
  return angle > kFullTurn - 1e-9 || angle < 1e-9 ? 0 : angle;
}

}  // namespace

double SpaceCurve::radius_at(double turned) const {
  if (angle <= 0 || radius_from == radius_to) return radius_from;
  const double part = turned / angle;
  return logarithmic ? radius_from * std::pow(radius_to / radius_from, part)
                     : radius_from + (radius_to - radius_from) * part;
}

Point3 SpaceCurve::at(double turned) const {
  const double radius = radius_at(turned);
  const double phase = std::fmod(turned, kFullTurn);
  const double part = angle > 0 ? turned / angle : 1;
  return pole + along * (radius * std::cos(phase)) + across * (radius * std::sin(phase)) + leg * part;
}

double SpaceCurve::chord(double turned, double tolerance) const {
  // The height of a chord is at most |second derivative|·δ²/8; in polar coordinates that derivative is
  // (r″ − r, 2r′), which near the pole is all growth and no radius.
  const auto bend = [this](double at_angle) {
    const double radius = radius_at(at_angle);
    if (angle <= 0) return radius;
    const double rate = logarithmic ? std::log(radius_to / radius_from) / angle : 0;
    const double first = logarithmic ? rate * radius : (radius_to - radius_from) / angle;
    return std::hypot(rate * rate * radius - radius, 2 * first);
  };
  const auto step = [tolerance](double size) { return std::sqrt(8 * tolerance / std::max(size, tolerance)); };
  constexpr double kMost = std::numbers::pi / 16;
  const double guess = std::min(step(bend(turned)), kMost);
  return std::min(step(std::max(bend(turned), bend(std::min(turned + guess, angle)))), kMost);
}

CurveError three_point_arc(const Point3& start, const Point3& middle, const Point3& end, SpaceCurve& out) {
  const Point3 a = middle - start, b = end - start;
  const Point3 normal = cross(a, b);
  const double size = length(normal);
  // The sine of the angle between the chords tells a line from an arc whatever their lengths are.
  if (size <= 1e-9 * length(a) * length(b) || size == 0) return CurveError::straight;
  const Point3 n = normal * (1 / size);
  // Circumcentre relative to the start.
  const Point3 center = (cross(n, a) * dot(b, b) * -1.0 + cross(n, b) * dot(a, a)) * (-1 / (2 * size));
  out = {};
  out.pole = start + center;
  const Point3 from = start - out.pole;
  out.radius_from = out.radius_to = length(from);
  out.along = from * (1 / out.radius_from);
  out.across = cross(n, out.along);
  out.angle = angle_of(out, end - out.pole);
  return CurveError::none;
}

namespace {

// Puts the plane through the start; the part of start → end that leaves it is the leg.
CurveError set_plane(const Point3& normal, Point3& n) {
  const double size = length(normal);
  if (!(size > 0)) return CurveError::no_normal;
  n = normal * (1 / size);
  return CurveError::none;
}

}  // namespace

CurveError spiral_about_end(const Point3& start, const Point3& end, const Point3& normal, bool pole_is_end,
                            double angle, SpaceCurve& out) {
  Point3 n;
  if (const CurveError error = set_plane(normal, n); error != CurveError::none) return error;
  const Point3 way = end - start;
  out = {};
  out.leg = n * dot(way, n);
  const Point3 flat = way - out.leg;
  const double size = length(flat);
  if (size < kSame_mm) return CurveError::no_way;
  out.angle = angle;
  if (pole_is_end) {
    out.pole = start + flat;
    out.radius_from = size;
    out.along = flat * (-1 / size);
    out.across = cross(n, out.along);
  } else {
    out.pole = start;
    out.radius_to = size;
    // The end direction is known, the start direction lies `angle` before it.
    const Point3 to = flat * (1 / size);
    const double back = std::fmod(angle, kFullTurn);
    out.along = to * std::cos(back) - cross(n, to) * std::sin(back);
    out.across = cross(n, out.along);
  }
  return CurveError::none;
}

CurveError spiral_about_pole(const Point3& start, const Point3& end, const Point3& pole, const Point3& normal,
                             double extra_turns, bool logarithmic, double off_plane, SpaceCurve& out) {
  Point3 n;
  if (const CurveError error = set_plane(normal, n); error != CurveError::none) return error;
  const double height = dot(pole - start, n);
  if (std::fabs(height) > off_plane + kSame_mm) return CurveError::pole_off_plane;
  out = {};
  out.pole = pole - n * height;
  const Point3 from = start - out.pole;
  out.radius_from = length(from);
  if (out.radius_from < kSame_mm) return CurveError::pole_on_start;
  out.along = from * (1 / out.radius_from);
  out.across = cross(n, out.along);
  const Point3 to = end - out.pole;
  out.leg = n * dot(to, n);
  const Point3 flat = to - out.leg;
  out.radius_to = length(flat);
  if (logarithmic && out.radius_to < kSame_mm) return CurveError::radius;
  const double between = angle_of(out, flat);
  // Start and end on one ray: at one radius a full turn (a circle), otherwise the turns that P says, and one
  // at least.
  out.angle = between + extra_turns * kFullTurn;
  if (between == 0 && (extra_turns == 0 || std::fabs(out.radius_to - out.radius_from) < kSame_mm))
    out.angle += kFullTurn;
  out.logarithmic = logarithmic;
  return CurveError::none;
}

}  // namespace headstock::interp

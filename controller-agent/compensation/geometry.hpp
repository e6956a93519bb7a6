// Lines and arcs in the plane that compensation, chamfers and corner rounds work in. Millimetres; `u` is the
// plane's first axis (X of G17, Z of G18, Y of G19), `v` the second one, both as slide positions (a radius,
// never a diameter). Pure values, any thread, no allocation.
#pragma once

#include <array>
#include <cmath>

namespace headstock::comp {

struct Point {
  double u = 0, v = 0;
};
constexpr Point operator+(Point a, Point b) {
  return {a.u + b.u, a.v + b.v};
}
constexpr Point operator-(Point a, Point b) {
  return {a.u - b.u, a.v - b.v};
}
constexpr Point operator*(Point a, double k) {
  return {a.u * k, a.v * k};
}
constexpr double dot(Point a, Point b) {
  return a.u * b.u + a.v * b.v;
}
/// > 0: `b` points to the left of `a`.
constexpr double cross(Point a, Point b) {
  return a.u * b.v - a.v * b.u;
}
constexpr Point left_of(Point a) {
  return {-a.v, a.u};
}
inline double length(Point a) {
  return std::sqrt(dot(a, a));
}
/// Of length 1; of nothing: {1, 0}.
inline Point unit(Point a) {
  const double l = length(a);
  return l > 0 ? a * (1 / l) : Point{1, 0};
}

/// A straight move, or an arc with the sense of its turn. A spiral is an arc whose end is at another distance
/// from the centre than its start.
struct Segment {
  Point from, to;
  bool arc = false;
  Point center;
  double turn = 0;   ///< +1 counter-clockwise, -1 clockwise; arcs only
  double sweep = 0;  ///< angle turned through [rad], > 0; arcs only

  /// Unit vectors.
  Point direction_at_start() const { return arc ? left_of(unit(from - center)) * turn : unit(to - from); }
  Point direction_at_end() const { return arc ? left_of(unit(to - center)) * turn : unit(to - from); }
  double start_radius() const { return length(from - center); }
  double end_radius() const { return length(to - center); }
  double length_mm() const;
  /// Ends or begins at another point of the same line or circle; the sweep follows.
  Segment ending_at(Point point) const;
  Segment beginning_at(Point point) const;
};

inline Segment line(Point from, Point to) {
  Segment segment;
  segment.from = from;
  segment.to = to;
  return segment;
}
/// @param turn +1 counter-clockwise, -1 clockwise. Start and end on one ray are a full circle.
Segment arc(Point from, Point to, Point center, double turn);

/// The angle from `from` to `to` about the centre in the sense of `turn`, [0, 2π).
double swept(Point from, Point to, Point center, double turn);

/// The whole line or circle that a segment is part of, moved sideways.
struct Curve {
  bool circle = false;
  Point point;        ///< on the line
  Point direction;    ///< of the line, unit vector
  Point center;       ///< of the circle
  double radius = 0;  ///< ≤ 0: there is no such circle
};
/// @param distance to the left of the travel [mm]; negative: to the right.
/// @param at_end for a spiral: the circle through its end instead of its start
Curve offset_curve(const Segment& segment, double distance, bool at_end);

struct Crossings {
  std::array<Point, 2> point;
  int count = 0;
};
Crossings intersect(const Curve& a, const Curve& b);

}  // namespace headstock::comp

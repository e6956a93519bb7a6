#include "compensation/drawing.hpp"

#include <numbers>

namespace headstock::comp {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

// sin and cos of the round angles of drawings without the dust of π.
Point direction(double degrees) {
  const double turned = std::remainder(degrees, 360.0);
  if (turned == 0) return {1, 0};
  if (turned == 90) return {0, 1};
  if (turned == -90) return {0, -1};
  if (std::fabs(turned) == 180) return {-1, 0};
  return {std::cos(turned * kRadians), std::sin(turned * kRadians)};
}

bool parallel(Point a, Point b, double degrees) {
  return std::fabs(cross(a, b)) <= std::sin(degrees * kRadians) + 1e-12;
}

}  // namespace

std::optional<Point> at_first(Point from, double angle_deg, double u, double parallel_deg) {
  const Point d = direction(angle_deg);
  if (parallel(d, {0, 1}, parallel_deg)) return std::nullopt;
  return Point{u, from.v + (u - from.u) * d.v / d.u};
}

std::optional<Point> at_second(Point from, double angle_deg, double v, double parallel_deg) {
  const Point d = direction(angle_deg);
  if (parallel(d, {1, 0}, parallel_deg)) return std::nullopt;
  return Point{from.u + (v - from.v) * d.u / d.v, v};
}

std::optional<Point> meet(Point from, double first_deg, Point to, double second_deg, double parallel_deg) {
  const Point a = direction(first_deg), b = direction(second_deg);
  if (parallel(a, b, parallel_deg)) return std::nullopt;
  return from + a * (cross(to - from, b) / cross(a, b));
}

}  // namespace headstock::comp

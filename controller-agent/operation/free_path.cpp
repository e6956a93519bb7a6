#include "operation/free_path.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::operation {

namespace {

using machine::AxisVector;

constexpr double kStraight = 1e-4;  // change of direction that is none, rad

double length(const AxisVector& way) {
  double sum = 0;
  for (const double each : way) sum += each * each;
  return std::sqrt(sum);
}

AxisVector between(const AxisVector& from, const AxisVector& to) {
  AxisVector way{};
  for (std::size_t i = 0; i < way.size(); ++i) way[i] = to[i] - from[i];
  return way;
}

bool same_direction(const AxisVector& one, const AxisVector& other) {
  const double a = length(one), b = length(other);
  if (!(a > 0) || !(b > 0)) return true;
  AxisVector change{};
  for (std::size_t i = 0; i < change.size(); ++i) change[i] = one[i] / a - other[i] / b;
  return length(change) < kStraight;
}

}  // namespace

double AxisCourse::time_s() const {
  const double way = std::abs(way_mm);
  if (way * acceleration_mm_s2 <= rate_mm_s * rate_mm_s) return 2 * std::sqrt(way / acceleration_mm_s2);
  return way / rate_mm_s + rate_mm_s / acceleration_mm_s2;
}

double AxisCourse::at(double time_s) const {
  const double whole_s = this->time_s();
  if (time_s >= whole_s) return way_mm;
  // The same from both ends.
  const bool second_half = time_s > 0.5 * whole_s;
  const double t = second_half ? whole_s - time_s : time_s;
  const double up_s = std::min(rate_mm_s / acceleration_mm_s2, 0.5 * whole_s);
  const double behind = t <= up_s ? 0.5 * acceleration_mm_s2 * t * t
                                  : acceleration_mm_s2 * up_s * (t - 0.5 * up_s);
  return std::copysign(second_half ? std::abs(way_mm) - behind : behind, way_mm);
}

std::vector<AxisVector> free_path(const AxisVector& from, std::span<const AxisCourse> courses) {
  double whole_s = 0;
  for (const AxisCourse& course : courses) whole_s = std::max(whole_s, course.time_s());
  const auto place = [&](double time_s) {
    AxisVector at = from;
    for (std::size_t i = 0; i < courses.size(); ++i) at[i] += courses[i].at(time_s);
    return at;
  };
  std::vector<AxisVector> corners;
  AxisVector begin = from, last = from;  // of the piece that is made longer, and its end so far
  for (std::size_t k = 1; k <= kMostFreePieces; ++k) {
    const AxisVector next = place(whole_s * static_cast<double>(k) / static_cast<double>(kMostFreePieces));
    if (k > 1 && !same_direction(between(begin, last), between(last, next))) {
      corners.push_back(last);
      begin = last;
    }
    last = next;
  }
  corners.push_back(last);
  return corners;
}

}  // namespace headstock::operation

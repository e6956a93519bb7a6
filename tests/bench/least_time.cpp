#include "least_time.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace headstock::bench {
namespace {

constexpr double kMostSquare = 1e6;  // a step of (nearly) no way

/// before * x[k] + after * x[k + 1] <= bound
struct Row {
  double before, after, bound;
};
using Rows = std::array<Row, 2 * kPathAxes>;

/// Both senses of every axis' acceleration at the sample between two steps.
Rows rows_between(const PathStep& from, const PathStep& to, double period_s, double acceleration) {
  Rows rows{};
  for (std::size_t i = 0; i < kPathAxes; ++i) {
    const double unit = 4 * period_s * period_s;
    const double before = (to.way[i] - 3 * from.way[i]) / unit, after = (3 * to.way[i] - from.way[i]) / unit;
    const double bound = std::max(acceleration, std::abs(before + after));
    rows[2 * i] = {before, after, bound};
    rows[2 * i + 1] = {-before, -after, bound};
  }
  return rows;
}

/// Highest x[k] for which an x[k + 1] in 0 … `most_after` exists: each row that bounds x[k + 1] from above
/// with each that bounds it from below leaves a bound on x[k].
double highest_before(const Rows& rows, double most_before, double most_after) {
  struct Side {
    double slope, at_zero;
  };
  std::array<Side, 2 * kPathAxes + 1> above,
      below;  // x[k + 1] <= at_zero - slope x[k]; >= slope x[k] - at_zero
  std::size_t aboves = 0, belows = 0;
  above[aboves++] = {0, most_after};
  below[belows++] = {0, 0};
  double most = most_before;
  for (const Row& row : rows) {
    if (row.after > 0)
      above[aboves++] = {row.before / row.after, row.bound / row.after};
    else if (row.after < 0)
      below[belows++] = {row.before / -row.after, row.bound / -row.after};
    else if (row.before > 0)
      most = std::min(most, row.bound / row.before);
  }
  for (std::size_t a = 0; a < aboves; ++a)
    for (std::size_t b = 0; b < belows; ++b) {
      const double slope = above[a].slope + below[b].slope;
      if (slope > 0) most = std::min(most, (above[a].at_zero + below[b].at_zero) / slope);
    }
  return most;
}

double highest_after(const Rows& rows, double before, double most_after) {
  // The room is that of roundings: a row on which the next step hardly counts must not decide by them.
  constexpr double room = 1 + 1e-7;
  double most = most_after;
  for (const Row& row : rows)
    if (row.after > 0) most = std::min(most, (row.bound * room - row.before * before) / row.after);
  return most;
}

/// By velocity and feed; `at_rest`: a step that begins or ends at rest is gone at half its last speed.
double ceiling(const PathStep& step, double period_s, const PathLimits& limits, bool at_rest) {
  double most = kMostSquare, length = 0;
  const auto keep_speed = [&](double way, double speed) {
    const double times = speed * period_s / way;
    if (way > 0) most = std::min(most, times * times);
  };
  for (const double way : step.way) {
    length = std::hypot(length, way);
    keep_speed(std::abs(way), limits.velocity);
    if (at_rest && way != 0)
      most = std::min(most, limits.acceleration * period_s * period_s / (2 * std::abs(way)));
  }
  keep_speed(length, step.feed);
  return std::max(1.0, most);
}

}  // namespace

double least_time(std::vector<PathStep>& path, double period_s, const PathLimits& limits) {
  if (path.empty()) return 0;
  std::vector<double> highest(path.size());
  for (std::size_t k = path.size(); k-- > 0;) {
    highest[k] = ceiling(path[k], period_s, limits, k == 0 || k + 1 == path.size());
    if (k + 1 < path.size())
      highest[k] =
          std::max(1.0, highest_before(rows_between(path[k], path[k + 1], period_s, limits.acceleration),
                                       highest[k], highest[k + 1]));
  }
  double square = highest[0], time = 0;
  for (std::size_t k = 0; k < path.size(); ++k) {
    if (k > 0)
      square = std::max(1.0, highest_after(rows_between(path[k - 1], path[k], period_s, limits.acceleration),
                                           square, highest[k]));
    path[k].speed_up = std::sqrt(square);
    time += period_s / path[k].speed_up;
  }
  return time;
}

}  // namespace headstock::bench

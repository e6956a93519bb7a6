// What rounding gives: the feed along the path that is left, the whole tolerance for a corner by itself, and stops
// that last no longer than they must.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rig.hpp"

namespace headstock::motion {
namespace {

using rig::line;

constexpr double kPeriod_s = 1e-3, kTolerance_mm = 0.01;

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

/// Legs that turn by `degrees`, to and fro.
std::vector<Move> zigzag(int legs, double leg_mm, double degrees, double mm_s) {
  const double half = radians(degrees) / 2;
  std::vector<Move> moves;
  for (int i = 1; i <= legs; ++i)
    moves.push_back(line({i * leg_mm * std::cos(half), i % 2 ? leg_mm * std::sin(half) : 0}, mm_s, kTolerance_mm));
  return moves;
}

double way(const AxisVector& from, const AxisVector& to) {
  return std::hypot(to[0] - from[0], to[1] - from[1]);
}

TEST(Corner, TheFeedIsThatOfTheToolOnTheRoundedPath) {
  constexpr double kFeed_mm_s = 8;
  constexpr int kLegs = 100;
  for (const double jerk : {1e12, 500'000.0}) {
    for (const double degrees : {5.0, 30.0, 60.0}) {
      const auto machine = rig::machine(2, 500, 2000, jerk);
      Kernel kernel(machine);
      const auto run = rig::run(kernel, machine, zigzag(kLegs, 2, degrees, kFeed_mm_s));
      ASSERT_TRUE(run.finished);
      EXPECT_EQ(rig::violations(machine, run), "");
      double travelled = 0, fastest = 0;
      for (std::size_t k = 1; k < run.samples.size(); ++k) {
        travelled += way(run.samples[k - 1].position, run.samples[k].position);
        fastest = std::max(fastest, run.samples[k].path_speed_mm_s);
      }
      const std::string what = std::to_string(degrees) + " degrees, jerk " + std::to_string(jerk);
      EXPECT_LE(fastest, 1.001 * kFeed_mm_s) << what;
      // Each corner is shorter by some 0.6 tolerance * turn (in closed form: 0.7 with all of the tolerance).
      const double shorter = 2 * kLegs - travelled;
      EXPECT_GT(shorter, 0.6 * (kLegs - 1) * kTolerance_mm * radians(degrees)) << what;
      const double saved_s = 2 * kLegs / kFeed_mm_s - (run.time_s - kFeed_mm_s / 2000 - 0.02);
      EXPECT_GT(saved_s, (jerk > 1e9 ? 0.9 * shorter / kFeed_mm_s : 0)) << what;
    }
  }
}

TEST(Corner, ByItselfUsesTheWholeTolerance) {
  for (const double degrees : {1.0, 10.0, 45.0, 90.0, 150.0, 179.0}) {
    const auto machine = rig::machine(2, 500, 2000, 1e12);
    Kernel kernel(machine);
    const double turn = radians(degrees);
    const AxisVector corner{10, 0}, end{10 + 10 * std::cos(turn), 10 * std::sin(turn)};
    const auto run = rig::run(kernel, machine, {line(corner, 0.5, kTolerance_mm), line(end, 0.5, kTolerance_mm)});
    double nearest = 1;
    for (const Sample& sample : run.samples) nearest = std::min(nearest, way(sample.position, corner));
    EXPECT_GT(nearest, 0.96 * kTolerance_mm) << degrees;
    EXPECT_LT(nearest, 1.01 * kTolerance_mm) << degrees;  // the samples lie beside the middle
    EXPECT_LE(run.path_error, kTolerance_mm) << degrees;
  }
}

TEST(Corner, AnotherFeedBeginsThere) {
  for (const auto& [first, second] : {std::pair{5.0, 10.0}, {10.0, 5.0}}) {
    const auto machine = rig::machine(2, 500, 2000, 1e12);
    Kernel kernel(machine);
    const double turn = radians(1.5);  // rounded over more than 2 mm to either side
    const auto run = rig::run(kernel, machine, {line({10, 0}, first), line({10 + 10 * std::cos(turn), 10 * std::sin(turn)}, second)});
    for (const Sample& sample : run.samples) {
      const double x = sample.position[0];
      if (x < 1 || x > 19 || std::abs(x - 10) < 0.15) continue;
      const double feed = x < 10 ? first : second;
      EXPECT_NEAR(sample.path_speed_mm_s, feed, 0.002 * feed) << x;
    }
  }
}

TEST(Corner, AStopLastsNoLongerThanTheLimitsAndThePeriodAsk) {
  constexpr int kMoves = 60;
  for (const double leg_mm : {0.05, 0.31, 1.0, 5.3, 53.0}) {
    const auto machine = rig::machine(2, 500, 2000, 1e12);
    Kernel kernel(machine);
    std::vector<Move> moves;
    for (int i = 1; i <= kMoves; ++i) {
      moves.push_back(line({i % 2 ? leg_mm : 0, 0}, 500));
      moves.back().exact_stop = true;
    }
    const auto run = rig::run(kernel, machine, moves);
    ASSERT_TRUE(run.finished);
    EXPECT_EQ(rig::violations(machine, run), "");
    const double least_s = 2 * std::sqrt(leg_mm / 2000);
    EXPECT_LT(run.time_s / kMoves, least_s + 1.6 * kPeriod_s) << leg_mm;
  }
}

}  // namespace
}  // namespace headstock::motion

// Rotary axes have a tolerance of their own: a corner is rounded by at most tolerance_mm of the linear axes
// and tolerance_deg of each rotary one, and every limit holds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "motion/geometry.hpp"
#include "random_programs.hpp"
#include "rig.hpp"

namespace headstock::motion {
namespace {

constexpr double kTolerance_mm = 0.01;

machine::Machine turning_machine(double tolerance_deg, double jerk = 1e12) {
  machine::Machine machine = rig::machine(5, 300, 2000, jerk);
  machine.tolerance_mm = kTolerance_mm;
  machine.tolerance_deg = tolerance_deg;
  for (const std::size_t i : {3u, 4u}) machine.axes[i].rotary = true;
  machine.axes[3].max_acceleration_mm_s2 = 700;
  return machine;
}

TEST(RotaryAxes, CountInTolerancesByTheirOwn) {
  EXPECT_EQ(tolerance_weights(turning_machine(0.01)), (AxisVector{1, 1, 1, 1, 1, 1, 1, 1}));
  EXPECT_EQ(tolerance_weights(turning_machine(0.04)), (AxisVector{1, 1, 1, 0.25, 0.25, 1, 1, 1}));
}

TEST(RotaryAxes, AWiderToleranceInDegreesIsUsedAndALinearAxisStaysInItsOwn) {
  std::vector<double> times_s;
  for (const double tolerance_deg : {0.0025, 0.01, 0.04, 0.16}) {
    const machine::Machine machine = turning_machine(tolerance_deg);
    Kernel kernel(machine);
    // A swings there and back while X goes on: its corners are rounded in A.
    std::vector<Move> moves;
    for (int i = 1; i <= 20; ++i) moves.push_back(rig::line({2.0 * i, 0, 0, i % 2 ? 2.0 : 0}, 100));
    const rig::Run run = rig::run(kernel, machine, moves);
    ASSERT_TRUE(run.finished);
    EXPECT_EQ(rig::violations(machine, run), "");
    double highest = 0;
    for (const Sample& sample : run.samples) highest = std::max(highest, sample.position[3]);
    const double rounded = 2 - highest;  // at the upper corners, in degrees
    EXPECT_LE(rounded, tolerance_deg) << tolerance_deg;
    EXPECT_GT(rounded, 0.3 * tolerance_deg) << tolerance_deg;
    times_s.push_back(run.time_s);
    // The same with Y in place of A is rounded by mm, whatever the degrees.
    for (Move& move : moves)
      std::swap(std::get<Line>(move.geometry).end[1], std::get<Line>(move.geometry).end[3]);
    const rig::Run linear = rig::run(kernel, machine, moves);
    highest = 0;
    for (const Sample& sample : linear.samples) highest = std::max(highest, sample.position[1]);
    EXPECT_LE(2 - highest, kTolerance_mm);
  }
  EXPECT_LT(times_s.back(), 0.98 * times_s.front()) << "what is allowed makes it quicker";
}

TEST(RotaryAxes, LimitsAndTolerancesHoldOnRandomPrograms) {
  for (const double jerk : {1e12, 500'000.0, 50'000.0}) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      const double tolerance_deg = seed % 2 ? 0.1 : 0.002;
      const machine::Machine machine = turning_machine(tolerance_deg, jerk);
      std::vector<Move> moves = rig::random_program(seed, 40);
      std::mt19937 generator(seed);
      std::uniform_real_distribution<double> turn(-1, 1);
      double a = 0, c = 0, before_x = 0;
      for (Move& move : moves) {
        const double way = std::abs(rig::end_of(move)[0] - before_x);
        before_x = rig::end_of(move)[0];
        a += way * turn(generator);
        c += 0.3 * way * turn(generator);
        std::visit([&](auto& geometry) { geometry.end[3] = a, geometry.end[4] = c; }, move.geometry);
        move.tolerance_mm = kTolerance_mm;
      }
      auto kernel = std::make_unique<Kernel>(machine);
      const rig::Run run = rig::run(*kernel, machine, moves);
      const std::string what = "seed " + std::to_string(seed) + " jerk " + std::to_string(jerk);
      EXPECT_TRUE(run.finished) << what;
      EXPECT_EQ(rig::violations(machine, run), "") << what;
      EXPECT_LE(run.path_error, kTolerance_mm) << what;
    }
  }
}

}  // namespace
}  // namespace headstock::motion

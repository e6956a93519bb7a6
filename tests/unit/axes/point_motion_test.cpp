// One axis to a point: limits at every sample, exact arrival, targets and speeds that change on the way.
#include "axes/point_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "motion/limits_check.hpp"

namespace headstock::axes {
namespace {

constexpr double kPeriod_s = 0.001;

struct Watched {
  explicit Watched(const PointMotion::Limits& limits) : motion(limits, kPeriod_s), limits_(limits) {
    check.add({});
  }
  void step() {
    motion.step();
    machine::AxisVector at{};
    at[0] = motion.position();
    check.add(at);
  }
  void expect_inside() const {
    EXPECT_LE(check.max_velocity()[0], limits_.speed * 1.001);
    EXPECT_LE(check.max_acceleration()[0], limits_.acceleration * 1.01);
    if (limits_.jerk < 1e9) {
      EXPECT_LE(check.max_jerk()[0], limits_.jerk * 1.05);
    }
  }
  PointMotion motion;
  motion::LimitsCheck check{1, kPeriod_s};

 private:
  PointMotion::Limits limits_;
};

TEST(PointMotion, ArrivesExactlyInNearlyTheShortestTime) {
  Watched axis({100, 1000, 50'000});
  axis.motion.go(37.5, 100);
  int periods = 0;
  for (; !axis.motion.arrived() && periods < 10'000; ++periods) axis.step();
  EXPECT_EQ(axis.motion.position(), 37.5);
  axis.expect_inside();
  // Trapezium: 37.5/100 + 100/1000 = 0.475 s, and the smoothing time of 2 a / j = 0.04 s.
  EXPECT_LT(periods * kPeriod_s, 0.475 + 0.04 + 0.02);
}

TEST(PointMotion, AnyOrderAtAnyTimeKeepsTheLimits) {
  std::mt19937 random(3);
  for (int round = 0; round < 100; ++round) {
    std::uniform_real_distribution<double> share(0, 1);
    const PointMotion::Limits limits{10 + 300 * share(random), 100 + 3000 * share(random),
                                     round % 5 == 0 ? 1e12 : 5'000 + 200'000 * share(random)};
    Watched axis(limits);
    for (int order = 0; order < 20; ++order) {
      if (share(random) < 0.2)
        axis.motion.stop();
      else
        axis.motion.go(200 * share(random) - 100, limits.speed * 1.5 * share(random));
      const int periods = static_cast<int>(share(random) * 500);
      for (int i = 0; i < periods; ++i) axis.step();
    }
    axis.motion.go(12.25, limits.speed);
    for (int i = 0; i < 60'000 && !axis.motion.arrived(); ++i) axis.step();
    EXPECT_EQ(axis.motion.position(), 12.25);
    axis.expect_inside();
  }
}

TEST(PointMotion, NeverPassesATargetItCouldStopAt) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(0, 1);
  for (int round = 0; round < 200; ++round) {
    Watched axis({150, 800, 20'000});
    const double target = 60 * share(random);
    axis.motion.go(target, 150 * share(random) + 1);
    for (int i = 0; i < 70'000 && !axis.motion.arrived(); ++i) {
      axis.step();
      ASSERT_LE(axis.motion.position(), target);
    }
    EXPECT_EQ(axis.motion.position(), target);
  }
}

TEST(PointMotion, StopStaysWhereItComesToRest) {
  Watched axis({100, 1000, 50'000});
  axis.motion.go(50, 100);
  for (int i = 0; i < 200; ++i) axis.step();
  const double way = axis.motion.stopping_way(), from = axis.motion.position();
  axis.motion.stop();
  for (int i = 0; i < 500; ++i) axis.step();
  EXPECT_TRUE(axis.motion.at_rest());
  EXPECT_LE(axis.motion.position() - from, way + 1e-9);
  EXPECT_GT(axis.motion.position() - from, way * 0.8);
  const double stood = axis.motion.position();
  for (int i = 0; i < 500; ++i) axis.step();
  EXPECT_EQ(axis.motion.position(), stood);
  axis.expect_inside();
}

}  // namespace
}  // namespace headstock::axes

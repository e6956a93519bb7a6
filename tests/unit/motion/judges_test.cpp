// The judges themselves against figures worked out by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "rig.hpp"

namespace headstock::motion {
namespace {

TEST(LimitsCheck, FiniteDifferencesOfACubic) {
  LimitsCheck check(1, 0.001);
  check.add({0});
  for (int k = 1; k <= 100; ++k) {  // p = 1000 t³: j = 6000, a(100 ms) about 600, v about 30
    const double t = 0.001 * k;
    check.add({1000 * t * t * t});
  }
  EXPECT_NEAR(check.max_jerk()[0], 6000, 1e-3);
  EXPECT_NEAR(check.max_acceleration()[0], 6000 * 0.099, 1e-3);
  EXPECT_NEAR(check.max_velocity()[0], 1000 * 3 * 0.0995 * 0.0995, 0.01);
}

TEST(LimitsCheck, AJumpIsSeen) {
  LimitsCheck check(1, 0.001);
  check.add({0});
  check.add({1});
  EXPECT_NEAR(check.max_velocity()[0], 1000, 1e-9);
  EXPECT_NEAR(check.max_jerk()[0], 1e9, 1);
}

TEST(PathError, DistanceToLineAndArc) {
  PathError error(3);
  error.start({});
  Move first = rig::line({10, 0, 0}, 100);
  first.tag = 1;
  Move arc = rig::line({}, 100);
  arc.tag = 2;
  arc.geometry = Arc{{10, 20, 0}, 0, 1, 10, 10, M_PI};  // half circle through (20, 10)
  error.add(first);
  error.add(arc);
  EXPECT_NEAR(error.sample({5, 0.3, 0.4}, 1), 0.5, 1e-12);
  EXPECT_NEAR(error.sample({-3, 4, 0}, 1), 5, 1e-12);
  EXPECT_NEAR(error.sample({20.25, 10, 0}, 2), 0.25, 1e-12);
  EXPECT_NEAR(error.sample({10, 10, 0}, 2), 10, 1e-9);
  EXPECT_NEAR(error.max(), 10, 1e-9);
}

TEST(PathError, WhatIsJudgedForTheMaximumOnlyHasTheSameMaximum) {
  PathError each(3), together(3);
  for (PathError* error : {&each, &together}) {
    error->start({});
    for (int i = 1; i <= 40; ++i) {
      Move move = rig::line({1.0 * i, i % 2 ? 0.5 : 0.0, 0}, 100);
      move.tag = static_cast<std::uint64_t>(i);
      error->add(move);
    }
  }
  for (int i = 0; i < 400; ++i) {
    const AxisVector at{0.1 * i, 0.3 * std::sin(0.1 * i), 0};
    const auto tag = static_cast<std::uint64_t>(i / 10 + 1);
    each.sample(at, tag);
    together.judge(at, tag);
  }
  EXPECT_GT(each.max(), 0.1);
  EXPECT_EQ(together.max(), each.max());
}

TEST(PathError, HelixIsMeasuredAtItsNearestPoint) {
  PathError error(3);
  error.start({});
  Move helix = rig::line({}, 100);
  helix.tag = 1;
  helix.geometry = Arc{{0, 0, 6}, 0, 1, -5, 0, 6 * M_PI};
  error.add(helix);
  for (double w = 0.01; w < 1; w += 0.07) {
    const double angle = 6 * M_PI * w;
    EXPECT_LT(error.sample({-5 + 5 * std::cos(angle), 5 * std::sin(angle), 6 * w}, 1), 1e-6) << w;
  }
  // 0.5 above the path: by the slope of 6 mm in 30 π mm the nearest point is a little nearer.
  const double angle = 6 * M_PI * 0.4, slope = std::atan(6 / (30 * M_PI));
  EXPECT_NEAR(error.sample({-5 + 5 * std::cos(angle), 5 * std::sin(angle), 2.9}, 1), 0.5 * std::cos(slope),
              1e-3);
}

}  // namespace
}  // namespace headstock::motion

// Stored stroke check 1 against an independent judge: the same move followed in very small steps.
#include "axes/travel_limits.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "axes/arc_path.hpp"

namespace headstock::axes {
namespace {

machine::Machine box() {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  for (auto& axis : machine.axes) {
    axis.min_mm = -100;
    axis.max_mm = 100;
  }
  return machine;
}

bool inside(const machine::Machine& machine, const AxisVector& p, double slack = 1e-9) {
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    if (p[i] > machine.axes[i].max_mm + slack || p[i] < machine.axes[i].min_mm - slack) return false;
  return true;
}

TEST(TravelLimits, LineInsideIsLeftAlone) {
  EXPECT_FALSE(find_overtravel(box(), {}, motion::Line{{50, -50, 10}}));
}

TEST(TravelLimits, LineMayEndExactlyOnTheLimit) {
  EXPECT_FALSE(find_overtravel(box(), {}, motion::Line{{100, -100, 0}}));
}

TEST(TravelLimits, LineStopsBeforeTheFirstLimitItPasses) {
  const auto over = find_overtravel(box(), {0, 0, 0}, motion::Line{{200, 100, -150}});
  ASSERT_TRUE(over);
  EXPECT_EQ(over->axis, 0u);
  EXPECT_TRUE(over->positive);
  const AxisVector end = std::get<motion::Line>(over->allowed).end;
  EXPECT_NEAR(end[0], 100 - kStopBeforeLimit_mm, 1e-9);
  EXPECT_NEAR(end[1], end[0] / 2, 1e-9);  // still on the programmed line
  EXPECT_NEAR(end[2], -end[0] * 0.75, 1e-9);
}

TEST(TravelLimits, AnAxisOutsideMayComeBackButNotGoFurther) {
  EXPECT_FALSE(find_overtravel(box(), {120, 0, 0}, motion::Line{{110, 0, 0}}));
  const auto over = find_overtravel(box(), {120, 0, 0}, motion::Line{{130, 0, 0}});
  ASSERT_TRUE(over);
  EXPECT_EQ(over->fraction, 0);
}

TEST(TravelLimits, ArcThatBulgesPastTheLimitBetweenItsEnds) {
  // From (60,-50) to (60,50) around (60,0): both ends inside, the middle at X 110.
  const AxisVector start{60, -50, 0};
  motion::Arc arc{{60, 50, 0}, 0, 1, 60, 0, std::numbers::pi};
  const auto over = find_overtravel(box(), start, arc);
  ASSERT_TRUE(over);
  EXPECT_EQ(over->axis, 0u);
  EXPECT_TRUE(over->positive);
  const auto& allowed = std::get<motion::Arc>(over->allowed);
  EXPECT_NEAR(allowed.end[0], 100 - kStopBeforeLimit_mm, 1e-9);
  EXPECT_NEAR(std::hypot(allowed.end[0] - 60, allowed.end[1]), 50, 1e-9);
  EXPECT_LT(allowed.end[1], 0);  // on the way out, not on the way back
}

TEST(TravelLimits, ArcThatJustTouchesIsInside) {
  const AxisVector start{50, -50, 0};
  EXPECT_FALSE(find_overtravel(box(), start, motion::Arc{{50, 50, 0}, 0, 1, 50, 0, std::numbers::pi}));
}

TEST(TravelLimits, HelixIsStoppedByTheAxisOutsideThePlane) {
  const AxisVector start{10, 0, 90};
  motion::Arc helix{{10, 0, 120}, 0, 1, 0, 0, 2 * std::numbers::pi * 3};
  const auto over = find_overtravel(box(), start, helix);
  ASSERT_TRUE(over);
  EXPECT_EQ(over->axis, 2u);
  EXPECT_NEAR(over->fraction, (10 - kStopBeforeLimit_mm) / 30, 1e-4);
}

TEST(TravelLimits, RandomArcsAgreeWithSmallSteps) {
  const machine::Machine machine = box();
  std::mt19937 random(20240607);
  std::uniform_real_distribution<double> position(-99, 99), sweep(-15, 15), growth(0.8, 1.2), dz(-60, 60);
  int stopped = 0, free_of_limits = 0;
  for (int n = 0; n < 3000; ++n) {
    const AxisVector start{position(random), position(random), position(random)};
    motion::Arc arc;
    arc.center_1 = position(random);
    arc.center_2 = position(random);
    arc.angle_rad = sweep(random);
    const double radius = std::hypot(start[0] - arc.center_1, start[1] - arc.center_2) * growth(random);
    const double angle = std::atan2(start[1] - arc.center_2, start[0] - arc.center_1) + arc.angle_rad;
    arc.end = {arc.center_1 + radius * std::cos(angle), arc.center_2 + radius * std::sin(angle),
               start[2] + dz(random)};
    const auto over = find_overtravel(machine, start, arc);

    const ArcPath path(start, arc);
    double first_outside = 1;
    constexpr int kSteps = 4000;
    for (int i = 0; i <= kSteps && first_outside == 1; ++i)
      if (!inside(machine, path.position(arc.angle_rad * i / kSteps)))
        first_outside = static_cast<double>(i) / kSteps;
    if (!over) {
      ++free_of_limits;
      EXPECT_EQ(first_outside, 1) << "a limit is passed unseen, case " << n;
      continue;
    }
    ++stopped;
    EXPECT_LE(over->fraction, first_outside + 1e-9) << n;
    // Not stopped needlessly: right after the place where it stops, the axis is at its limit.
    const double at = path.at(over->axis, arc.angle_rad * over->fraction);
    const double limit = over->positive ? 100 : -100;
    EXPECT_TRUE(std::abs(at - limit) < kStopBeforeLimit_mm + 1e-6) << n << " " << at;
    for (int i = 0; i <= 1000; ++i)
      ASSERT_TRUE(inside(machine, path.position(arc.angle_rad * over->fraction * i / 1000))) << n;
  }
  EXPECT_GT(stopped, 500);
  EXPECT_GT(free_of_limits, 50);
}

}  // namespace
}  // namespace headstock::axes

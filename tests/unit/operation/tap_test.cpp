// Tapping: axis and spindle in step to the bottom and back, on mills and lathes; what stops it and what pulls
// it out again.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

std::string first_alarm(Bench& bench) {
  const auto alarms = bench.controller.live().alarms;
  return alarms.empty() ? std::string() : alarms.front().code;
}

struct TapSeen {
  double deepest = 1e9, highest_rpm = 0, lowest_rpm = 0, worst_step_mm = 0;
  int periods = 0;
};

/// Runs to the end and looks at every period in which the axis is below `reference`.
TapSeen watch_tap(Bench& bench, std::size_t axis, double reference, double pitch_mm, int turning) {
  TapSeen seen;
  LimitsOnBench limits(bench);
  double origin_phase = 0, origin = 0;
  bool in_step = false;
  const bool ended = limits.until(
      [&] {
        const double z = bench.controller.sample().position[axis];
        seen.deepest = std::min(seen.deepest, z);
        if (z < reference - 1e-9) {
          const double phase = bench.controller.spindle().phase_rad();
          if (!in_step) {
            in_step = true;
            origin_phase = phase;
            origin = z;
          }
          const double turned_mm = turning * (phase - origin_phase) / kTwoPi * pitch_mm;
          seen.worst_step_mm = std::max(seen.worst_step_mm, std::abs((origin - z) - turned_mm));
          seen.highest_rpm = std::max(seen.highest_rpm, bench.controller.spindle_rpm());
          seen.lowest_rpm = std::min(seen.lowest_rpm, bench.controller.spindle_rpm());
          ++seen.periods;
        }
        const State state = bench.state();
        return state == State::idle || state == State::alarm;
      },
      120);
  EXPECT_TRUE(ended);
  EXPECT_EQ(bench.state(), State::idle) << first_alarm(bench);
  limits.expect_inside();
  return seen;
}

TEST(RigidTap, AxisAndSpindleStayInStepInAndOut) {
  Bench bench("fanuc-0i-m");
  bench.load("O1\nG90 G94 G21 G00 Z0.\nM29 S600\nG99 G84 Z-20. R-5. F900.\nG80\nM30\n");
  ASSERT_TRUE(bench.start());
  const TapSeen seen = watch_tap(bench, 2, -5, 1.5, 1);
  EXPECT_EQ(seen.deepest, -20);
  EXPECT_LT(seen.worst_step_mm, 1e-6);
  EXPECT_NEAR(seen.highest_rpm, 600, 1);
  EXPECT_NEAR(seen.lowest_rpm, -600, 1);
  EXPECT_EQ(bench.controller.sample().position[2], -5);
  EXPECT_GT(seen.periods, 1000);
}

TEST(RigidTap, LeftHandTurnsTheOtherWay) {
  Bench bench("fanuc-0i-m");
  bench.load("O1\nG90 G94 G21 G00 Z0.\nM29 S600\nG99 G74 Z-20. R-5. F900.\nG80\nM30\n");
  ASSERT_TRUE(bench.start());
  const TapSeen seen = watch_tap(bench, 2, -5, 1.5, -1);
  EXPECT_EQ(seen.deepest, -20);
  EXPECT_LT(seen.worst_step_mm, 1e-6);
}

TEST(RigidTap, PecksReachTheBottomAndComeBackOut) {
  Bench bench("fanuc-0i-m");
  bench.controller.edit_data([](interp::MachineData& data) { data.parameters["5213"] = 1; }, {}, "test");
  bench.load("O1\nG90 G94 G21 G00 Z0.\nM29 S600\nG99 G84 Z-20. R-2. Q6. F900.\nG80\nM30\n");
  ASSERT_TRUE(bench.start());
  double turned_at = 0;
  int reversals = 0;
  double last = 0, last_v = 0;
  ASSERT_TRUE(bench.until(
      [&] {
        const double z = bench.controller.sample().position[2], v = z - last;
        if (v > 1e-6 && last_v < -1e-6) {
          ++reversals;
          turned_at = last;
        }
        if (std::abs(v) > 1e-6) last_v = v;
        last = z;
        return bench.state() != State::running;
      },
      120));
  EXPECT_EQ(bench.state(), State::idle) << first_alarm(bench);
  EXPECT_GE(reversals, 3);
  EXPECT_NEAR(turned_at, -20, 1e-6);
  EXPECT_EQ(bench.controller.sample().position[2], -2);
}

TEST(RigidTap, OnALatheAlongZAndAlongX) {
  for (const auto& [program, axis] :
       {std::pair{"O1\nG98 G21\nG00 X0. Z0.\nM29 S500\nG84 Z-18. R-3. F500.\nG80\nM30\n", std::size_t{1}},
        std::pair{"O1\nG98 G21\nG00 X0. Z-10.\nM29 S500\nG88 X-36. R-3. F500.\nG80\nM30\n",
                  std::size_t{0}}}) {
    Bench bench("fanuc-0i-t");
    bench.load(program);
    ASSERT_TRUE(bench.start());
    const TapSeen seen = watch_tap(bench, axis, -3.5, 1, 1);
    EXPECT_NEAR(seen.deepest, -18, 1e-9) << program;
    EXPECT_LT(seen.worst_step_mm, 1e-6);
  }
}

TEST(RigidTap, HoldAndOverrideWaitUntilItIsOver) {
  Bench bench("fanuc-0i-m");
  bench.load("O1\nG90 G94 G21 G00 Z0.\nM29 S600\nG99 G84 Z-20. R-5. F900.\nX10.\nG80\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[2] < -10; }, 20));
  bench.press(Action::feed_hold);
  bench.press(Action::set_feed_override, 0.1);
  double most = 0, last = bench.controller.sample().position[2];
  ASSERT_TRUE(bench.until(
      [&] {
        const double z = bench.controller.sample().position[2];
        most = std::max(most, std::abs(z - last));
        last = z;
        return z == -5 && !bench.controller.sample().moving;
      },
      10));
  EXPECT_NEAR(most, 15.0 / 1000, 1e-4) << "900 mm/min all the way";
  for (int i = 0; i < 1000; ++i) bench.period();
  EXPECT_EQ(bench.state(), State::hold);
  EXPECT_EQ(bench.controller.sample().position[0], 0);
  bench.press(Action::set_feed_override, 1);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 30));
  EXPECT_EQ(bench.controller.sample().position[0], 10);
}

TEST(RigidTap, ShowsTheBlockBeingTapped) {
  Bench bench("fanuc-0i-m");
  bench.load("O1\nG90 G94 G21 G00 Z0.\nM29 S600\nG99 G84 Z-20. R-5. F900.\nG80\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[2] < -10; }, 20));
  EXPECT_EQ(bench.controller.live().at.line, 4u);
  EXPECT_TRUE(bench.controller.cutting());
}

// RESET and emergency stop in the hole: both brake in step, and the tap can be pulled out.
void stop_in_hole(Action how) {
  ControllerOptions options = virtual_options();
  Bench bench("fanuc-0i-m", std::move(options));
  bench.load("O1\nG90 G94 G21 G00 Z0.\nM29 S600\nG99 G84 Z-20. R-5. F900.\nG80\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[2] < -12; }, 20));
  double z = bench.controller.sample().position[2], phase = bench.controller.spindle().phase_rad();
  const double z0 = z, phase0 = phase;
  bench.press(how);
  for (int i = 0; i < 500; ++i) {
    bench.period();
    z = bench.controller.sample().position[2];
    phase = bench.controller.spindle().phase_rad();
    ASSERT_NEAR((z0 - z), (phase - phase0) / kTwoPi * 1.5, 2e-3) << i;
  }
  EXPECT_GT(z, -20);
  EXPECT_LT(z, -11);
  EXPECT_EQ(bench.press(Action::tap_retract, 0, Origin::network).reason, "panel_only");
  if (how == Action::emergency_stop) {
    EXPECT_EQ(bench.press(Action::tap_retract).reason, "emergency_stop");
    ASSERT_TRUE(bench.press(Action::emergency_stop_release).accepted);
    ASSERT_TRUE(bench.until_state(State::idle, 2));
  }
  EXPECT_TRUE(bench.controller.live().tap_in_hole);
  LimitsOnBench limits(bench);
  ASSERT_TRUE(bench.press(Action::tap_retract).accepted);
  const double from = bench.controller.sample().position[2],
               from_phase = bench.controller.spindle().phase_rad();
  ASSERT_TRUE(limits.until([&] { return bench.controller.sample().position[2] == -5; }, 10));
  EXPECT_NEAR(-5 - from, -(bench.controller.spindle().phase_rad() - from_phase) / kTwoPi * 1.5, 1e-6);
  for (int i = 0; i < 50; ++i) limits.period();
  limits.expect_inside();
  EXPECT_FALSE(bench.controller.live().tap_in_hole);
  EXPECT_EQ(bench.press(Action::tap_retract).reason, "nothing_to_retract");
  ASSERT_TRUE(bench.start()) << "and the machine is sound";
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_EQ(bench.controller.sample().position[2], -5);
}
TEST(RigidTap, ResetInTheHoleThenPullOut) {
  stop_in_hole(Action::reset);
}
TEST(RigidTap, EmergencyStopInTheHoleThenPullOut) {
  stop_in_hole(Action::emergency_stop);
}

TEST(RigidTap, RefusedBeforeTheAxisMoves) {
  struct Case {
    const char* profile;
    const char* program;
    const char* code;
  };
  for (const Case& test : {
           Case{"fanuc-0i-m", "O1\nG90 G94 G21 G00 Z0.\nM29 S6000\nG99 G84 Z-20. R-5. F12000.\nG80\nM30\n",
                "HS0003"},
           Case{"fanuc-0i-m", "O1\nG90 G94 G21 G00 Z0.\nM29 S600\nG99 G84 Z-20000. R-5. F900.\nG80\nM30\n",
                "OT0501"},
       }) {
    Bench bench(test.profile);
    bench.load(test.program);
    ASSERT_TRUE(bench.start());
    double deepest = 0;
    ASSERT_TRUE(bench.until(
        [&] {
          deepest = std::min(deepest, bench.controller.sample().position[2]);
          return bench.state() == State::alarm;
        },
        30))
        << test.program;
    EXPECT_EQ(first_alarm(bench), test.code);
    EXPECT_GE(deepest, -5);
  }
}

TEST(RigidTap, ASpindleThatLagsStopsTheMachine) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  Bench bench(machine);
  bench.load("O1\nG90 G94 G21 G00 Z0.\nM29 S600\nG99 G84 Z-20. R-5. F900.\nG80\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[2] < -10; }, 20));
  bench.controller.spindle().load(0.5);
  ASSERT_TRUE(bench.until_state(State::alarm, 2));
  EXPECT_EQ(first_alarm(bench), "SP0741");
  EXPECT_GT(bench.controller.sample().position[2], -20);
  const AxisVector stood = bench.controller.sample().position;
  for (int i = 0; i < 500; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position, stood);
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "alarm");
}

// The servo drives of the simulation: spindle and axis lag alike.
TEST(RigidTap, InStepAsMeasuredToo) {
  ControllerOptions options;
  options.now_ms = [] { return std::int64_t{0}; };
  Bench bench("fanuc-0i-m", std::move(options));
  bench.load("O1\nG90 G94 G21 G00 Z0.\nM29 S600\nG99 G84 Z-20. R-5. F900.\nG80\nM30\n");
  ASSERT_TRUE(bench.start());
  double worst = 0, origin = 0, origin_phase = 0;
  bool coupled = false;
  ASSERT_TRUE(bench.until(
      [&] {
        const double z = bench.controller.live().machine[2], phase = bench.controller.spindle().phase_rad();
        if (!coupled && bench.controller.spindle().positioned()) {
          coupled = true;
          origin = z;
          origin_phase = phase;
        }
        if (coupled && z < -5.2)
          worst = std::max(worst, std::abs((origin - z) - (phase - origin_phase) / kTwoPi * 1.5));
        return bench.state() != State::running;
      },
      60));
  EXPECT_EQ(bench.state(), State::idle) << first_alarm(bench);
  EXPECT_LT(worst, 0.03);
  EXPECT_GT(worst, 0);
}

// G93 of the 200T and K2000TC: the axis follows the encoder of a spindle that is stopped and reversed.
TEST(FollowingTap, StopsAtTheBottomAndComesBackInStep) {
  for (const char* profile : {"lathe-200t", "k2000tc"}) {
    Bench bench(profile);
    bench.load(std::string(profile) == "lathe-200t" ? "M03 S200\nG00 X0 Z5\nG93 W-25 F2\nM02\n"
                                                    : "O1\nG98 G00 X0. Z5.\nM03 S200\nG93 W-25. F2.\nM30\n");
    ASSERT_TRUE(bench.start());
    double deepest = 1e9;
    LimitsOnBench limits(bench);
    ASSERT_TRUE(limits.until(
        [&] {
          deepest = std::min(deepest, bench.controller.sample().position[1]);
          return bench.state() == State::idle || bench.state() == State::alarm;
        },
        120));
    EXPECT_EQ(bench.state(), State::idle) << profile << " " << first_alarm(bench);
    EXPECT_GE(deepest, -20 - 0.5) << profile;
    EXPECT_LE(deepest, -20 + 1) << profile;
    EXPECT_NEAR(bench.controller.sample().position[1], 5, 1e-9);
    limits.expect_inside();
  }
}

}  // namespace
}  // namespace headstock::operation

// Constant surface speed with its clamp, orientation, and the spindle as Cs axis.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

double rpm_for(double m_min, double diameter_mm) {
  return m_min * 1000 / (std::numbers::pi * diameter_mm);
}

TEST(SurfaceSpeed, FollowsTheDiameterDownToTheClamp) {
  Bench bench("fanuc-0i-t");
  bench.load("O1\nG98 G21 G40\nG50 S1500\nG00 X100. Z5.\nG96 S120 M03\nG01 X10. F300.\nM30\n");
  ASSERT_TRUE(bench.start());
  bool clamped = false;
  double worst = 0;
  int cut = 0;
  ASSERT_TRUE(bench.until(
      [&] {
        const motion::Sample& sample = bench.controller.sample();
        const Live live = bench.controller.live();
        if (sample.moving && bench.controller.cutting()) {
          const double wanted = std::min(1500.0, rpm_for(120, 2 * sample.position[0]));
          worst = std::max(worst, std::abs(live.spindle_commanded_rpm - wanted));
          clamped = clamped || live.spindle_commanded_rpm == 1500;
          ++cut;
        }
        EXPECT_LE(live.spindle_commanded_rpm, 1500);
        return live.state != State::running;
      },
      120));
  EXPECT_EQ(bench.state(), State::idle);
  EXPECT_GT(cut, 1000);
  EXPECT_TRUE(clamped);
  EXPECT_LT(worst, 0.5);
}

TEST(SurfaceSpeed, DuringPositioningItIsThatOfWhereTheMoveLeads) {
  Bench bench("fanuc-0i-t");
  bench.load("O1\nG98 G21 G40\nG50 S3000\nG00 X100. Z5.\nG96 S120 M03\nG00 X40.\nG01 Z0. F300.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.live().spindle_commanded_rpm > 0; }, 20));
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().moving; }, 20));
  bench.period();
  EXPECT_NEAR(bench.controller.live().spindle_commanded_rpm, rpm_for(120, 40), 0.5);
  ASSERT_TRUE(bench.until_state(State::idle, 60));
}

TEST(SurfaceSpeed, TheOverrideActsBeforeTheClamp) {
  Bench bench("fanuc-0i-t");
  bench.load("O1\nG98 G21\nG50 S700\nG00 X100. Z5.\nG96 S200 M03\nG01 Z-30. F100.\nM30\n");
  bench.press(Action::set_spindle_override, 1.2);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(
      bench.until([&] { return bench.controller.cutting() && bench.controller.sample().moving; }, 20));
  EXPECT_EQ(bench.controller.live().spindle_commanded_rpm, 700) << "636.6 x 1.2, clamped";
  bench.press(Action::set_spindle_override, 0.5);
  bench.period();
  bench.period();
  EXPECT_NEAR(bench.controller.live().spindle_commanded_rpm, rpm_for(200, 100) / 2, 0.1);
}

TEST(Orientation, M19TurnsToTheAngleAndHoldsItUntilTheNextOrder) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.spindle.orient_deg = 30;
  Bench bench(machine);
  bench.load("O1\nG90 G94 G21\nM03 S1000\nG04 P500\nM19\nG04 P500\nM03\nG04 P1000\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.live().at.line == 6; }, 30));
  const double turned = std::remainder(bench.controller.spindle().phase_rad() - 30.0 / 360 * kTwoPi, kTwoPi);
  EXPECT_NEAR(turned, 0, 1e-9);
  for (int i = 0; i < 300; ++i) {
    bench.period();
    ASSERT_EQ(bench.controller.spindle_rpm(), 0);
  }
  ASSERT_TRUE(bench.until([&] { return bench.controller.spindle_rpm() > 990; }, 30));
  ASSERT_TRUE(bench.until_state(State::idle, 30));
}

machine::Machine with_cs() {
  machine::Machine machine = *machine::default_machine("fanuc-0i-t");
  machine::Axis c;
  c.name = 'C';
  c.rotary = true;
  c.rapid_mm_min = 36'000;
  c.max_feed_mm_min = 36'000;
  c.min_mm = -1e5;
  c.max_mm = 1e5;
  machine.axes.push_back(c);
  machine.spindle.contour_axis = 'C';
  machine.spindle.contour_on_m = 81;
  machine.spindle.contour_off_m = 82;
  return machine;
}

TEST(ContourAxis, TheSpindleIsTheAxisBetweenItsTwoMCodes) {
  Bench bench(with_cs());
  bench.load(
      "O1\nG98 G21\nM03 S600\nG04 P500\nM81\nG00 C90.\nG01 C-45. F3000.\nM82\nM03 S300\nG04 P1000\nM30\n");
  ASSERT_TRUE(bench.start());
  LimitsOnBench limits(bench);
  ASSERT_TRUE(limits.until([&] { return bench.controller.live().at.line >= 6; }, 30));
  double worst_deg = 0;
  int periods = 0;
  ASSERT_TRUE(limits.until(
      [&] {
        const double c = bench.controller.sample().position[2];
        const double phase = bench.controller.spindle().phase_rad() / kTwoPi * 360;
        if (bench.controller.sample().moving) {
          worst_deg = std::max(worst_deg, std::abs(std::remainder(phase - c, 360)));
          ++periods;
        }
        return bench.controller.live().at.line >= 8 || bench.state() == State::alarm;
      },
      60));
  EXPECT_EQ(bench.state(), State::running);
  EXPECT_GT(periods, 500);
  EXPECT_LT(worst_deg, 1e-6);
  EXPECT_EQ(bench.controller.sample().position[2], -45);
  limits.expect_inside();
  ASSERT_TRUE(bench.until([&] { return bench.controller.spindle_rpm() > 299; }, 30));
  ASSERT_TRUE(bench.until_state(State::idle, 30));
}

TEST(ContourAxis, CommandedUnderSpeedControlItIsAnAlarmBeforeMotion) {
  Bench bench(with_cs());
  bench.load("O1\nG98 G21\nM03 S600\nG01 C45. F3000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 30));
  EXPECT_EQ(bench.controller.live().alarms.front().code, "PS0197");
  EXPECT_EQ(bench.controller.sample().position[2], 0);
}

TEST(SecondAuxiliary, GoesToTheMachineThatHasItAndIsRefusedOtherwise) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  for (const bool wired : {true, false}) {
    machine.second_auxiliary = wired;
    Bench bench(machine);
    bench.controller.edit_data([](interp::MachineData& data) { data.parameters["8132#2"] = 1; }, {}, "test");
    bench.load("O1\nG90 G94 G21\nB90\nG01 X1. F1000.\nM30\n");
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until([&] { return bench.state() != State::running; }, 20));
    EXPECT_EQ(bench.state(), wired ? State::idle : State::alarm);
    EXPECT_EQ(bench.controller.sample().position[0], wired ? 1 : 0);
  }
}

TEST(DwellWithSkip, TheSignalEndsIt) {
  ControllerOptions options = virtual_options();
  options.skip_input = true;
  Bench bench("fanuc-0i-m", std::move(options));
  bench.controller.edit_data([](interp::MachineData& data) { data.parameters["6206#0"] = 1; }, {}, "test");
  bench.load("O1\nG90 G94 G21\nG04 Q1 P60000\nG01 X1. F1000.\nM30\n");
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 1000; ++i) bench.period();
  const bool waits = bench.controller.sample().position[0] == 0;
  bench.controller.set_skip_signals(1);
  ASSERT_TRUE(bench.until([&] { return bench.state() != State::running; }, 100));
  EXPECT_TRUE(waits);
}

}  // namespace
}  // namespace headstock::operation

// Skip moves, and what is refused before an axis moves: threads the axes cannot follow, forbidden zones.
#include <gtest/gtest.h>

#include "bench.hpp"

namespace headstock::operation {
namespace {

ControllerOptions with_skip() {
  ControllerOptions options = virtual_options();
  options.skip_input = true;
  return options;
}

TEST(Skip, TheProgramGoesOnFromWhereTheAxesStopped) {
  Bench bench("fanuc-0i-m", with_skip());
  bench.load("O1\nG90 G94 G21\nG31 X50. F600.\nG01 Y10. F3000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 20; }, 20));
  bench.controller.set_skip_signals(1);
  bench.period();
  const double latched = bench.controller.sample().position[0];
  bench.controller.set_skip_signals(0);
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[1] > 5; }, 20));
  const double stood = bench.controller.sample().position[0];
  EXPECT_GT(stood, latched);
  EXPECT_LT(stood, latched + 2);
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  EXPECT_EQ(bench.controller.sample().position[0], stood) << "X is not moved again";
  EXPECT_EQ(bench.controller.sample().position[1], 10);
}

TEST(Skip, WithoutASignalTheMoveEndsAsProgrammed) {
  Bench bench("fanuc-0i-m", with_skip());
  bench.load("O1\nG90 G94 G21\nG31 X20. F1200.\nG01 Y10. F3000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  EXPECT_EQ(bench.controller.sample().position[0], 20);
  EXPECT_EQ(bench.controller.sample().position[1], 10);
}

// No.6200#1: the signal acts while it is off.
TEST(Skip, ASignalThatActsWhileItIsOffEndsTheMoveWhenItGoesOff) {
  Bench bench("fanuc-0i-m", with_skip());
  ASSERT_TRUE(bench.controller
                  .edit_data([](interp::MachineData& data) { data.parameters["6200#1"] = 1; }, {}, "test")
                  .accepted);
  bench.controller.set_skip_signals(1);
  bench.load("O1\nG90 G94 G21\nG31 X50. F600.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 20; }, 20)) << "on: it runs";
  bench.controller.set_skip_signals(0);
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  EXPECT_GT(bench.controller.sample().position[0], 20);
  EXPECT_LT(bench.controller.sample().position[0], 23);
}

TEST(Skip, AMachineWithoutTheInputRefuses) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\nG31 X20. F1200.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 20));
  EXPECT_EQ(bench.controller.sample().position[0], 0);
}

void expect_alarm_before_motion(const std::string& profile, const std::string& program,
                                const std::string& code) {
  Bench bench(profile);
  bench.load(program);
  ASSERT_TRUE(bench.start());
  AxisVector start = bench.controller.sample().position;
  ASSERT_TRUE(bench.until_state(State::alarm, 60)) << program;
  ASSERT_EQ(bench.controller.live().alarms.size(), 1u);
  EXPECT_EQ(bench.controller.live().alarms[0].code, code) << program;
  EXPECT_EQ(bench.controller.sample().position, start) << program;
}

TEST(Thread, RefusedBeforeMotionWhenTheAxesCannotFollow) {
  expect_alarm_before_motion("fanuc-0i-t", "O1\nG97 S2000 M03\nG32 W-30. F6.\nM30\n", "HS0003");
  expect_alarm_before_motion("fanuc-0i-t", "O1\nG97 S1500 M03\nG32 W-1. F4.\nM30\n", "HS0004");
}

TEST(DryRun, ARateOfNothingIsAnAlarmNotAStandstill) {
  Bench bench;
  ASSERT_TRUE(bench.controller
                  .edit_data([](interp::MachineData& data) { data.parameters["1410"] = 0; }, {}, "test")
                  .accepted);
  bench.load("O1\nG90 G94 G21 G01 X10. F600.\nM30\n");
  ASSERT_TRUE(bench.press(Action::set_dry_run, 1).accepted);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 20));
  EXPECT_EQ(bench.controller.live().alarms[0].code, "PS5009");
  EXPECT_EQ(bench.controller.sample().position[0], 0);
}

TEST(Thread, OneThatFitsIsCut) {
  Bench bench("fanuc-0i-t");
  bench.load("O1\nG97 S500 M03\nG32 W-30. F2.\nM30\n");
  ASSERT_TRUE(bench.start());
  const double from = bench.controller.sample().position[1];
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_NEAR(bench.controller.sample().position[1], from - 30, 1e-9);
}

TEST(StrokeCheck2, AForbiddenBoxIsNotEntered) {
  // G22 X Y Z: upper corner, I J K: lower corner, machine coordinates; the inside is forbidden unless 1300#0
  // says else.
  Bench bench;
  bench.load("O1\nG90 G94 G21\nG22 X40. Y40. Z10. I20. J-10. K-10.\nG01 X15. F3000.\nX30.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.state() != State::running; }, 60));
  EXPECT_EQ(bench.state(), State::alarm);
  ASSERT_FALSE(bench.controller.live().alarms.empty());
  EXPECT_EQ(bench.controller.live().alarms[0].code.substr(0, 5), "OT050");
  EXPECT_EQ(bench.controller.sample().position[0], 15);
}

}  // namespace
}  // namespace headstock::operation

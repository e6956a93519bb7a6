// Manual intervention in a held program and the way back, manual absolute off, several axes by hand at once.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

void set_mode(Bench& bench, Mode mode) {
  ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(mode)).accepted);
}

struct Held {
  Held() {
    bench.load("O1\nG90 G94 G21\nG01 X40. F2000.\nX40. Y20.\nM30\n");
    bench.start();
    bench.until([&] { return bench.controller.sample().position[0] > 15; }, 20);
    bench.press(Action::feed_hold);
    bench.until([&] { return !bench.controller.sample().moving; }, 5);
    held = bench.controller.sample().position;
  }
  Bench bench;
  AxisVector held{};
};

TEST(Intervention, TheAxesGoBackBeforeTheProgramGoesOn) {
  Held run;
  Bench& bench = run.bench;
  LimitsOnBench limits(bench);
  set_mode(bench, Mode::jog);
  ASSERT_TRUE(bench.controller.jog(2, 1, Controller::JogSpeed::rapid).accepted);
  ASSERT_TRUE(bench.controller.jog(1, -1).accepted);
  for (int i = 0; i < 400; ++i) limits.period();
  EXPECT_GT(bench.controller.sample().velocity[2], 0);
  EXPECT_LT(bench.controller.sample().velocity[1], 0) << "two axes at once";
  bench.controller.jog(2, 0);
  bench.controller.jog(1, 0);
  for (int i = 0; i < 1000; ++i) limits.period();
  EXPECT_EQ(bench.state(), State::hold);
  EXPECT_GT(bench.controller.sample().position[2], run.held[2] + 5);
  EXPECT_TRUE(bench.controller.live().displaced);

  EXPECT_EQ(bench.press(Action::cycle_start).reason, "wrong_mode");
  set_mode(bench, Mode::memory);
  ASSERT_TRUE(bench.start());
  EXPECT_EQ(bench.state(), State::hold) << "on the way back";
  bool cut_away_from_the_path = false, back = false;
  ASSERT_TRUE(limits.until(
      [&] {
        const AxisVector& at = bench.controller.sample().position;
        const bool here = at[1] == run.held[1] && at[2] == run.held[2];
        back = back || here;
        if (!here && !back && at[0] != run.held[0]) cut_away_from_the_path = true;
        if (back && at[2] != run.held[2]) cut_away_from_the_path = true;
        return bench.state() == State::idle;
      },
      60));
  EXPECT_TRUE(back);
  EXPECT_FALSE(cut_away_from_the_path);
  EXPECT_EQ(bench.controller.sample().position[0], 40);
  EXPECT_EQ(bench.controller.sample().position[1], 20);
  limits.expect_inside();
}

TEST(Intervention, AtAProgramStopToo) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\nG01 X10. F2000.\nM00\nX20.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  set_mode(bench, Mode::handle);
  ASSERT_TRUE(bench.controller.step_axis(2, 8).accepted);
  for (int i = 0; i < 2000; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position[2], 8);
  EXPECT_EQ(bench.state(), State::stopped);
  set_mode(bench, Mode::memory);
  ASSERT_TRUE(bench.start());
  bool moved_off = false;
  ASSERT_TRUE(bench.until(
      [&] {
        const AxisVector& at = bench.controller.sample().position;
        moved_off = moved_off || (at[0] > 10 && at[2] != 0);
        return bench.state() == State::idle;
      },
      30));
  EXPECT_FALSE(moved_off);
  EXPECT_EQ(bench.controller.sample().position[0], 20);
  EXPECT_EQ(bench.controller.sample().position[2], 0);
}

TEST(Intervention, WithManualAbsoluteOffTheRestIsDisplaced) {
  Held run;
  Bench& bench = run.bench;
  ASSERT_TRUE(bench.press(Action::set_manual_absolute, 0).accepted);
  set_mode(bench, Mode::jog);
  ASSERT_TRUE(bench.controller.step_axis(1, 3).accepted);
  for (int i = 0; i < 1500; ++i) bench.period();
  set_mode(bench, Mode::memory);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_NEAR(bench.controller.sample().position[0], 40, 1e-9);
  EXPECT_NEAR(bench.controller.sample().position[1], 23, 1e-9);
  for (int i = 0; i < 10; ++i) bench.period();
  EXPECT_FALSE(bench.controller.live().displaced) << "the next run knows where the axes stand";
  bench.press(Action::set_manual_absolute, 1);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_NEAR(bench.controller.sample().position[1], 20, 1e-9);
}

TEST(Intervention, ADisplacedProgramIsStoppedInsideTheTravel) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.axes[0].max_mm = 50;
  Bench bench(machine);
  bench.load("O1\nG90 G94 G21\nG01 X20. F1000.\nM00\nX49. F6000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  bench.press(Action::set_manual_absolute, 0);
  set_mode(bench, Mode::jog);
  ASSERT_TRUE(bench.controller.step_axis(0, 5).accepted);
  for (int i = 0; i < 1500; ++i) bench.period();
  set_mode(bench, Mode::memory);
  ASSERT_TRUE(bench.start());
  double most = 0;
  ASSERT_TRUE(bench.until(
      [&] {
        most = std::max(most, bench.controller.sample().position[0]);
        return bench.state() == State::alarm && !bench.controller.sample().moving;
      },
      30));
  EXPECT_EQ(bench.controller.live().alarms.front().code, "OT0500");
  EXPECT_LE(most, 50.01);
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
}

TEST(Intervention, FeedHoldStopsTheWayBackAndCycleStartGoesOnWithIt) {
  Held run;
  Bench& bench = run.bench;
  set_mode(bench, Mode::jog);
  ASSERT_TRUE(bench.controller.step_axis(2, 12).accepted);
  for (int i = 0; i < 2000; ++i) bench.period();
  set_mode(bench, Mode::memory);
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 150; ++i) bench.period();
  bench.press(Action::feed_hold);
  for (int i = 0; i < 500; ++i) bench.period();
  const AxisVector stood = bench.controller.sample().position;
  EXPECT_GT(stood[2], run.held[2]);
  EXPECT_LT(stood[2], run.held[2] + 12);
  for (int i = 0; i < 1000; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position, stood);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_EQ(bench.controller.sample().position[2], run.held[2]);
  EXPECT_EQ(bench.controller.sample().position[0], 40);
}

TEST(Intervention, ResetLeavesTheAxesWhereTheHandHasPutThem) {
  Held run;
  Bench& bench = run.bench;
  set_mode(bench, Mode::jog);
  ASSERT_TRUE(bench.controller.step_axis(2, 4).accepted);
  for (int i = 0; i < 1500; ++i) bench.period();
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  EXPECT_NEAR(bench.controller.sample().position[2], run.held[2] + 4, 1e-9);
  EXPECT_FALSE(bench.controller.live().displaced);
  bench.load("O2\nG90 G94 G21\nG01 Z1. F3000.\nM30\n", "O2");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  EXPECT_EQ(bench.controller.sample().position[2], 1);
}

TEST(ByHand, NotInARunningProgram) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\nG01 X40. F2000.\nM30\n");
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 100; ++i) bench.period();
  EXPECT_EQ(bench.press(Action::set_mode, static_cast<double>(Mode::jog)).reason, "running");
  EXPECT_EQ(bench.controller.jog(0, 1).reason, "running");
}

TEST(ByHand, AJogStopsBeforeAForbiddenZone) {
  Bench bench("fanuc-0i-m");
  bench.controller.edit_data(
      [](interp::MachineData& data) {
        data.parameters["1324/X"] = 30;
        data.parameters["1325/X"] = 20;
      },
      {}, "test");
  set_mode(bench, Mode::jog);
  ASSERT_TRUE(bench.controller.jog(0, 1, Controller::JogSpeed::rapid).accepted);
  LimitsOnBench limits(bench);
  for (int i = 0; i < 3000; ++i) limits.period();
  EXPECT_NEAR(bench.controller.sample().position[0], 20, 0.05);
  EXPECT_LT(bench.controller.sample().position[0], 20);
  limits.expect_inside();
  EXPECT_EQ(bench.controller.step_axis(0, 1).reason, "travel_limit");
}

}  // namespace
}  // namespace headstock::operation

// Jog, steps, reference return, MDI: what moves, what is refused, and that it stops.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"

namespace headstock::operation {
namespace {

bool stands(Bench& bench) {
  const AxisVector before = bench.controller.sample().position;
  for (int i = 0; i < 50; ++i) bench.period();
  return bench.controller.sample().position == before && !bench.controller.sample().moving;
}
void set_mode(Bench& bench, Mode mode) {
  ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(mode)).accepted);
}

TEST(Manual, JogMovesWhileTheButtonIsDown) {
  Bench bench;
  set_mode(bench, Mode::jog);
  ASSERT_TRUE(bench.controller.jog(0, 1).accepted);
  for (int i = 0; i < 1000; ++i) bench.period();
  EXPECT_NEAR(bench.controller.sample().path_speed_mm_s, 1000.0 / 60, 0.05);
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "running");
  EXPECT_EQ(bench.press(Action::set_mode, static_cast<double>(Mode::memory)).reason, "running");
  ASSERT_TRUE(bench.controller.jog(0, 0).accepted);
  for (int i = 0; i < 500; ++i) bench.period();
  EXPECT_TRUE(stands(bench));
  const double x = bench.controller.sample().position[0];
  EXPECT_GT(x, 14);
  EXPECT_LT(x, 20);
  EXPECT_NEAR(bench.controller.live().machine[0], x, 1e-3);
  // Nothing of the jog is left over: the other way, and a program after it.
  ASSERT_TRUE(bench.controller.jog(0, -1).accepted);
  for (int i = 0; i < 100; ++i) bench.period();
  EXPECT_LT(bench.controller.sample().position[0], x);
  bench.controller.jog(0, 0);
  for (int i = 0; i < 500; ++i) bench.period();
  bench.load("O1\nG90 G94 G21\nG01 X3. F3000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  EXPECT_EQ(bench.controller.sample().position[0], 3);
}

TEST(Manual, JogStopsAtTheTravelLimit) {
  Bench bench;
  set_mode(bench, Mode::jog);
  bench.press(Action::set_feed_override, 2.5);
  const double limit = bench.controller.machine().axes[2].min_mm;
  ASSERT_TRUE(bench.controller.jog(2, -1).accepted);
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[2] < limit + 0.01; }, 300));
  EXPECT_TRUE(bench.until([&] { return !bench.controller.sample().moving; }, 2));
  EXPECT_GE(bench.controller.sample().position[2], limit);
  for (int i = 0; i < 50; ++i) bench.period();
  EXPECT_EQ(bench.controller.jog(2, -1).reason, "travel_limit");
}

TEST(Manual, StepsAddUp) {
  Bench bench;
  set_mode(bench, Mode::handle);
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(bench.controller.step_axis(1, 0.1).accepted) << i;
    for (int k = 0; k < 7; ++k) bench.period();
  }
  for (int i = 0; i < 1500; ++i) bench.period();
  EXPECT_NEAR(bench.controller.sample().position[1], 1, 1e-9);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(bench.controller.step_axis(1, -0.1).accepted);
  for (int i = 0; i < 1500; ++i) bench.period();
  EXPECT_NEAR(bench.controller.sample().position[1], 0, 1e-9);
  EXPECT_EQ(bench.controller.step_axis(1, 1e6).reason, "travel_limit");
  EXPECT_TRUE(stands(bench));
}

TEST(Manual, ReferenceReturn) {
  Bench bench;
  set_mode(bench, Mode::jog);
  ASSERT_TRUE(bench.controller.step_axis(0, -12.5).accepted);
  for (int i = 0; i < 3000; ++i) bench.period();
  set_mode(bench, Mode::reference);
  ASSERT_TRUE(bench.controller.reference_return(0).accepted);
  for (int i = 0; i < 3000; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position[0], bench.controller.machine().axes[0].reference_mm);
}

TEST(Manual, RefusedInOtherModesAndStates) {
  Bench bench;
  EXPECT_EQ(bench.controller.jog(0, 1).reason, "wrong_mode");
  EXPECT_EQ(bench.controller.reference_return(0).reason, "wrong_mode");
  EXPECT_EQ(bench.controller.enter_mdi("G01 X1. F100.").reason, "wrong_mode");
  set_mode(bench, Mode::jog);
  EXPECT_EQ(bench.controller.jog(9, 1).reason, "bad_value");
  bench.press(Action::emergency_stop);
  EXPECT_EQ(bench.controller.jog(0, 1).reason, "emergency_stop");
}

TEST(Manual, ResetStopsAJog) {
  Bench bench;
  set_mode(bench, Mode::jog);
  ASSERT_TRUE(bench.controller.jog(0, 1).accepted);
  for (int i = 0; i < 500; ++i) bench.period();
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  EXPECT_TRUE(stands(bench));
}

TEST(Mdi, CarriesOutTheBlockOnce) {
  Bench bench;
  set_mode(bench, Mode::mdi);
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "no_program");
  ASSERT_TRUE(bench.controller.enter_mdi("G90 G94 G21 G01 X7. F2000.\n").accepted);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.state() != State::running; }, 20));
  EXPECT_EQ(bench.state(), State::idle) << "no alarm for want of an M30";
  EXPECT_EQ(bench.controller.sample().position[0], 7);
  for (int i = 0; i < 100; ++i) bench.period();
  if (bench.state() == State::alarm) bench.press(Action::reset);
  bench.until_state(State::idle, 5);
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "no_program");
}

}  // namespace
}  // namespace headstock::operation

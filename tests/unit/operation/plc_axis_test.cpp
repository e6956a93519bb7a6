// An axis of the ladder moves on its own, also while a program runs; no program moves it.
#include <gtest/gtest.h>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

machine::Machine with_plc_axis() {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine::Axis b;
  b.name = 'B';
  b.rotary = true;
  b.plc = true;
  b.rapid_mm_min = 6'000;
  b.min_mm = -360;
  b.max_mm = 360;
  machine.axes.push_back(b);
  return machine;
}

TEST(PlcAxis, MovesWhileAProgramRunsWithoutDisturbingIt) {
  Bench bench(with_plc_axis());
  bench.load("O1\nG90 G94 G21\nG01 X10. F600.\nG04 P100\nX20.\nM30\n");
  LimitsOnBench limits(bench);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(limits.until([&] { return bench.controller.sample().position[0] > 2; }, 20));
  ASSERT_TRUE(bench.controller.move_plc_axis(3, 90, 6'000).accepted);
  ASSERT_TRUE(limits.until([&] { return bench.state() == State::idle; }, 60));
  EXPECT_EQ(bench.controller.sample().position[3], 90);
  EXPECT_EQ(bench.controller.sample().position[0], 20);
  limits.expect_inside();
  for (int i = 0; i < 100; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position[3], 90);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_EQ(bench.controller.sample().position[3], 90) << "the next run leaves it alone";
}

TEST(PlcAxis, IsNotTheProgramsAndStaysInsideItsTravel) {
  Bench bench(with_plc_axis());
  EXPECT_EQ(bench.controller.move_plc_axis(3, 400, 1000).reason, "travel_limit");
  EXPECT_EQ(bench.controller.move_plc_axis(0, 1, 1000).reason, "bad_value");
  bench.load("O1\nG90 G94 G21\nG01 B10. F600.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 20));
  EXPECT_EQ(bench.controller.live().alarms.front().code, "PS0130");
}

TEST(PlcAxis, ResetStopsIt) {
  Bench bench(with_plc_axis());
  ASSERT_TRUE(bench.controller.move_plc_axis(3, 300, 6'000).accepted);
  for (int i = 0; i < 500; ++i) bench.period();
  EXPECT_TRUE(bench.controller.sample().moving);
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  const double stood = bench.controller.sample().position[3];
  EXPECT_LT(stood, 300);
  for (int i = 0; i < 500; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position[3], stood);
}

}  // namespace
}  // namespace headstock::operation

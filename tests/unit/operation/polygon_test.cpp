// Polygon turning: the tool axis turns with the spindle, in its ratio, between G51.2 and G50.2.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

machine::Machine with_tool_axis() {
  machine::Machine machine = *machine::default_machine("fanuc-0i-t");
  machine::Axis b;
  b.name = 'B';
  b.rotary = true;
  b.rapid_mm_min = 1'000'000;
  b.max_feed_mm_min = 1'000'000;
  b.max_acceleration_mm_s2 = 40'000;
  b.max_jerk_mm_s3 = 4'000'000;
  b.min_mm = -1e6;
  b.max_mm = 1e6;
  machine.axes.push_back(b);
  machine.polygon_axis = 'B';
  return machine;
}

void name_tool_axis(Bench& bench) {
  bench.controller.edit_data([](interp::MachineData& data) { data.parameters["7610"] = 3; }, {}, "test");
}

TEST(Polygon, TheToolKeepsItsRatioAndItsPhase) {
  Bench bench(with_tool_axis());
  name_tool_axis(bench);
  bench.load("O1\nG98 G21 G97\nG00 X60. Z5.\nM03 S500\nG51.2 P1 Q2\nG01 Z-10. F200.\nG50.2\nM05\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until(
      [&] { return bench.controller.sample().position[1] < 4 && bench.controller.cutting(); }, 60));
  const double tool = bench.controller.sample().position[2], phase = bench.controller.spindle().phase_rad();
  double worst = 0;
  while (bench.controller.sample().position[1] > -9) {
    bench.period();
    const double turned = (bench.controller.spindle().phase_rad() - phase) * 180 / std::numbers::pi;
    worst = std::max(worst, std::abs(bench.controller.sample().position[2] - tool - 2 * turned));
    ASSERT_EQ(bench.state(), State::running);
  }
  EXPECT_LT(worst, 6.1) << "one period's turn at most";
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  const double stood = bench.controller.sample().position[2];
  EXPECT_LE(std::abs(stood), 180);
  for (int i = 0; i < 100; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position[2], stood);
}

// A tool axis that follows its drive is never in position while it turns: nothing waits for that.
TEST(Polygon, WithAServoThatLagsTheProgramGoesOn) {
  ControllerOptions options;  // none given: the simulated servo drive
  options.now_ms = [] { return std::int64_t{0}; };
  Bench bench(with_tool_axis(), std::move(options));
  name_tool_axis(bench);
  bench.load("O1\nG98 G21 G97\nG00 X60. Z5.\nM03 S500\nG51.2 P1 Q2\nG01 Z-10. F600.\nG50.2\nM05\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.state() != State::running && bench.periods > 100; }, 60));
  EXPECT_EQ(bench.state(), State::idle);
  EXPECT_EQ(bench.controller.sample().position[1], -10);
}

TEST(Polygon, TooFastForTheToolAxisIsAnAlarmBeforeItTurns) {
  machine::Machine machine = with_tool_axis();
  machine.axes[2].max_feed_mm_min = 100'000;
  Bench bench(machine);
  name_tool_axis(bench);
  bench.load("O1\nG98 G21 G97\nM03 S500\nG51.2 P1 Q2\nG50.2\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 60));
  EXPECT_EQ(bench.controller.live().alarms.front().code, "PS5018");
  EXPECT_EQ(bench.controller.sample().position[2], 0);
}

TEST(Polygon, AMachineWithoutAToolAxisRefuses) {
  Bench bench("fanuc-0i-t");
  name_tool_axis(bench);
  bench.load("O1\nG98 G21 G97\nM03 S500\nG51.2 P1 Q2\nG50.2\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 60));
}

TEST(Polygon, ResetStopsTheTool) {
  Bench bench(with_tool_axis());
  name_tool_axis(bench);
  bench.load("O1\nG98 G21 G97\nG00 X60. Z5.\nM03 S500\nG51.2 P1 Q1\nG01 Z-50. F200.\nG50.2\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[1] < 3; }, 60));
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 10));
  const double stood = bench.controller.sample().position[2];
  for (int i = 0; i < 300; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position[2], stood);
}

}  // namespace
}  // namespace headstock::operation

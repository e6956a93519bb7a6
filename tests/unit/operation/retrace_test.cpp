// Handle retrace: back along what was cut and forward again, lines and arcs, and the program goes on as if
// nothing had been.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

const char* const kProgram =
    "O1\nG90 G94 G21\nG01 X20. F2000.\nG03 X30. Y10. I0. J10.\nG01 Y30.\nX60.\nM30\n";

// How far the axes are from the programmed path.
double off_path(const AxisVector& at) {
  const double x = at[0], y = at[1];
  const auto segment = [&](double x0, double y0, double x1, double y1) {
    const double dx = x1 - x0, dy = y1 - y0;
    const double t = std::clamp(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
    return std::hypot(x - x0 - t * dx, y - y0 - t * dy);
  };
  double best = std::min({segment(0, 0, 20, 0), segment(30, 10, 30, 30), segment(30, 30, 60, 30)});
  if (x >= 20 && y <= 10) best = std::min(best, std::abs(std::hypot(x - 20, y - 10) - 10));
  return best;
}

struct HeldAt {
  explicit HeldAt(double y) {
    bench.load(kProgram);
    bench.start();
    bench.until([&] { return bench.controller.sample().position[1] > y; }, 60);
    bench.press(Action::feed_hold);
    bench.until([&] { return !bench.controller.sample().moving; }, 5);
    bench.press(Action::set_mode, static_cast<double>(Mode::handle));
    held = bench.controller.sample().position;
  }
  void rest(LimitsOnBench& limits) {
    for (int i = 0; i < 20; ++i) limits.period();
    ASSERT_TRUE(limits.until([&] { return !bench.controller.sample().moving; }, 60));
    for (int i = 0; i < 20; ++i) limits.period();
  }
  Bench bench;
  AxisVector held{};
};

TEST(Retrace, BackOverACornerAndAnArcAndOn) {
  HeldAt run(20);
  Bench& bench = run.bench;
  LimitsOnBench limits(bench);
  ASSERT_TRUE(bench.controller.retrace(-30).accepted);
  double worst = 0;
  for (int i = 0; i < 4000; ++i) {
    limits.period();
    worst = std::max(worst, off_path(bench.controller.sample().position));
  }
  EXPECT_LT(worst, 0.0101);
  // 30 mm back from (30, 20): 10 to the arc's end, 15.7 over the arc, the rest along X.
  const AxisVector back = bench.controller.sample().position;
  EXPECT_NEAR(back[1], 0, 0.01);
  EXPECT_NEAR(back[0], 20 - (30 - (run.held[1] - 10) - 5 * M_PI), 0.05);
  EXPECT_EQ(bench.state(), State::hold);
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "wrong_mode");

  ASSERT_TRUE(bench.controller.retrace(12).accepted);
  run.rest(limits);
  EXPECT_GT(bench.controller.sample().position[0], 20);
  ASSERT_TRUE(bench.controller.retrace(1000).accepted) << "no further than where it was held";
  run.rest(limits);
  EXPECT_EQ(bench.controller.sample().position, run.held);
  EXPECT_EQ(bench.controller.retrace(1).reason, "nothing_to_retrace");

  bench.press(Action::set_mode, static_cast<double>(Mode::memory));
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(limits.until([&] { return bench.state() == State::idle; }, 60));
  EXPECT_EQ(bench.controller.sample().position[0], 60);
  EXPECT_EQ(bench.controller.live().parts, 1u);
  limits.expect_inside();
}

TEST(Retrace, CycleStartGoesForwardToWhereItWasHeldFirst) {
  HeldAt run(20);
  Bench& bench = run.bench;
  LimitsOnBench limits(bench);
  ASSERT_TRUE(bench.controller.retrace(-25).accepted);
  run.rest(limits);
  EXPECT_LT(bench.controller.sample().position[1], 10);
  bench.press(Action::set_mode, static_cast<double>(Mode::memory));
  ASSERT_TRUE(bench.start());
  EXPECT_EQ(bench.state(), State::hold);
  double worst = 0;
  ASSERT_TRUE(limits.until(
      [&] {
        worst = std::max(worst, off_path(bench.controller.sample().position));
        return bench.state() == State::idle;
      },
      60));
  EXPECT_LT(worst, 0.0101);
  EXPECT_EQ(bench.controller.sample().position[0], 60);
  limits.expect_inside();
}

TEST(Retrace, StopsAtTheBeginningOfWhatIsKnown) {
  HeldAt run(20);
  Bench& bench = run.bench;
  LimitsOnBench limits(bench);
  ASSERT_TRUE(bench.controller.retrace(-10'000).accepted);
  run.rest(limits);
  EXPECT_NEAR(bench.controller.sample().position[0], 0, 1e-9);
  EXPECT_EQ(bench.controller.retrace(-1).reason, "nothing_to_retrace");
  limits.expect_inside();
}

TEST(Retrace, FeedHoldStopsItAndItGoesOnFromThere) {
  HeldAt run(20);
  Bench& bench = run.bench;
  LimitsOnBench limits(bench);
  ASSERT_TRUE(bench.controller.retrace(-40).accepted);
  for (int i = 0; i < 700; ++i) limits.period();
  EXPECT_EQ(bench.controller.retrace(1).reason, "running");
  bench.press(Action::feed_hold);
  run.rest(limits);
  const AxisVector stood = bench.controller.sample().position;
  EXPECT_LT(off_path(stood), 0.0101);
  EXPECT_NE(stood, run.held);
  ASSERT_TRUE(bench.controller.retrace(1000).accepted);
  run.rest(limits);
  EXPECT_EQ(bench.controller.sample().position, run.held);
  limits.expect_inside();
}

TEST(Retrace, ResetLeavesTheAxesWhereTheyAre) {
  HeldAt run(20);
  Bench& bench = run.bench;
  LimitsOnBench limits(bench);
  ASSERT_TRUE(bench.controller.retrace(-30).accepted);
  for (int i = 0; i < 900; ++i) limits.period();
  bench.press(Action::reset);
  ASSERT_TRUE(limits.until([&] { return bench.state() == State::idle; }, 5));
  const AxisVector stood = bench.controller.sample().position;
  EXPECT_NE(stood, run.held);
  for (int i = 0; i < 500; ++i) limits.period();
  EXPECT_EQ(bench.controller.sample().position, stood);
  limits.expect_inside();
  bench.load("O2\nG90 G94 G21\nG01 X5. Y5. F2000.\nM30\n", "O2");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_EQ(bench.controller.sample().position[0], 5);
}

TEST(Retrace, OnlyInAHeldProgramAndByTheHandle) {
  Bench bench;
  bench.load(kProgram);
  EXPECT_FALSE(bench.controller.retrace(-1).accepted);
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 300; ++i) bench.period();
  EXPECT_FALSE(bench.controller.retrace(-1).accepted);
}

}  // namespace
}  // namespace headstock::operation

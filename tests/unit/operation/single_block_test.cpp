// Single block switched on in the middle of a run: the axes stop at the end of the block that is being cut,
// however much is queued behind it.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bench.hpp"

namespace headstock::operation {
namespace {

// The last two segments of the square come before the spindle stops; everything is queued in the first
// period.
const char* const kSquare = "O1\nG90 G94 G21 G64\nG01 X30. F3000.\nY30.\nX0.\nY0.\nM08\nX5.\nM30\n";
constexpr double kCorners[][2] = {{30, 0}, {30, 30}, {0, 30}, {0, 0}, {5, 0}};

bool at_corner(const motion::Sample& sample, std::size_t corner, double within) {
  return std::hypot(sample.position[0] - kCorners[corner][0], sample.position[1] - kCorners[corner][1]) <=
         within;
}

TEST(SingleBlock, StopsAtTheEndOfTheBlockBeingCut) {
  std::mt19937 random(5);
  for (int round = 0; round < 30; ++round) {
    Bench bench;
    bench.load(kSquare);
    ASSERT_TRUE(bench.start());
    const std::uint64_t pressed = 50 + random() % 1500;
    while (bench.periods < pressed) bench.period();
    const std::uint32_t line = bench.controller.traced_block().line;  // 3 … 6
    ASSERT_TRUE(bench.press(Action::set_single_block, 1).accepted);
    ASSERT_TRUE(bench.until_state(State::stopped, 20)) << pressed;
    const motion::Sample first = bench.controller.sample();
    EXPECT_FALSE(first.moving);
    // Too near the end to stop there: the next block's end. Never farther.
    const bool here = at_corner(first, line - 3, 0.011), next = at_corner(first, line - 2, 0.011);
    EXPECT_TRUE(here || next) << "pressed in period " << pressed << ", line " << line << ", stopped at "
                              << first.position[0] << ' ' << first.position[1];
    for (int i = 0; i < 300; ++i) bench.period();
    EXPECT_EQ(bench.state(), State::stopped);
    EXPECT_EQ(bench.controller.sample().position, first.position);
    // Then block by block to the end: before M08, before X5, before M30.
    std::size_t stops = 1;
    while (bench.state() == State::stopped) {
      ASSERT_TRUE(bench.start());
      ASSERT_TRUE(
          bench.until([&] { return bench.state() == State::stopped || bench.state() == State::idle; }, 20));
      if (bench.state() == State::stopped) ++stops;
      ASSERT_LT(stops, 10u);
    }
    const std::size_t corner = here ? line - 3 : line - 2;
    EXPECT_EQ(stops, 1 + (3 - std::min<std::size_t>(corner, 3)) + 2) << pressed;
    EXPECT_EQ(bench.controller.live().parts, 1u);
    EXPECT_TRUE(at_corner(bench.controller.sample(), 4, 1e-9));
  }
}

TEST(SingleBlock, AFunctionThatIsAlreadyPostedWaits) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\nG01 X30. F3000.\nM08\nX40.\nM30\n");
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 100; ++i) bench.period();
  bench.press(Action::set_single_block, 1);
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  EXPECT_EQ(bench.controller.sample().position[0], 30);
  EXPECT_FALSE(bench.controller.live().coolant);
  for (int i = 0; i < 200; ++i) bench.period();
  EXPECT_FALSE(bench.controller.live().coolant);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  EXPECT_TRUE(bench.controller.live().coolant);
  EXPECT_EQ(bench.controller.sample().position[0], 30);
}

TEST(SingleBlock, SwitchedOffWhileStandingStillWaitsForCycleStart) {
  Bench bench;
  bench.load(kSquare);
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 200; ++i) bench.period();
  bench.press(Action::set_single_block, 1);
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  bench.press(Action::set_single_block, 0);
  for (int i = 0; i < 500; ++i) bench.period();
  EXPECT_EQ(bench.state(), State::stopped);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  EXPECT_TRUE(at_corner(bench.controller.sample(), 4, 1e-9));
}

TEST(SingleBlock, ResetFromTheStopEndsTheRun) {
  Bench bench;
  bench.load(kSquare);
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 200; ++i) bench.period();
  bench.press(Action::set_single_block, 1);
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  const AxisVector stands = bench.controller.sample().position;
  for (int i = 0; i < 500; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position, stands);
}

}  // namespace
}  // namespace headstock::operation

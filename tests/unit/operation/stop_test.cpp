// Hold, resume, reset, single block and emergency stop at any instant.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bench.hpp"

namespace headstock::operation {
namespace {

const char* const kProgram =
    "O1\nG90 G94 G21\nM03 S500\nG01 X20. F4000.\nG01 X20. Y10.\nG03 X0. Y10. I-10. J0.\nG04 P200\nG01 X0. "
    "Y0.\n"
    "G00 Z-10.\nX5. Y5.\nM05\nM30\n";

// Everything that must hold at every period: no limit of velocity broken, state and motion agree.
void check_period(Bench& bench, AxisVector& last) {
  const motion::Sample& sample = bench.controller.sample();
  const auto& machine = bench.controller.machine();
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const double v = std::abs(sample.position[i] - last[i]) / (machine.period_us * 1e-6);
    ASSERT_LE(v, machine.axes[i].rapid_mm_min / 60 * 1.001);
  }
  last = sample.position;
  const State state = bench.state();
  ASSERT_FALSE(sample.moving && (state == State::idle || state == State::alarm));
}

TEST(Stop, HoldAndResumeAtRandomInstantsChangesNeitherPathNorCount) {
  std::mt19937 random(7);
  for (int round = 0; round < 40; ++round) {
    Bench bench;
    bench.load(kProgram);
    ASSERT_TRUE(bench.start());
    AxisVector last = bench.controller.sample().position;
    std::uint64_t next = random() % 700;
    int holds = 0;
    while (bench.state() != State::idle) {
      bench.period();
      check_period(bench, last);
      if (bench.periods < next) continue;
      next = bench.periods + 1 + random() % 700;
      if (bench.state() == State::running) {
        EXPECT_TRUE(bench.press(Action::feed_hold).accepted);
        ASSERT_EQ(bench.state(), State::hold);
        ++holds;
        const int pause = static_cast<int>(random() % 600);
        for (int i = 0; i < pause; ++i) {
          bench.period();
          check_period(bench, last);
        }
        ASSERT_FALSE(pause > 500 && bench.controller.sample().moving);
        // M30 may have been reached in the meantime: then there is nothing to go on with.
        if (bench.state() == State::hold) {
          ASSERT_TRUE(bench.start());
        }
      }
      ASSERT_LT(bench.periods, 200'000u);
    }
    EXPECT_GT(holds, 0);
    EXPECT_NEAR(last[0], 5, 1e-9);
    EXPECT_NEAR(last[1], 5, 1e-9);
    EXPECT_NEAR(last[2], -10, 1e-9);
    EXPECT_EQ(bench.controller.live().parts, 1u);
  }
}

TEST(Stop, AHeldMachineStaysHeld) {
  Bench bench;
  bench.load(kProgram);
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 700; ++i) bench.period();
  bench.press(Action::feed_hold);
  for (int i = 0; i < 1000; ++i) bench.period();
  const AxisVector held = bench.controller.sample().position;
  for (int i = 0; i < 20'000; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position, held);
  EXPECT_EQ(bench.state(), State::hold);
}

TEST(Stop, ResetAtRandomInstantsLeavesASoundMachine) {
  std::mt19937 random(11);
  for (int round = 0; round < 60; ++round) {
    Bench bench;
    bench.load(kProgram);
    ASSERT_TRUE(bench.start());
    AxisVector last = bench.controller.sample().position;
    const std::uint64_t at = random() % 3000;
    while (bench.periods < at && bench.state() != State::idle) {
      bench.period();
      check_period(bench, last);
    }
    EXPECT_TRUE(bench.press(Action::reset).accepted);
    for (int i = 0; bench.state() != State::idle; ++i) {
      ASSERT_LT(i, 2000);
      EXPECT_FALSE(bench.start()) << "nothing starts while the axes are braking";
      bench.period();
      check_period(bench, last);
    }
    EXPECT_FALSE(bench.controller.sample().moving);
    EXPECT_EQ(bench.controller.live().spindle_commanded_rpm, 0);
    // Positions can be trusted: the next run from here ends where it should.
    const auto parts = bench.controller.live().parts;
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until_state(State::idle));
    EXPECT_NEAR(bench.controller.sample().position[0], 5, 1e-9);
    EXPECT_NEAR(bench.controller.sample().position[2], -10, 1e-9);
    EXPECT_EQ(bench.controller.live().parts, parts + 1);
  }
}

TEST(Stop, SingleBlockStopsAfterEachBlock) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\nG01 X10. F3000.\nX20.\nX30.\nM30\n");
  bench.press(Action::set_single_block, 1);
  ASSERT_TRUE(bench.start());
  for (const double x : {10., 20., 30.}) {
    ASSERT_TRUE(bench.until_state(State::stopped, 20));
    EXPECT_NEAR(bench.controller.sample().position[0], x, 1e-9);
    for (int i = 0; i < 500; ++i) bench.period();
    EXPECT_EQ(bench.state(), State::stopped);
    ASSERT_TRUE(bench.start());
  }
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  EXPECT_EQ(bench.controller.live().parts, 1u);
}

TEST(Stop, M00WaitsForCycleStartAndM01OnlyWithTheSwitch) {
  for (const bool optional : {false, true}) {
    Bench bench;
    bench.load("O1\nG90 G94 G21\nG01 X1. F3000.\nM00\nX2.\nM01\nX3.\nM30\n");
    bench.press(Action::set_optional_stop, optional ? 1 : 0);
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until_state(State::stopped, 20));
    EXPECT_NEAR(bench.controller.sample().position[0], 1, 1e-9);
    ASSERT_TRUE(bench.start());
    if (optional) {
      ASSERT_TRUE(bench.until_state(State::stopped, 20));
      EXPECT_NEAR(bench.controller.sample().position[0], 2, 1e-9);
      ASSERT_TRUE(bench.start());
    }
    ASSERT_TRUE(bench.until([&] { return bench.state() == State::idle; }, 20));
    EXPECT_NEAR(bench.controller.sample().position[0], 3, 1e-9);
  }
}

TEST(Stop, BlockSkipLeavesOutMarkedBlocks) {
  for (const bool skip : {false, true}) {
    Bench bench;
    bench.load("O1\nG90 G94 G21\nG01 X1. F3000.\n/Y5.\nX2.\nM30\n");
    bench.press(Action::set_block_skip, skip ? 1 : 0);
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until_state(State::idle, 20));
    EXPECT_NEAR(bench.controller.sample().position[1], skip ? 0 : 5, 1e-9);
  }
}

TEST(Stop, EmergencyStopAtRandomInstantsThenReleaseAndRun) {
  std::mt19937 random(5);
  for (int round = 0; round < 30; ++round) {
    ControllerOptions options;  // the simulated servo drive: the measured position is what counts
    options.now_ms = [] { return std::int64_t{0}; };
    Bench bench("fanuc-0i-m", std::move(options));
    bench.load(kProgram);
    ASSERT_TRUE(bench.start());
    const std::uint64_t at = 300 + random() % 2500;
    while (bench.periods < at && bench.state() != State::idle) bench.period();
    ASSERT_TRUE(bench.press(Action::emergency_stop, 0, Origin::network).accepted);
    EXPECT_EQ(bench.state(), State::emergency_stop);
    for (int i = 0; i < 1000; ++i) bench.period();
    const AxisVector stopped = bench.controller.live().machine;
    EXPECT_EQ(bench.press(Action::cycle_start).reason, "emergency_stop");
    EXPECT_EQ(bench.press(Action::emergency_stop_release, 0, Origin::network).reason, "panel_only");
    ASSERT_TRUE(bench.press(Action::emergency_stop_release).accepted);
    for (int i = 0; i < 500; ++i) bench.period();
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(bench.controller.live().machine[static_cast<std::size_t>(i)],
                  stopped[static_cast<std::size_t>(i)], 1e-4);
    EXPECT_EQ(bench.state(), State::idle);
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until_state(State::idle));
    EXPECT_NEAR(bench.controller.sample().position[0], 5, 1e-9);
  }
}

TEST(Stop, MachineLockShowsMotionButMovesNothing) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\nG01 X10. F3000.\nM30\n");
  ASSERT_TRUE(bench.press(Action::set_machine_lock, 1).accepted);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_NEAR(bench.controller.live().machine[0], 10, 1e-9);
  ASSERT_TRUE(bench.press(Action::set_machine_lock, 0).accepted);
  ASSERT_TRUE(bench.until_state(State::idle, 1));
  EXPECT_NEAR(bench.controller.live().machine[0], 0, 1e-9) << "the axes never left their place";
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_NEAR(bench.controller.live().machine[0], 10, 1e-9);
}

TEST(Stop, FeedOverrideZeroStandsAndComesBack) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\nG01 X50. F3000.\nM30\n");
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 300; ++i) bench.period();
  bench.press(Action::set_feed_override, 0);
  for (int i = 0; i < 1000; ++i) bench.period();
  const double x = bench.controller.sample().position[0];
  for (int i = 0; i < 1000; ++i) bench.period();
  EXPECT_NEAR(bench.controller.sample().position[0], x, 1e-6);
  EXPECT_EQ(bench.press(Action::set_feed_override, 3).reason, "bad_value");
  bench.press(Action::set_feed_override, 1.5);
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_NEAR(bench.controller.sample().position[0], 50, 1e-9);
}

// More moves than are remembered have been made, and nothing is traced since the position was set: the next
// program starts all the same.
TEST(Stop, AProgramStartsAfterAnyNumberOfMoves) {
  Bench bench;
  bench.load(
      "O1\nG91 G94 G21\n#1=0\nWHILE[#1LT4500]DO1\nG01 X0.01 F6000.\nX-0.01\n#1=#1+1\nEND1\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 600));
  ASSERT_TRUE(bench.press(Action::reset).accepted);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  for (int i = 0; i < 10; ++i) bench.period();
  bench.load("O2\nG90 G94 G21\nG01 X5. F3000.\nM30\n", "O2");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 30));
  EXPECT_EQ(bench.controller.sample().position[0], 5);
}

}  // namespace
}  // namespace headstock::operation

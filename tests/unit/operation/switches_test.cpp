// What keys and macro variables do to the motion: F0, dry run, #3003, #3004; positioning that is not
// interpolated.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

TEST(RapidOverride, F0IsTheRateOfItsParameter) {
  for (const bool set : {false, true}) {
    Bench bench;
    if (set)
      bench.controller.edit_data([](interp::MachineData& data) { data.parameters["1421/X"] = 300; }, {},
                                 "test");
    if (set)
      bench.controller.edit_data(
          [](interp::MachineData& data) {
            data.parameters["1421/Y"] = 400;
            data.parameters["1421/Z"] = 400;
          },
          {}, "test");
    bench.load("O1\nG90 G94 G21\nG00 X50.\nM30\n");
    bench.press(Action::set_rapid_override, 0);
    ASSERT_TRUE(bench.start());
    for (int i = 0; i < 2000; ++i) bench.period();
    EXPECT_NEAR(bench.controller.sample().velocity[0], set ? 5 : 0, 0.01);
  }
}

TEST(RapidOverride, QuarterAndHalf) {
  for (const double ratio : {0.25, 0.5, 1.0}) {
    Bench bench;
    bench.load("O1\nG90 G94 G21\nG00 X900.\nM30\n");
    bench.press(Action::set_rapid_override, ratio);
    ASSERT_TRUE(bench.start());
    double fastest = 0;
    ASSERT_TRUE(bench.until(
        [&] {
          fastest = std::max(fastest, bench.controller.sample().velocity[0]);
          return bench.state() == State::idle;
        },
        60));
    EXPECT_NEAR(fastest, ratio * bench.controller.machine().axes[0].rapid_mm_min / 60, 0.2) << ratio;
  }
}

TEST(DryRun, EveryCuttingFeedIsTheDryRunFeed) {
  Bench bench;
  bench.controller.edit_data([](interp::MachineData& data) { data.parameters["1410"] = 2400; }, {}, "test");
  bench.load("O1\nG90 G94 G21\nG01 X40. F100.\nG95 F0.1 Y40.\nM30\n");
  ASSERT_TRUE(bench.press(Action::set_dry_run, 1).accepted);
  ASSERT_TRUE(bench.start());
  double fastest = 0;
  ASSERT_TRUE(bench.until(
      [&] {
        fastest = std::max(fastest, bench.controller.sample().path_speed_mm_s);
        return bench.state() == State::idle;
      },
      60));
  EXPECT_NEAR(fastest, 40, 0.1);
}

TEST(MacroControl, FeedHoldWaitsForTheEndOf3004) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\n#3004=1\nG01 X20. F1200.\n#3004=0\nG01 X40.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 5; }, 20));
  bench.press(Action::feed_hold);
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 19.5; }, 5)) << "not held";
  for (int i = 0; i < 1500; ++i) bench.period();
  EXPECT_LT(bench.controller.sample().position[0], 40);
  EXPECT_GE(bench.controller.sample().position[0], 19.9);
  EXPECT_FALSE(bench.controller.sample().moving);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 20));
}

TEST(MacroControl, OverrideIsOneHundredUnder3004) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\n#3004=2\nG01 X40. F1200.\n#3004=0\nM30\n");
  bench.press(Action::set_feed_override, 0.5);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 20; }, 20));
  EXPECT_NEAR(bench.controller.sample().path_speed_mm_s, 20, 0.01);
}

TEST(MacroControl, SingleBlockIsSuppressedBy3003) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\n#3003=1\nG01 X5. F1200.\nX10.\nX15.\n#3003=0\nX20.\nX25.\nM30\n");
  bench.press(Action::set_single_block, 1);
  ASSERT_TRUE(bench.start());
  int stops = 0;
  double first_stop = 0;
  while (bench.until([&] { return bench.state() != State::running; }, 30) &&
         bench.state() == State::stopped) {
    if (bench.controller.sample().position[0] > 0 && first_stop == 0)
      first_stop = bench.controller.sample().position[0];
    if (++stops > 20 || !bench.start()) break;
  }
  EXPECT_EQ(bench.state(), State::idle);
  EXPECT_GE(first_stop, 15) << "not between the blocks that must stay together";
}

double positioning_s(bool linear) {
  Bench bench("fanuc-0i-m");
  bench.controller.edit_data([&](interp::MachineData& data) { data.parameters["1401#1"] = linear; }, {},
                             "test");
  bench.load("O1\nG90 G94 G21\nG00 X90. Y20. Z-10.\nM30\n");
  EXPECT_TRUE(bench.start());
  LimitsOnBench limits(bench);
  double straight = 0;
  EXPECT_TRUE(limits.until(
      [&] {
        const AxisVector& at = bench.controller.sample().position;
        straight = std::max(straight, std::abs(at[1] - at[0] * 20 / 90));
        const AxisVector& left = bench.controller.sample().distance_to_go;
        if (bench.controller.sample().moving) {
          EXPECT_NEAR(at[0] + left[0], 90, 1e-6) << "of the block";
        }
        return bench.state() == State::idle;
      },
      60));
  limits.expect_inside();
  EXPECT_EQ(bench.controller.sample().position[0], 90);
  EXPECT_EQ(bench.controller.sample().position[1], 20);
  EXPECT_EQ(bench.controller.sample().position[2], -10);
  if (linear) {
    EXPECT_LT(straight, 1e-6);
  } else {
    EXPECT_GT(straight, 3) << "every axis at its own rate";
  }
  return static_cast<double>(bench.periods) * 1e-3;
}

TEST(Positioning, NotInterpolatedEveryAxisGoesAtItsOwnRate) {
  const double apart = positioning_s(false), together = positioning_s(true);
  EXPECT_LT(apart, together * 1.15);
}

}  // namespace
}  // namespace headstock::operation

// Forbidden zones hold for what is commanded, not only for what is programmed: rounded corners, axes that lag
// behind a filter, several axes moved by hand at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

using Numbers = std::map<std::string, double>;

/// Stored stroke check 3 in X and Y.
struct Box {
  double x_least, x_most, y_least, y_most;

  Numbers parameters() const {
    return {{"1324/X", x_most}, {"1325/X", x_least}, {"1324/Y", y_most}, {"1325/Y", y_least}};
  }
  /// How far inside; negative: outside.
  double depth(const AxisVector& at) const {
    return std::min({at[0] - x_least, x_most - at[0], at[1] - y_least, y_most - at[1]});
  }
};

constexpr double kDeepest_mm = 0.0011;  // of a zone whose border is programmed along: one least increment

const Numbers kNothing{}, kLinear{{"1622/X", 100}, {"1622/Y", 100}, {"1610#0/X", 1}, {"1610#0/Y", 1}},
    kBell{{"1622/X", 120}, {"1622/Y", 120}, {"1610#1/X", 1},
          {"1610#1/Y", 1}, {"1610#0/X", 1}, {"1610#0/Y", 1}},
    kExponential{{"1622/X", 60}, {"1622/Y", 60}},
    kUnequal{{"1622/X", 200}, {"1622/Y", 20}, {"1610#0/X", 1}, {"1610#0/Y", 1}},
    kLegs{{"1401#1", 0}, {"1620/X", 200}, {"1620/Y", 200}};

void set(Bench& bench, const Numbers& values) {
  ASSERT_TRUE(bench.controller
                  .edit_data(
                      [&](interp::MachineData& data) {
                        for (const auto& [number, value] : values) data.parameters[number] = value;
                      },
                      {}, "test")
                  .accepted);
}

struct Result {
  double deepest = -1e9, seconds = 0;
  State state = State::idle;
};

Result run(Bench& bench, const Box& box) {
  Result result;
  LimitsOnBench limits(bench);
  EXPECT_TRUE(bench.start());
  EXPECT_TRUE(limits.until(
      [&] {
        result.deepest = std::max(result.deepest, box.depth(bench.controller.sample().position));
        return bench.state() != State::running && bench.periods > 10;
      },
      120));
  limits.expect_inside();
  result.state = bench.state();
  result.seconds = static_cast<double>(bench.periods) * bench.controller.machine().period_us * 1e-6;
  return result;
}

Result run(const std::string& program, const Numbers& parameters, const Box& box) {
  Bench bench("fanuc-0i-m");
  set(bench, parameters);
  set(bench, box.parameters());
  bench.load("O1\nG90 G94 G21 G17\n" + program + "M30\n");
  return run(bench, box);
}

TEST(ZoneClearance, CornersAroundAZoneAreNotCut) {
  const Box box{20, 40, 10, 30};
  for (const Numbers& parameters : {kNothing, kLinear, kBell, kExponential, kUnequal}) {
    // Along the lower border to its corner, up along the left one; at a distance that the filter makes
    // nothing of.
    const Result along = run("G01 X45. Y0 F3000.\nY10.\nX20.\nY30.\nX0\n", parameters, box);
    EXPECT_EQ(along.state, State::idle);
    EXPECT_LE(along.deepest, 1e-9);
    const Result beside = run("G01 X45. Y0 F3000.\nY9.99\nX19.99\nY30.\nX0\n", parameters, box);
    EXPECT_EQ(beside.state, State::idle);
    EXPECT_LE(beside.deepest, 0);
  }
}

TEST(ZoneClearance, ArcsAroundAZoneDoNotBecomeSmaller) {
  const Box box{15, 25, -5, 5};
  const double radius = std::sqrt(50.0) + 0.05;
  const std::string x = std::to_string(20 + radius), i = std::to_string(radius);
  const std::string program =
      "G00 X" + x + " Y20.\nG01 Y0 F3000.\nG03 X" + x + " Y0 I-" + i + " J0\nG01 Y20.\n";
  for (const Numbers& parameters : {kNothing, kLinear, kBell, kExponential}) {
    const Result result = run(program, parameters, box);
    EXPECT_EQ(result.state, State::idle);
    EXPECT_LE(result.deepest, kDeepest_mm);
  }
}

TEST(ZoneClearance, ALineBesideAZoneStaysStraightWhenItsAxesLagDifferently) {
  const Box box{-10, 19, 19.2, 60};
  const Result result = run("G01 X40. Y40. F3000.\n", kUnequal, box);
  EXPECT_EQ(result.state, State::idle);
  EXPECT_LE(result.deepest, 0);
}

TEST(ZoneClearance, PositioningPastAZoneKeepsItsOwnPath) {
  // X and Y by themselves: at 2,000 mm/s² Y is at 19.85 behind 0.188 s, X then at 35.0; nothing of the bend is cut off.
  const Box beside{35.2, 60, -5, 19.85};
  const Result result = run("G00 X60. Y20.\n", kLegs, beside);
  EXPECT_EQ(result.state, State::idle);
  EXPECT_LE(result.deepest, 0);
  EXPECT_GT(result.deepest, -0.2);
  const Box far{35.2, 60, -5, 10};
  // Without the filter near the zone, with it before and behind: two stops, not one a corner of the bend.
  EXPECT_LT(result.seconds, 1.7 * run("G00 X60. Y20.\n", kLegs, far).seconds);
  // Where both went at the same speed until Y is there, this would be outside.
  const Box inside{21, 60, -5, 19.5};
  EXPECT_EQ(run("G00 X60. Y20.\n", kLegs, inside).state, State::alarm);
}

TEST(ZoneClearance, APermittedBoxIsNotLeft) {
  Bench bench("fanuc-0i-m");
  set(bench, kExponential);
  set(bench, {{"1300#0", 1}});  // outside of check 2 is forbidden
  const Box box{-1, 30, -1, 30};
  bench.load(
      "O1\nG90 G94 G21 G17\nG22 X30. Y30. Z20. I-1. J-1. K-20.\nG01 X30. F3000.\nY30.\nG03 X20. Y20. "
      "J-10.\nM30\n");
  LimitsOnBench limits(bench);
  ASSERT_TRUE(bench.start());
  double least = 1e9;
  ASSERT_TRUE(limits.until(
      [&] {
        least = std::min(least, box.depth(bench.controller.sample().position));
        return bench.state() != State::running && bench.periods > 10;
      },
      60));
  EXPECT_GE(least, -1e-9);
}

TEST(ZoneClearance, FarAwayTheFilterIsThere) {
  const std::string program = "G01 X20. Y0 F3000.\nY20.\n";
  const Box far{400, 500, 400, 500}, near{20.001, 40, -10, -0.001};
  for (const auto& [box, cuts] : {std::pair{far, true}, std::pair{near, false}}) {
    Bench bench("fanuc-0i-m");
    set(bench, kLinear);
    set(bench, box.parameters());
    bench.load("O1\nG90 G94 G21 G17\n" + program + "M30\n");
    ASSERT_TRUE(bench.start());
    double nearest = 1e9;
    ASSERT_TRUE(bench.until(
        [&] {
          const AxisVector& at = bench.controller.sample().position;
          nearest = std::min(nearest, std::hypot(at[0] - 20, at[1]));
          return bench.state() == State::idle && bench.periods > 10;
        },
        60));
    if (cuts)
      EXPECT_GT(nearest, 0.02);
    else
      EXPECT_LT(nearest, 1e-9);
  }
}

TEST(ZoneClearance, AMoveWhoseFollowerComesLaterStopsAtItsEnd) {
  for (const Numbers& parameters : {kNothing, kLinear}) {
    const Box box{20, 40, 10, 30};
    Bench bench("fanuc-0i-m");
    set(bench, parameters);
    set(bench, box.parameters());
    auto feeder = std::make_shared<Feeder>();
    // Enough moves for the axes to be on their way, then one that is far from the zone but for its end.
    feeder->text = "%\nO1\nG90 G94 G21 G17\nG01 F3000.\n";
    for (int i = 1; i <= 60; ++i) feeder->text += "X" + std::to_string(0.5 * i) + "\n";
    feeder->text += "X19.999 Y9.999\nY35.\nX0\nM30\n%\n";
    ASSERT_TRUE(bench.controller
                    .select_stream("drip.nc", "h", std::make_unique<FedSource>(feeder), feeder->text.size())
                    .accepted);
    feeder->released = feeder->text.find("Y35.");
    ASSERT_TRUE(bench.start());
    double deepest = -1e9;
    const auto watch = [&] {
      deepest = std::max(deepest, box.depth(bench.controller.sample().position));
      return bench.controller.sample().position[0] > 3;
    };
    ASSERT_TRUE(bench.until(watch, 20));
    feeder->released = feeder->text.size();
    feeder->closed = true;
    ASSERT_TRUE(bench.until(
        [&] {
          watch();
          return bench.state() != State::running;
        },
        60));
    EXPECT_EQ(bench.state(), State::idle);
    EXPECT_LE(deepest, 0);
  }
}

TEST(ZoneClearance, AChainOfThreadsBesideAZoneIsNotBroken) {
  Bench bench("fanuc-0i-t");
  const AxisVector home = bench.controller.sample().position;
  const double x = home[0], z = home[1];
  // A box below the slide, along the second thread only; the pages show X as a diameter.
  set(bench, {{"1627/X", 60}, {"1627/Z", 60}});
  set(bench, {{"1324/X", 2 * (x - 0.005)}, {"1325/X", 2 * (x - 20)}, {"1324/Z", z - 22}, {"1325/Z", z - 60}});
  bench.load("O1\nG97 S500 M03\nG32 W-20. F2.\nW-20. F2.\nG00 U10.\nM30\n");
  ASSERT_TRUE(bench.start());
  int threads = 0;
  bool threading = false;
  ASSERT_TRUE(bench.until(
      [&] {
        const bool now = bench.controller.sample().threading;
        if (now && !threading) ++threads;
        threading = now;
        return bench.state() != State::running && bench.periods > 10;
      },
      60));
  EXPECT_EQ(bench.state(), State::idle);
  EXPECT_EQ(threads, 1) << "one chain, one start";
  EXPECT_NEAR(bench.controller.sample().position[1], z - 40, 1e-9);
}

TEST(ZoneClearance, TwoAxesByHandDoNotMeetInAZone) {
  const Box box{20, 40, 20, 40};
  for (const auto& [first, second] : {std::pair<std::size_t, std::size_t>{0, 1}, {1, 0}}) {
    Bench bench("fanuc-0i-m");
    set(bench, box.parameters());
    ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(Mode::jog)).accepted);
    // Each of them alone passes beside the box.
    ASSERT_TRUE(bench.controller.jog(first, 1, Controller::JogSpeed::rapid).accepted);
    for (int i = 0; i < 5; ++i) bench.period();
    ASSERT_TRUE(bench.controller.jog(second, 1, Controller::JogSpeed::rapid).accepted);
    double deepest = -1e9;
    for (int i = 0; i < 8000; ++i) {
      bench.period();
      deepest = std::max(deepest, box.depth(bench.controller.sample().position));
    }
    EXPECT_LT(deepest, 0);
    EXPECT_GT(bench.controller.sample().position[first], 45) << "the first goes where it was sent";
    EXPECT_LT(bench.controller.sample().position[second], 20) << "the second waits before the box";
  }
}

TEST(ZoneClearance, ReferenceReturnDoesNotGoThroughAZone) {
  Bench bench("fanuc-0i-m");
  const double home = bench.controller.machine().axes[0].reference_mm;
  bench.load("O1\nG90 G94 G21\nG00 X-60.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  set(bench, {{"1324/X", home - 20}, {"1325/X", home - 30}});
  ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(Mode::reference)).accepted);
  EXPECT_EQ(bench.controller.reference_return(0).reason, "travel_limit");
  set(bench, {{"1324/X", home - 220}, {"1325/X", home - 230}});
  EXPECT_TRUE(bench.controller.reference_return(0).accepted);
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] == home; }, 60));
}

TEST(ZoneClearance, TheWayBackFromAHandIsLookedAt) {
  for (const bool around : {false, true}) {
    Bench bench;
    const Box box{-5, 10, 5, 10};
    set(bench, box.parameters());
    bench.load("O1\nG90 G94 G21\nG01 X40. F2000.\nX40. Y1.\nM30\n");
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 15; }, 20));
    bench.press(Action::feed_hold);
    ASSERT_TRUE(bench.until([&] { return !bench.controller.sample().moving; }, 5));
    ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(Mode::jog)).accepted);
    // Up beside the box, then left above it: both axes at once back would lead through it.
    ASSERT_TRUE(bench.controller.step_axis(1, 15).accepted);
    ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[1] == 15; }, 60));
    for (int i = 0; i < 100; ++i) bench.period();
    const double back = bench.controller.sample().position[0];
    ASSERT_TRUE(bench.controller.step_axis(0, -back).accepted);
    ASSERT_TRUE(bench.until([&] { return std::abs(bench.controller.sample().position[0]) < 1e-9; }, 60));
    for (int i = 0; i < 100; ++i) bench.period();
    if (around) {
      ASSERT_TRUE(bench.controller.step_axis(0, back).accepted);
      ASSERT_TRUE(
          bench.until([&] { return std::abs(bench.controller.sample().position[0] - back) < 1e-9; }, 60));
      for (int i = 0; i < 100; ++i) bench.period();
    }
    ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(Mode::memory)).accepted);
    const CommandResult resumed = bench.press(Action::cycle_start);
    EXPECT_EQ(resumed.accepted, around) << resumed.reason;
    if (around) {
      EXPECT_TRUE(bench.until_state(State::idle, 60));
    } else {
      EXPECT_EQ(resumed.reason, "travel_limit");
    }
  }
}

}  // namespace
}  // namespace headstock::operation

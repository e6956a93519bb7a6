// Accelerations by the controllers' parameters: which one holds for which motion, and that it is kept.
#include "operation/acceleration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

using Parameters = std::map<std::string, double, std::less<>>;

struct Greatest {
  double up = 0, down = 0;  ///< along the path [mm/s²]
  double jerk = 0;          ///< the same [mm/s³]
};

/// Every axis: 6,000 mm/min = 100 mm/s, rapid 12,000 mm/min = 200 mm/s, 2,000 mm/s², jerk not limited.
/// @param counts when a period is looked at
Greatest greatest_of(const std::string& profile, const Parameters& parameters, const std::string& program,
                     const std::function<bool(const Controller&)>& counts = {}) {
  machine::Machine machine = *machine::default_machine(profile);
  for (machine::Axis& axis : machine.axes) {
    axis.max_feed_mm_min = 6'000;
    axis.rapid_mm_min = 12'000;
    axis.max_acceleration_mm_s2 = 2'000;
    axis.max_jerk_mm_s3 = 1e12;
    axis.min_mm = -1'000;
    axis.max_mm = 1'000;
  }
  interp::MachineData data;
  data.parameters = parameters;
  Controller controller(machine, data, virtual_options());
  controller.select("main", "hash", single_program([program] { return program::source_from_text(program); }));
  Greatest greatest;
  double before = 0, acceleration_before = 0;
  VirtualRun virtual_run(controller);
  EXPECT_EQ(virtual_run.run([&] {
    const double speed = controller.sample().path_speed_mm_s;
    if (counts && !counts(controller)) {
      before = speed;
      return true;
    }
    greatest.up = std::max(greatest.up, (speed - before) / 0.001);
    greatest.down = std::max(greatest.down, (before - speed) / 0.001);
    const double acceleration = (speed - before) / 0.001;
    greatest.jerk = std::max(greatest.jerk, std::abs(acceleration - acceleration_before) / 0.001);
    acceleration_before = acceleration;
    before = speed;
    return true;
  }),
            RunEnd::completed)
      << virtual_run.reason;
  return greatest;
}

struct AccelerationCase {
  const char* what;
  const char* profile;
  Parameters parameters;
  const char* program;
  double up, down;
};

const char* const kMillRapid = "O1\nG90 G94 G21\nG00 X80.\nM30\n";
const char* const kMillCut = "O1\nG90 G94 G21\nG01 X60. F3000.\nM30\n";
const char* const kMillAhead = "O1\nG90 G94 G21\nG05.1 Q1\nG01 X60. F3000.\nG05.1 Q0\nM30\n";
const char* const kLatheRapid = "O1\nG98 G21\nG00 W-80.\nM30\n";
const char* const k200Cut = "N10 G01 W-60 F3000\nN20 M02\n";
const char* const kLatheCut = "O1\nG98 G21\nG01 W-60. F3000.\nM30\n";

const AccelerationCase kAccelerationCases[] = {
    {"nothing set", "fanuc-0i-m", {}, kMillRapid, 2000, 2000},
    {"rapid, linear", "fanuc-0i-m", {{"1620/X", 200}}, kMillRapid, 1000, 1000},
    {"another axis' time", "fanuc-0i-m", {{"1620/Y", 200}}, kMillRapid, 2000, 2000},
    {"rapid before interpolation",
     "fanuc-0i-m",
     {{"19501#5", 1}, {"1401#1", 1}, {"1620/X", 200}, {"1671/X", 700}},
     kMillRapid,
     700,
     700},
    {"cutting, linear after interpolation: to the feed",
     "fanuc-0i-m",
     {{"1622/X", 100}, {"1610#0/X", 1}, {"1620/X", 10'000}},
     kMillCut,
     500,
     500},
    // The kernel's own ramp of 50 mm/s at 2000 mm/s² goes into the lag: 2000 (1 - e^(-25/100)).
    {"cutting, exponential after interpolation",
     "fanuc-0i-m",
     {{"1622/X", 100}, {"1620/X", 10'000}},
     kMillCut,
     442.4,
     442.4},
    // 50 ms twice over a ramp of 25 ms: the tip of the triangle, 2000 × 25/50 × (1 - 6.25/50).
    {"cutting, bell after interpolation",
     "fanuc-0i-m",
     {{"1622/X", 100}, {"1610#1/X", 1}, {"1610#0/X", 1}},
     kMillCut,
     875,
     875},
    {"look-ahead: before and linear after",
     "fanuc-0i-m",
     {{"1622/X", 10'000}, {"1660/X", 900}, {"1769/X", 100}, {"1602#6", 1}},
     kMillAhead,
     500,
     500},
    {"look-ahead: bell before", "fanuc-0i-m", {{"1660/X", 900}, {"1772", 40}}, kMillAhead, 900, 900},
    {"rapid, bell before",
     "fanuc-0i-m",
     {{"19501#5", 1}, {"1401#1", 1}, {"1671/X", 700}, {"1672", 100}},
     kMillRapid,
     700,
     700},
    {"rapid, bell: T1 and T2", "fanuc-0i-m", {{"1620/X", 200}, {"1621/X", 100}}, kMillRapid, 1000, 1000},
    {"look-ahead, before interpolation",
     "fanuc-0i-m",
     {{"1622/X", 10'000}, {"1660/X", 900}},
     kMillAhead,
     900,
     900},
    {"never above the machine's", "fanuc-0i-m", {{"1660/X", 90'000}}, kMillAhead, 2000, 2000},
    // All of an S is curved: twice the mean acceleration in its middle.
    {"2000TC rapid, S before", "gsk-2000tc", {{"P308", 400}}, kLatheRapid, 1000, 1000},
    {"2000TC cutting, S before",
     "gsk-2000tc",
     {{"S168.2", 1}, {"S168.3", 0}, {"P314", 200}},
     kLatheCut,
     500,
     500},
    {"2000TC cutting, linear after", "gsk-2000tc", {{"S168.2", 0}, {"P315", 100}}, kLatheCut, 500, 500},
    {"2000TC rapid, linear before",
     "gsk-2000tc",
     {{"S168.0", 0}, {"P306", 250}, {"P308", 400}},
     kLatheRapid,
     800,
     800},
    {"2000TC cutting, exponential after", "gsk-2000tc", {{"P316", 100}}, kLatheCut, 442.4, 442.4},
    {"2000TC cutting, linear before",
     "gsk-2000tc",
     {{"S168.2", 0}, {"S168.3", 0}, {"P313", 100}},
     kLatheCut,
     1000,
     1000},
    {"218T rapid, linear", "gsk-218t", {{"P024", 400}}, kLatheRapid, 500, 500},
    {"218T cutting, S: up and down",
     "gsk-218t",
     {{"P009.4", 1}, {"P029", 200}, {"P030", 400}},
     kLatheCut,
     500,
     333},
    {"218T cutting, linear after", "gsk-218t", {{"P009.6", 1}, {"P031", 100}}, kLatheCut, 500, 500},
    {"K2000TC rapid, straight",
     "k2000tc",
     {{"P0004.1", 1}, {"P6432", 60}, {"P6433", 30}},
     kLatheRapid,
     1000,
     500},
    {"K2000TC cutting", "k2000tc", {{"P6430", 30}, {"P6431", 60}}, kLatheCut, 500, 1000},
    {"200T", "lathe-200t", {{"AX2.2", 200}}, k200Cut, 500, 500},
};

class Acceleration : public testing::TestWithParam<AccelerationCase> {};

TEST_P(Acceleration, IsThatOfTheParameter) {
  const AccelerationCase& one = GetParam();
  const Greatest greatest = greatest_of(one.profile, one.parameters, one.program);
  EXPECT_NEAR(greatest.up, one.up, 0.03 * one.up) << one.what;
  EXPECT_NEAR(greatest.down, one.down, 0.03 * one.down) << one.what;
}

INSTANTIATE_TEST_SUITE_P(Controllers, Acceleration, testing::ValuesIn(kAccelerationCases));

TEST(AccelerationShapes, ABellIsAsLongAsItsParameter) {
  const Greatest greatest = greatest_of("fanuc-0i-m", {{"1660/X", 900}, {"1772", 60}}, kMillAhead);
  EXPECT_NEAR(greatest.jerk, 900 / 0.06, 0.03 * 900 / 0.06);
  const Greatest s = greatest_of("gsk-2000tc", {{"P308", 200}}, kLatheRapid);
  EXPECT_NEAR(s.jerk, 2000 / 0.1, 0.03 * 2000 / 0.1);
}

void set_parameters(Bench& bench, const Parameters& values) {
  ASSERT_TRUE(bench.controller
                  .edit_data(
                      [&](interp::MachineData& data) {
                        for (const auto& [number, value] : values) data.parameters[number] = value;
                      },
                      {}, "test")
                  .accepted);
}

double nearest_to_corner(const Parameters& parameters, const char* stop) {
  Bench bench("fanuc-0i-m");
  set_parameters(bench, parameters);
  bench.load(std::string("O1\nG90 G94 G21\n") + stop + "G01 X20. F3000.\nY20.\nM30\n");
  EXPECT_TRUE(bench.start());
  LimitsOnBench limits(bench);
  double nearest = 1e9;
  EXPECT_TRUE(limits.until(
      [&] {
        const auto& at = bench.controller.sample().position;
        nearest = std::min(nearest, std::hypot(at[0] - 20, at[1]));
        return bench.state() != State::running && bench.periods > 10;
      },
      30));
  limits.expect_inside();
  EXPECT_EQ(bench.state(), State::idle);
  EXPECT_EQ(bench.controller.sample().position[0], 20);
  EXPECT_EQ(bench.controller.sample().position[1], 20);
  return nearest;
}

TEST(AccelerationShapes, AfterInterpolationCutsCornersUnlessTheyAreExactStops) {
  const Parameters after{{"1622/X", 100}, {"1622/Y", 100}, {"1610#0/X", 1}, {"1610#0/Y", 1}};
  EXPECT_LT(nearest_to_corner({}, ""), 0.0101) << "inside the tolerance of the machine";
  EXPECT_GT(nearest_to_corner(after, ""), 0.02) << "by its lag";
  EXPECT_EQ(nearest_to_corner(after, "G61\n"), 0) << "exact stop";
  EXPECT_EQ(nearest_to_corner({{"1622/X", 60}, {"1622/Y", 60}}, "G61\n"), 0) << "exponential too";
}

TEST(AccelerationShapes, HoldResumeSingleBlockAndResetBehindAFilter) {
  for (const bool bell : {false, true}) {
    Bench bench("fanuc-0i-m");
    set_parameters(
        bench,
        {{"1622/X", 80}, {"1622/Y", 80}, {"1610#1/X", bell ? 1.0 : 0.0}, {"1610#1/Y", bell ? 1.0 : 0.0}});
    bench.load("O1\nG90 G94 G21 G17\nG01 X20. F3000.\nY20.\nG03 X0 I-10. J0\nG01 Y0\nM30\n");
    LimitsOnBench limits(bench);
    ASSERT_TRUE(bench.start());
    for (int round = 0; round < 12; ++round) {
      for (int i = 0; i < 60 + 17 * round; ++i) limits.period();
      if (bench.state() != State::running) break;
      bench.press(Action::feed_hold);
      ASSERT_TRUE(limits.until([&] { return !bench.controller.sample().moving; }, 5));
      const AxisVector stood = bench.controller.sample().position;
      for (int i = 0; i < 30; ++i) limits.period();
      EXPECT_EQ(bench.controller.sample().position, stood);
      bench.start();
    }
    ASSERT_TRUE(limits.until([&] { return bench.state() == State::idle; }, 30));
    EXPECT_EQ(bench.controller.sample().position[0], 0);
    EXPECT_EQ(bench.controller.sample().position[1], 0);
    // Single block stands at each block's own end, whatever the axes lag.
    bench.press(Action::set_single_block, 1);
    int stops = 0;
    ASSERT_TRUE(bench.start());
    for (; stops < 20; ++stops) {
      ASSERT_TRUE(limits.until([&] { return bench.state() != State::running; }, 30));
      if (bench.state() == State::idle) break;
      EXPECT_FALSE(bench.controller.sample().moving);
      bench.start();
    }
    EXPECT_EQ(bench.state(), State::idle);
    EXPECT_GE(stops, 4);
    bench.press(Action::set_single_block, 0);
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(limits.until([&] { return bench.controller.sample().position[1] > 5; }, 30));
    ASSERT_TRUE(bench.press(Action::reset).accepted);
    ASSERT_TRUE(limits.until([&] { return bench.state() == State::idle; }, 5));
    const AxisVector stood = bench.controller.sample().position;
    for (int i = 0; i < 100; ++i) limits.period();
    EXPECT_EQ(bench.controller.sample().position, stood);
    limits.expect_inside();
  }
}

TEST(AccelerationShapes, WhatIsNotDoneIsSaidOnceNotPassedOver) {
  Bench bench("k2000tc");
  set_parameters(bench, {{"P6410", 3}, {"P6458", 4}, {"P6482", 2}});
  bench.load("O1\nG98\nG01 Z-5. F3000.\nM30\n");
  ASSERT_TRUE(bench.start());
  const auto messages = bench.controller.live().alarms;
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].code, "HS0031");
  EXPECT_TRUE(messages[0].message);
  EXPECT_NE(messages[0].text_en.find("P6410"), std::string::npos) << messages[0].text_en;
  EXPECT_NE(messages[0].text_en.find("P6458"), std::string::npos) << messages[0].text_en;
  EXPECT_NE(messages[0].text_en.find("P6482"), std::string::npos) << messages[0].text_en;
  ASSERT_TRUE(bench.until_state(State::idle, 20)) << "it stops nothing";
  ASSERT_TRUE(bench.start());
  EXPECT_TRUE(bench.controller.live().alarms.empty()) << "said once";
  ASSERT_TRUE(bench.until_state(State::idle, 20));
}

/// Highest acceleration of a jog of one axis [mm/s²].
double jog_acceleration(const std::string& profile, std::size_t axis, const Parameters& parameters) {
  machine::Machine machine = *machine::default_machine(profile);
  for (machine::Axis& each : machine.axes) {
    each.max_feed_mm_min = 6'000;
    each.max_acceleration_mm_s2 = 2'000;
    each.max_jerk_mm_s3 = 1e6;
  }
  Bench bench(machine);
  set_parameters(bench, parameters);
  bench.press(Action::set_mode, static_cast<double>(Mode::jog));
  LimitsOnBench limits(bench);
  EXPECT_TRUE(bench.controller.jog(axis, 1).accepted);
  for (int i = 0; i < 800; ++i) limits.period();
  bench.controller.jog(axis, 0);
  for (int i = 0; i < 800; ++i) limits.period();
  EXPECT_FALSE(bench.controller.sample().moving);
  limits.expect_inside();
  return limits.check().max_acceleration()[axis];
}

TEST(AccelerationOfHands, IsThatOfTheParameter) {
  const Parameters fast{{"1423", 3000}};  // 50 mm/s
  EXPECT_NEAR(jog_acceleration("fanuc-0i-m", 0, fast), 2000, 60) << "nothing set";
  EXPECT_NEAR(jog_acceleration("fanuc-0i-m", 0, {{"1423", 3000}, {"1624/X", 100}}), 500, 15);
  EXPECT_NEAR(jog_acceleration("fanuc-0i-m", 1, {{"1423", 3000}, {"1624/X", 100}}), 2000, 60)
      << "another axis";
  EXPECT_NEAR(jog_acceleration("lathe-200t", 1, {{"1423", 3000}, {"AX2.2", 200}}), 500, 15);
  EXPECT_NEAR(jog_acceleration("gsk-2000tc", 1, {{"1423", 3000}, {"P317", 200}}), 250, 8);
}

TEST(AccelerationOfThreads, CountsForTheRunIn) {
  const std::string thread = "O1\nG97 S500 M03\nG32 W-30. F2.\nM30\n";
  for (const bool slow : {false, true}) {
    Bench bench("fanuc-0i-t");
    ASSERT_TRUE(
        bench.controller
            .edit_data([&](interp::MachineData& data) { data.parameters["1626/Z"] = slow ? 4'000 : 100; }, {},
                       "test")
            .accepted);
    bench.load(thread);
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until([&] { return bench.periods > 10 && bench.state() != State::running; }, 60));
    EXPECT_EQ(bench.state(), slow ? State::alarm : State::idle);
    if (slow) {
      EXPECT_EQ(bench.controller.live().alarms[0].code, "HS0004");
    }
  }
}

// K2000TC L12834: the way out of a thread speeds up by P6483, G92's and G76's by J/K of it.
TEST(AccelerationOfThreads, TheWayOutGoesByJAndK) {
  struct WayOut {
    const char* words;
    double p6483, expected;
  };
  constexpr WayOut kWays[] = {{"", 60, 1000},         {" J1. K2.", 60, 500},
                              {" J2. K1.", 30, 1000}, {" J4. K1.", 60, 2000},  // never above the machine's
                              {" J1. K4.", 0, 500},                            // of the machine's own
                              {"", 0, 2000}};
  for (const WayOut& one : kWays) {
    SCOPED_TRACE(std::string(one.words) + " P6483=" + std::to_string(one.p6483));
    const std::string program =
        "O1\nG98 G21 G97 S500 M03\nG92 U-40. W-30. F2." + std::string(one.words) + "\nM30\n";
    double x = 0;
    const Greatest out = greatest_of("k2000tc", {{"P0042", 3}, {"P6483", one.p6483}}, program,
                                     [&](const Controller& controller) {
                                       const double now = controller.sample().position[0];
                                       const bool outward = now > x + 1e-9;
                                       x = now;
                                       return outward;
                                     });
    EXPECT_NEAR(out.up, one.expected, 0.03 * one.expected);
    EXPECT_NEAR(out.down, one.expected, 0.03 * one.expected);
  }
}

}  // namespace
}  // namespace headstock::operation

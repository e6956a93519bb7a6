// Accelerations by the controllers' parameters: which one holds for which motion, and that it is kept.
#include "operation/acceleration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "bench.hpp"

namespace headstock::operation {
namespace {

using Parameters = std::map<std::string, double, std::less<>>;

struct Greatest {
  double up = 0, down = 0;  ///< along the path [mm/s²]
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
  double before = 0;
  VirtualRun virtual_run(controller);
  EXPECT_EQ(virtual_run.run([&] {
    const double speed = controller.sample().path_speed_mm_s;
    if (counts && !counts(controller)) {
      before = speed;
      return true;
    }
    greatest.up = std::max(greatest.up, (speed - before) / 0.001);
    greatest.down = std::max(greatest.down, (before - speed) / 0.001);
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
    {"cutting, after interpolation: to the feed",
     "fanuc-0i-m",
     {{"1622/X", 100}, {"1620/X", 10'000}},
     kMillCut,
     500,
     500},
    {"look-ahead, before interpolation",
     "fanuc-0i-m",
     {{"1622/X", 10'000}, {"1660/X", 900}},
     kMillAhead,
     900,
     900},
    {"never above the machine's", "fanuc-0i-m", {{"1660/X", 90'000}}, kMillAhead, 2000, 2000},
    {"2000TC rapid, S before", "gsk-2000tc", {{"P308", 400}}, kLatheRapid, 500, 500},
    {"2000TC rapid, linear before",
     "gsk-2000tc",
     {{"S168.0", 0}, {"P306", 250}, {"P308", 400}},
     kLatheRapid,
     800,
     800},
    {"2000TC cutting, exponential after", "gsk-2000tc", {{"P316", 100}}, kLatheCut, 500, 500},
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
     250},
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

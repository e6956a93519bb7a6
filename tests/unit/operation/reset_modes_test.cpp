// What RESET leaves of the modes: those of blocks that have been carried out, not those that were read ahead
// (0i-D K.32.1).
#include <gtest/gtest.h>

#include <algorithm>

#include "interpreter/data_values.hpp"
#include "tests/unit/operation/bench.hpp"

namespace headstock::operation {
namespace {

bool in_force(Bench& bench, std::string_view code) {
  const auto modal = bench.controller.live().modal;
  return std::find(modal.begin(), modal.end(), code) != modal.end();
}

TEST(ResetModes, WhatWasOnlyReadIsNotInForce) {
  Bench bench;
  bench.load("O1\nG90 G94 G21 G54 G17\nG01 X100. F600.\nX150.\nG91 G18\nG55\nX1.\nG20\nX1.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 5; }));
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle));
  for (const char* code : {"G90", "G54", "G17", "G21"}) EXPECT_TRUE(in_force(bench, code)) << code;
  const double mode = static_cast<double>(Mode::mdi);
  ASSERT_TRUE(bench.press(Action::set_mode, mode).accepted);
  ASSERT_TRUE(bench.controller.enter_mdi("X10.\n").accepted);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.state() != State::running; }));
  EXPECT_NEAR(bench.controller.sample().position[0], 10, 1e-9) << "absolute, in millimetres";
}

TEST(ResetModes, WhatIsDoneBeforeAStopStays) {
  Bench bench;
  bench.load("O1\nG90 G94 G21 G54\nG01 X5. F6000.\nG55 T2\nM00\nG54 G91\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.state() != State::running; }));
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_TRUE(in_force(bench, "G55"));
  EXPECT_TRUE(in_force(bench, "G90"));
  EXPECT_EQ(bench.controller.live().tool, 2);
}

// d2 E6, L80598: RESET before N2 has positioned: tool and offset are those of N1.
TEST(ResetModes, TheToolOfABrokenBlockIsThatBefore) {
  Bench bench("fanuc-0i-t");
  bench.load("N1 G00 X120. Z0. T0101\n\nN2 G00 X180. Z20. T0202\n\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until(
      [&] { return bench.controller.live().at.sequence == 2 && bench.controller.sample().moving; }));
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_EQ(bench.controller.live().tool, 1);
  EXPECT_EQ(bench.controller.live().offset, 1);
}

// The block that an alarm ended was not carried out: nothing of it stays. Whole blocks before it do (0i-D
// K.32.1; the others say nothing else).
struct Refused {
  const char* profile;
  const char* modes;       // a block that moves nothing
  const char* refused;     // the block behind it
  const char* stays;       // of `modes`
  const char* before;      // what `refused` would have replaced …
  const char* never_came;  // … and by what
};

class ResetAfterAlarm : public testing::TestWithParam<Refused> {};

TEST_P(ResetAfterAlarm, LeavesNothingOfTheBlockThatWasRefused) {
  const Refused& given = GetParam();
  Bench bench(given.profile);
  bench.load(std::string("G00 X5.\n") + given.modes + "\n" + given.refused + "\nM02\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm));
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_TRUE(in_force(bench, given.stays)) << "carried out before the alarm";
  EXPECT_TRUE(in_force(bench, given.before));
  EXPECT_FALSE(in_force(bench, given.never_came));
}

INSTANTIATE_TEST_SUITE_P(
    Profiles, ResetAfterAlarm,
    testing::Values(Refused{"fanuc-0i-m", "G91 F500.", "G55 G02 X10. I1. J1.", "G91", "G54", "G55"},
                    Refused{"fanuc-0i-t", "G98 F500.", "G55 G02 X90. Z30. R0.1", "G98", "G54", "G55"},
                    Refused{"gsk-2000tc", "G99 F0.5", "G55 G02 X90. Z30. R0.1", "G99", "G54", "G55"},
                    Refused{"gsk-218t", "G99 F0.5", "G96 S100 G02 X90. Z30. R0.1", "G99", "G97", "G96"},
                    Refused{"k2000tc", "G98 F500.", "G55 G02 X90. Z30. R0.1", "G98", "G54", "G55"},
                    Refused{"lathe-200t", "G99 F0.5", "G96 S100 G02 X90. Z30. R0.1", "G99", "G97", "G96"}),
    [](const testing::TestParamInfo<Refused>& given) {
      std::string name = given.param.profile;
      std::erase(name, '-');
      return name;
    });

void run_mdi(Bench& bench, const std::string& text) {
  ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(Mode::mdi)).accepted);
  ASSERT_TRUE(bench.controller.enter_mdi(text).accepted);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle));
}

void reset_in_motion(Bench& bench, double past_x) {
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > past_x; }));
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle));
}

// 200T: System = Reference + Offset + Comp. G60 that was only read must not leave its share in one of them.
TEST(ResetModes, ComponentsOfThe200TAreThoseOfTheLastBlock) {
  Bench bench("lathe-200t");
  bench.load("G98 G01 X40. F600\nG52 X500. Z700.\nG60 H01 X90. Z80.\nG01 X44.\nM02\n");
  reset_in_motion(bench, 5);
  run_mdi(bench, "G60 H02 X0 Z0\n");  // Offset becomes 0, which it was
  const Live live = bench.controller.live();
  EXPECT_NEAR(live.absolute[0], 2 * bench.controller.sample().position[0], 1e-9);
  EXPECT_NEAR(live.absolute[1], bench.controller.sample().position[1], 1e-9);
}

TEST(ResetModes, TheStartPointOfThe200TIsThatOfTheLastBlock) {
  Bench bench("lathe-200t");
  bench.load("G50 X10. Z20.\nG98 G01 X60. F600\nG50 X300. Z400.\nG01 X44.\nM02\n");
  reset_in_motion(bench, 5);
  run_mdi(bench, "G26\n");
  EXPECT_NEAR(bench.controller.sample().position[0], 0, 1e-9);
  EXPECT_NEAR(bench.controller.live().absolute[0], 10, 1e-9);
  EXPECT_NEAR(bench.controller.live().absolute[1], 20, 1e-9);
}

double value_of(Bench& bench, const std::string& what) {
  double value = -1;
  std::vector<char> axes;
  for (const machine::Axis& axis : bench.controller.machine().axes) axes.push_back(axis.name);
  EXPECT_TRUE(bench.controller
                  .edit_data(
                      [&](interp::MachineData& data) {
                        value = interp::read_value(data, axes, what).value.value_or(-1);
                      },
                      {}, "test")
                  .accepted);
  return value;
}

// G10 adds to the page: read twice, once before a RESET, it would add twice.
struct DataInput {
  const char* name;
  const char* profile;
  const char* program;  // RESET comes in the block in front of G10, on the way from X5 on
  const char* what;     // is 0, and 1 when the program has run
};

class ResetBeforeDataInput : public testing::TestWithParam<DataInput> {};

TEST_P(ResetBeforeDataInput, WritesWhenItsBlockRuns) {
  const DataInput& given = GetParam();
  Bench bench(given.profile);
  bench.load(given.program);
  reset_in_motion(bench, 5);
  EXPECT_EQ(value_of(bench, given.what), 0);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_NEAR(value_of(bench, given.what), 1, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(
    ResetModes, ResetBeforeDataInput,
    testing::Values(
        DataInput{"Lathe200T", "lathe-200t", "T0101\nG98 G01 X40. F600\nG10 P1 U1\nG01 X44.\nM02\n",
                  "tool/1/geometry/X"},
        DataInput{"K2000TC", "k2000tc", "T0101\nG98 G01 X40. F600.\nG10 P1 U1.\nG01 X44.\nM30\n",
                  "tool/1/geometry/X"},
        DataInput{"K2000TCShift", "k2000tc", "G98 G01 X40. F600.\nG10 P0 W1.\nG01 X44.\nM30\n",
                  "work/shift/Z"},
        DataInput{"Wear", "fanuc-0i-t", "O1\nT0101\nG98 G01 X40. F600.\nG10 P1 U1.\nG01 X44.\nM30\n",
                  "tool/1/wear/X"},
        DataInput{"Geometry", "fanuc-0i-t", "O1\nG98 G01 X40. F600.\nG10 P10002 W1.\nG01 X44.\nM30\n",
                  "tool/2/geometry/Z"},
        DataInput{"Radius", "fanuc-0i-m", "O1\nG90 G94 G01 X40. F600.\nG91 G10 L12 P1 R1.\nG90 X44.\nM30\n",
                  "tool/1/radius"},
        DataInput{"Zero", "fanuc-0i-m", "O1\nG90 G94 G01 X40. F600.\nG91 G10 L2 P2 X1.\nG90 X44.\nM30\n",
                  "work/G55/X"},
        DataInput{"Computed", "fanuc-0i-m",
                  "O1\n#1=1\nG90 G94 G01 X40. F600.\nG91 G10 L12 P1 R#1\nG90 X44.\nM30\n", "tool/1/radius"},
        // The motion in front of it waits for the one behind it: G10 is carried out first, and taken back.
        DataInput{
            "Compensated", "fanuc-0i-m",
            "O1\nG90 G94 G41 G01 X2. D1 F600.\nX40.\nG91 G10 L12 P2 R1.\nG90 X44.\nX50.\nG40 X60.\nM30\n",
            "tool/2/radius"},
        DataInput{"Chamfered", "fanuc-0i-m",
                  "O1\nG90 G94 G01 X40. ,C1. F600.\nG91 G10 L12 P2 R1.\nG90 Y44.\nM30\n", "tool/2/radius"}),
    [](const auto& given) { return std::string(given.param.name); });

// What was done before the block under way stays, though the tool is still compensated.
TEST(ResetModes, DataInputOfABlockThatIsDoneStays) {
  Bench bench("fanuc-0i-m");
  bench.load("O1\nG90 G94 G41 G01 X2. D1 F600.\nX4.\nG91 G10 L12 P2 R1.\nG90 X40.\nX50.\nG40 X60.\nM30\n");
  reset_in_motion(bench, 8);
  EXPECT_NEAR(value_of(bench, "tool/2/radius"), 1, 1e-9);
}

TEST(ResetModes, OfTwoDataInputsTheOneThatIsDoneStays) {
  Bench bench("fanuc-0i-m");
  bench.load(
      "O1\nG90 G94 G41 G01 X2. D1 F600.\nX4.\nG91 G10 L12 P2 R1.\nG90 X40.\nX42.\nG91 G10 L12 P2 R1.\n"
      "G90 X50.\nG40 X60.\nM30\n");
  reset_in_motion(bench, 8);  // the second was carried out before the two motions in front of it, held at X4
  EXPECT_NEAR(value_of(bench, "tool/2/radius"), 1, 1e-9);
}

// K2000TC #4112: the M code before.
TEST(ResetModes, TheLastMOfTheK2000TCIsThatOfTheLastBlock) {
  Bench bench("k2000tc");
  bench.load("M08\nG98 G01 X40. F600.\nM09\nX44.\nM30\n");
  reset_in_motion(bench, 5);
  run_mdi(bench, "#500=#4112\n");
  double last_m = 0;
  ASSERT_TRUE(
      bench.controller
          .edit_data([&](interp::MachineData& data) { last_m = data.common_variables[500]; }, {}, "test")
          .accepted);
  EXPECT_EQ(last_m, 8);
}

}  // namespace
}  // namespace headstock::operation

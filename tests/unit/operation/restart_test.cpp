// A program taken up in its middle: searched without motion, approached axis by axis, refused while the
// machine is not as the program needs it; and the block that a power loss leaves on the disk.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"
#include "interpreter/data_values.hpp"
#include "operation/data_edit.hpp"

namespace headstock::operation {
namespace {

constexpr const char* kPart =
    "O1\nG90 G94 G21 G54\nG00 X10. Y20. Z30.\nN10 G01 Z5. F600.\nN20 X40.\nN30 Y50.\nN40 Z30.\nM30\n";

interp::RestartPoint at_sequence(std::uint32_t number) {
  interp::RestartPoint point;
  point.sequence = number;
  return point;
}

TEST(Restart, NothingMovesBeforeCycleStartThenOneAxisAfterTheOther) {
  Bench bench;
  bench.load(kPart);
  ASSERT_TRUE(bench.controller.restart(at_sequence(30)).accepted);
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  const Live live = bench.controller.live();
  ASSERT_TRUE(live.restart.found);
  EXPECT_EQ(live.restart.position[0], 40);
  EXPECT_EQ(live.restart.position[1], 20);
  EXPECT_EQ(live.restart.position[2], 5);
  for (int i = 0; i < 200; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position, AxisVector{});

  ASSERT_TRUE(bench.start());
  bool together = false;
  double y_least = 1e9;
  ASSERT_TRUE(bench.until(
      [&] {
        const motion::Sample& now = bench.controller.sample();
        int moving = 0;
        for (std::size_t i = 0; i < 3; ++i) moving += std::abs(now.velocity[i]) > 1e-6 ? 1 : 0;
        together = together || moving > 1;
        if (now.position[2] > 0 && now.position[2] < 4.9) y_least = std::min(y_least, now.position[1]);
        return now.position[1] > 49;
      },
      200));
  EXPECT_FALSE(together);
  EXPECT_NEAR(y_least, 20, 1e-6) << "Z comes last";
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_EQ(bench.controller.sample().position[1], 50);
  EXPECT_EQ(bench.controller.sample().position[2], 30);
  bench.commit();
  EXPECT_EQ(bench.all<RunEnded>().back().outcome, "completed");
}

TEST(Restart, TheOrderOfTheAxesIsThatOfParameter7310) {
  Bench bench;
  bench.load(kPart);
  ASSERT_TRUE(bench.controller
                  .edit_data(
                      [](interp::MachineData& data) {
                        data.parameters["7310/X"] = 3;
                        data.parameters["7310/Y"] = 2;
                        data.parameters["7310/Z"] = 1;
                      },
                      {}, "test")
                  .accepted);
  ASSERT_TRUE(bench.controller.restart(at_sequence(30)).accepted);
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 1; }, 60));
  EXPECT_EQ(bench.controller.sample().position[1], 20);
  EXPECT_EQ(bench.controller.sample().position[2], 5);
}

TEST(Restart, SingleBlockStopsAfterEachAxis) {
  Bench bench;
  bench.load(kPart);
  bench.press(Action::set_single_block, 1);
  ASSERT_TRUE(bench.controller.restart(at_sequence(30)).accepted);
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 1; }, 20));
  ASSERT_TRUE(bench.until_state(State::stopped, 60));
  EXPECT_EQ(bench.controller.sample().position[0], 40);
  EXPECT_EQ(bench.controller.sample().position[1], 0);
}

TEST(Restart, RefusedUntilTheSpindleAndTheToolAreAsTheProgramNeedsThem) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\nT5 M06\nM03 S800\nG00 X10.\nN10 G01 X20. F600.\nM30\n");
  const auto find = [&] {
    ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(Mode::memory)).accepted);
    ASSERT_TRUE(bench.controller.restart(at_sequence(10)).accepted);
    ASSERT_TRUE(bench.until_state(State::stopped, 20));
  };
  const auto mdi = [&](const char* block) {
    ASSERT_TRUE(bench.press(Action::reset).accepted);
    ASSERT_TRUE(bench.until_state(State::idle, 20));
    ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(Mode::mdi)).accepted);
    ASSERT_TRUE(bench.controller.enter_mdi(block).accepted);
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until_state(State::idle, 20)) << bench.controller.live().alarms.at(0).code;
  };
  find();
  const RestartReport needs = bench.controller.live().restart;
  EXPECT_EQ(needs.turning, 1);
  EXPECT_EQ(needs.tool, 5);
  EXPECT_EQ(needs.spindle, 800);
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "restart_spindle");
  mdi("M03 S800\n");
  find();
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "restart_tool");
  mdi("T5 M06\nM03 S800\n");
  find();
  EXPECT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_EQ(bench.controller.sample().position[0], 20);
}

TEST(Restart, ABlockThatIsNotThereIsAnAlarmAndNothingMoves) {
  Bench bench;
  bench.load(kPart);
  ASSERT_TRUE(bench.controller.restart(at_sequence(99)).accepted);
  ASSERT_TRUE(bench.until_state(State::alarm, 20));
  EXPECT_EQ(bench.controller.sample().position, AxisVector{});
}

TEST(Restart, WhatIsRefused) {
  Bench bench;
  EXPECT_EQ(bench.controller.restart(at_sequence(10)).reason, "no_program");
  bench.load(kPart);
  EXPECT_EQ(bench.controller.restart(std::nullopt).reason, "no_breakpoint");
  EXPECT_EQ(bench.controller.restart(interp::RestartPoint{}).reason, "bad_value");
  ASSERT_TRUE(bench.start());
  EXPECT_EQ(bench.controller.restart(at_sequence(10)).reason, "running");
}

// What a run that was broken off leaves behind, on this controller and on the next one after a power loss.
TEST(Restart, AtTheBlockThatWasBrokenOff) {
  Retained kept;
  {
    Bench bench;
    bench.load(kPart);
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[1] > 30; }, 60));
    kept = bench.controller.retained();  // as the storage thread takes it; then the power fails
  }
  ASSERT_EQ(kept.breakpoint.program, "O1");
  EXPECT_EQ(kept.breakpoint.sequence, 30u);

  ControllerOptions options = virtual_options();
  options.retained = kept;
  Bench bench("fanuc-0i-m", std::move(options));
  bench.load(kPart);
  EXPECT_EQ(bench.controller.live().breakpoint.sequence, 30u);
  ASSERT_TRUE(bench.controller.restart(std::nullopt).accepted);
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  EXPECT_EQ(bench.controller.live().restart.position[1], 20);
  EXPECT_EQ(bench.controller.live().restart.position[0], 40);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 200));
  EXPECT_EQ(bench.controller.sample().position[1], 50);
  EXPECT_TRUE(bench.controller.retained().breakpoint.program.empty()) << "it came to its end";
}

TEST(Restart, NotInAnotherRevision) {
  Retained kept;
  kept.breakpoint = {"O1", "another", 4, 10, 4};
  ControllerOptions options = virtual_options();
  options.retained = kept;
  Bench bench("fanuc-0i-m", std::move(options));
  bench.load(kPart);
  EXPECT_EQ(bench.controller.restart(std::nullopt).reason, "other_program");
}

// The kept block is never one that has not begun: at every period, restart there would begin at or before the
// axes.
TEST(Restart, TheKeptBlockIsNeverAheadOfTheAxes) {
  Bench bench;
  bench.load(kPart);
  ASSERT_TRUE(bench.start());
  std::uint32_t last = 0;
  ASSERT_TRUE(bench.until(
      [&] {
        const Breakpoint at = bench.controller.retained().breakpoint;
        if (at.block != 0) {
          EXPECT_GE(at.block, last);
          last = at.block;
          const AxisVector& axes = bench.controller.sample().position;
          EXPECT_TRUE(at.sequence < 20 || at.sequence >= 40 || axes[2] < 5.2) << axes[2];
          EXPECT_TRUE(at.sequence < 30 || axes[0] > 39.8) << axes[0];
        }
        return bench.state() == State::idle;
      },
      200));
  EXPECT_GE(last, 6u);
}

// ---- what the search would write

using Values = std::map<std::string, double>;

Values values_of(const Bench& bench, const interp::MachineData& data) {
  std::vector<char> axes;
  for (const machine::Axis& axis : bench.controller.machine().axes) axes.push_back(axis.name);
  Values values;
  interp::each_value(data, axes, [&](const std::string& what, double value) { values[what] = value; });
  return values;
}

/// What the events that were taken make of `values`: whoever only hears of them has what the machine has.
Values told(const Bench& bench, Values values) {
  for (const OffsetChanged& told : bench.all<OffsetChanged>()) {
    const interp::DataChange& change = told.change;
    const bool absent = std::isnan(change.after) || (change.after == 0 && change.what.starts_with("tool/"));
    if (absent)
      values.erase(change.what);
    else
      values[change.what] = change.after;
  }
  return values;
}

/// A G10 and variables, then a calculation that is longer than one piece of the look-ahead.
constexpr const char* kLongSearch =
    "O1\nG90 G94 G21\nG10 L11 P3 R5.\nG10 L2 P1 "
    "X50.\n#101=7\n#501=8\n#1=0\nWHILE[#1LT60000]DO1\n#1=#1+1\nEND1\n"
    "N30 G01 X10. F600.\nM30\n";

struct RestartSearch : testing::Test {
  Bench bench;
  Values before;

  /// Stands in a pause of the search, behind the G10.
  void SetUp() override {
    bench.load(kLongSearch);
    ASSERT_TRUE(bench.controller
                    .edit_data([](interp::MachineData& data) { data.tools.resize(10); },
                               {"tool/1/tip", 0, 0, ""}, "test")
                    .accepted);
    bench.commit();
    bench.events.clear();
    before = values_of(bench, bench.controller.data());
    ASSERT_TRUE(bench.controller.restart(at_sequence(30)).accepted);
    (void)bench.controller.work();
    ASSERT_FALSE(bench.controller.live().restart.found);
  }
  EditResult write(const char* what, double after) {
    EditRequest request;
    request.values.push_back({what, 0, after});
    request.origin = "person";
    request.by = "wang";
    return bench.controller.edit_values(request);
  }
};

TEST_F(RestartSearch, WhatIsStoredMeanwhileIsTheMachinesOwn) {
  ASSERT_TRUE(write("tool/5/wear/Z", 0.1).accepted);
  const Taken taken = bench.controller.take_events();
  ASSERT_TRUE(taken.data);
  before["tool/5/wear/Z"] = 0.1;
  EXPECT_EQ(values_of(bench, *taken.data), before);
}

TEST_F(RestartSearch, WhatAPersonWritesMeanwhileStays) {
  ASSERT_TRUE(write("tool/5/wear/Z", 0.1).accepted);
  ASSERT_TRUE(bench.until_state(State::stopped, 20));
  bench.commit();
  const Values now = values_of(bench, bench.controller.data());
  EXPECT_EQ(now.at("tool/5/wear/Z"), 0.1);
  EXPECT_FALSE(now.contains("tool/3/wear/Z"))
      << "the run that was broken off wrote it, and somebody took it back";
  EXPECT_EQ(now.at("variable/501"), 0) << "kept without power, like an offset";
  EXPECT_EQ(now.at("variable/101"), 7) << "it does not outlive power: the rest of the program needs it";
  EXPECT_EQ(now, told(bench, before));
}

TEST_F(RestartSearch, ResetLeavesNothingOfIt) {
  ASSERT_TRUE(bench.press(Action::reset).accepted);
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  EXPECT_EQ(values_of(bench, bench.controller.data()), before);
  EXPECT_EQ(bench.controller.live().absolute[0], 0) << "the zero point too";
  bench.commit();
  EXPECT_TRUE(bench.all<OffsetChanged>().empty());
  // The next program's changes are told again.
  bench.load("O2\nG90 G94 G21\nG10 L11 P3 R5.\n#101=7\n#501=8\nM30\n", "O2");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  bench.commit();
  const Values now = values_of(bench, bench.controller.data());
  EXPECT_EQ(now.at("tool/3/wear/Z"), 5);
  EXPECT_EQ(now, told(bench, before));
}

}  // namespace
}  // namespace headstock::operation

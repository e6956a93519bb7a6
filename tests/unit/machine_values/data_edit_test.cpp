// Writing values into a controller: seen before, whole or not at all, by its rules, each told in an event.
#include "operation/data_edit.hpp"

#include <gtest/gtest.h>

#include "tests/unit/operation/bench.hpp"

namespace headstock::operation {
namespace {

struct Edit : testing::Test {
  Bench bench{"fanuc-0i-t"};

  EditResult write(std::vector<DataEdit> values, bool parameter_write = false) {
    return bench.controller.edit_values({std::move(values), "person", "wang", 7, parameter_write});
  }
  std::optional<double> variable(std::uint32_t number) {
    const auto variables = bench.controller.data().common_variables;
    const auto found = variables.find(number);
    return found != variables.end() ? std::optional(found->second) : std::nullopt;
  }
  double wear_x(std::size_t number) { return bench.controller.data().tools.at(number).wear[0]; }
};

TEST_F(Edit, IsToldWithWhoAndWhatBeforeAndAfter) {
  const EditResult result = write({{"tool/3/wear/X", 0, 0.02}, {"tool/3/wear/Z", 0, -0.01}});
  ASSERT_TRUE(result.accepted) << result.reason;
  EXPECT_EQ(wear_x(3), 0.02);
  EXPECT_EQ(result.version, bench.controller.data().version);
  const Taken taken = bench.controller.take_events();
  ASSERT_EQ(taken.events.size(), 2u);
  ASSERT_TRUE(taken.data) << "the values come with the events that tell of them";
  EXPECT_EQ(taken.data->tools.at(3).wear[1], -0.01);
  const auto& told = std::get<OffsetChanged>(taken.events[0].event);
  EXPECT_EQ(told.change.what, "tool/3/wear/X");
  EXPECT_EQ(told.change.before, 0);
  EXPECT_EQ(told.change.after, 0.02);
  EXPECT_EQ(told.origin, "person");
  EXPECT_EQ(told.by, "wang");
  EXPECT_EQ(told.request, 7u);
}

TEST_F(Edit, WhatHasChangedMeanwhileIsNotOverwritten) {
  ASSERT_TRUE(write({{"tool/3/wear/X", 0, 0.02}}).accepted);
  const EditResult second = write({{"tool/4/wear/X", 0, 0.5}, {"tool/3/wear/X", 0, 0.03}});
  EXPECT_FALSE(second.accepted);
  EXPECT_EQ(second.reason, "changed_meanwhile");
  EXPECT_EQ(second.where, "tool/3/wear/X");
  EXPECT_EQ(wear_x(3), 0.02);
  EXPECT_LE(bench.controller.data().tools.size(), 4u) << "nor was the other one written";
}

TEST_F(Edit, OneBadValueAndNothingIsWritten) {
  const auto version = bench.controller.data().version;
  EXPECT_EQ(write({{"tool/3/wear/X", 0, 0.02}, {"tool/3/tip", 0, 11}}).reason, "out_of_range");
  EXPECT_EQ(write({{"tool/3/wear/X", 0, 0.02}, {"tool/999/wear/X", 0, 1}}).reason, "bad_place");
  EXPECT_TRUE(bench.controller.take_events().events.empty());
  EXPECT_EQ(bench.controller.data().version, version);
}

TEST_F(Edit, AValueThatIsTheSameIsNoChange) {
  const EditResult result = write({{"tool/3/wear/X", 0, 0}});
  EXPECT_TRUE(result.accepted);
  EXPECT_TRUE(bench.controller.take_events().events.empty());
}

TEST_F(Edit, WhileAProgramRunsOnlyLengthsAndTheyCountFromTheNextT) {
  ASSERT_TRUE(write({{"tool/1/wear/X", 0, 0.0001}}).accepted);
  bench.load("O1\nG21 G98\nG00 X100. Z100.\nG01 Z50. F60.\nM30\n%\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until(
      [&] { return bench.controller.live().machine[1] != 0 && bench.state() == State::running; }));
  EXPECT_EQ(write({{"tool/1/radius", 0, 0.4}}).reason, "running");
  EXPECT_EQ(write({{"work/G54/X", 0, 1}}).reason, "running");
  EXPECT_EQ(write({{"variable/500", variable(500), 1}}).reason, "running");
  const double shown = bench.controller.live().absolute[0];
  EXPECT_TRUE(write({{"tool/1/wear/X", 0.0001, 0.05}}).accepted);
  EXPECT_EQ(wear_x(1), 0.05);
  EXPECT_EQ(bench.controller.live().absolute[0], shown) << "nothing moves or is shown moved by it";
}

TEST_F(Edit, ParametersNeedTheSwitchAtTheMachineAndMdi) {
  EXPECT_EQ(write({{"parameter/6713", std::nullopt, 50}}).reason, "parameter_write_off");
  EXPECT_EQ(write({{"parameter/6713", std::nullopt, 50}}, true).reason, "not_mdi");
  ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(Mode::mdi)).accepted);
  EXPECT_TRUE(write({{"parameter/6713", std::nullopt, 50}}, true).accepted);
  EXPECT_EQ(bench.controller.data().parameter("6713"), 50);
  EXPECT_TRUE(write({{"parameter/6713", 50, std::nullopt}}, true).accepted);
  EXPECT_FALSE(bench.controller.data().parameters.contains("6713"));
}

TEST_F(Edit, TheParameterSwitchIsAnAlarmUntilItIsOffAndReset) {
  const auto codes = [this] {
    std::vector<std::string> found;
    for (const ActiveAlarm& alarm : bench.controller.live().alarms) found.push_back(alarm.code);
    return found;
  };
  bench.load("O1\nG21 G98\nG00 X100. Z100.\nG01 Z50. F60.\nM30\n%\n");
  ASSERT_TRUE(bench.controller.set_parameter_write(true).accepted);
  ASSERT_TRUE(bench.controller.set_parameter_write(true).accepted) << "once is enough";
  EXPECT_EQ(codes(), std::vector<std::string>{"SW0100"});
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "alarm") << "0i-D L45460";
  ASSERT_TRUE(bench.press(Action::reset).accepted);
  ASSERT_TRUE(bench.until([&] { return bench.press(Action::cycle_start).reason != "resetting"; }));
  EXPECT_EQ(codes(), std::vector<std::string>{"SW0100"}) << "reset alone does not clear it";
  ASSERT_TRUE(bench.controller.set_parameter_write(false).accepted);
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "alarm") << "0i-D L45464: RESET ends the state of alarm";
  ASSERT_TRUE(bench.press(Action::reset).accepted);
  EXPECT_TRUE(codes().empty());
  ASSERT_TRUE(bench.until_state(State::idle));
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::running));
  EXPECT_EQ(bench.controller.set_parameter_write(true).reason, "running");
  EXPECT_TRUE(codes().empty());
}

TEST_F(Edit, ControlsWithoutSuchAnAlarmHaveNone) {
  Bench other("k2000tc");
  ASSERT_TRUE(other.controller.set_parameter_write(true).accepted);
  EXPECT_TRUE(other.controller.live().alarms.empty());
  Bench gsk("gsk-218t");
  ASSERT_TRUE(gsk.controller.set_parameter_write(true).accepted);
  ASSERT_EQ(gsk.controller.live().alarms.size(), 1u);
  EXPECT_EQ(gsk.controller.live().alarms[0].code, "100");
}

TEST_F(Edit, AWorkOffsetIsShownAtOnce) {
  const double before = bench.controller.live().absolute[1];
  ASSERT_TRUE(write({{"work/G54/Z", 0, -20}}).accepted);
  EXPECT_DOUBLE_EQ(bench.controller.live().absolute[1], before + 20);
}

TEST_F(Edit, AG10BetweenSeeingAndWritingIsNotLost) {
  bench.load("O1\nG10 P3 X0.7\nM30\n%\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_EQ(write({{"tool/3/wear/X", 0, 0.02}}).reason, "changed_meanwhile");
  EXPECT_EQ(wear_x(3), 0.7);
  const auto told = bench.all<OffsetChanged>();
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].origin, "G10");
}

TEST_F(Edit, ARunTellsItsCounterHoldsAndOverrides) {
  bench.load("O1\nG21 G98\nG00 X100. Z100.\nG01 Z50. F600.\nM30\n%\n");
  Command start{Action::cycle_start};
  start.user = "li";
  ASSERT_TRUE(bench.controller.command(start).accepted);
  ASSERT_TRUE(bench.until([&] { return bench.controller.live().feed_actual_mm_min > 0; }));
  bench.press(Action::set_feed_override, 0.5);
  bench.press(Action::feed_hold);
  bench.press(Action::feed_hold);
  bench.until([&] { return bench.controller.live().feed_actual_mm_min == 0; });
  bench.press(Action::set_feed_override, 1.2);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle));
  bench.commit();
  const auto started = bench.all<RunStarted>();
  ASSERT_EQ(started.size(), 1u);
  EXPECT_EQ(started[0].by, "li");
  EXPECT_EQ(started[0].total, 0u);
  const auto ended = bench.all<RunEnded>();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].total, 1u);
  EXPECT_EQ(ended[0].record.holds, 1u) << "a button held down is one hold";
  EXPECT_EQ(ended[0].record.feed_least, 0.5);
  EXPECT_EQ(ended[0].record.feed_most, 1.2);
}

TEST(Run, ThatAPowerCutEndedIsToldAtTheNextStart) {
  ControllerOptions options = virtual_options();
  options.retained.run_open = true;
  options.retained.last_run = 12;
  options.retained.parts_total = 5;
  Bench bench("fanuc-0i-t", std::move(options));
  bench.commit();
  const auto ended = bench.all<RunEnded>();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].run, 12u);
  EXPECT_EQ(ended[0].outcome, "interrupted");
  EXPECT_EQ(ended[0].total, 5u);
  EXPECT_FALSE(bench.controller.take_events().retained.run_open);
}

}  // namespace
}  // namespace headstock::operation

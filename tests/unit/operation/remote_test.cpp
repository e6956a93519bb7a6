// What the network may do, and when it stops being allowed to.
#include <gtest/gtest.h>

#include "bench.hpp"

namespace headstock::operation {
namespace {

const char* const kProgram = "O1\nG90 G94 G21\nG01 X50. F3000.\nM30\n";

TEST(Remote, NothingThatMovesIsAcceptedWhileNotArmed) {
  Bench bench;
  bench.load(kProgram);
  for (const Action action :
       {Action::cycle_start, Action::reset, Action::set_mode, Action::set_feed_override,
        Action::set_rapid_override, Action::set_spindle_override, Action::set_single_block,
        Action::set_optional_stop, Action::set_block_skip, Action::set_dry_run}) {
    const CommandResult result = bench.press(action, 1, Origin::network);
    EXPECT_FALSE(result.accepted) << static_cast<int>(action);
    EXPECT_EQ(result.reason, "not_armed");
  }
  for (const Action action : {Action::arm_remote, Action::emergency_stop_release, Action::set_machine_lock})
    EXPECT_EQ(bench.press(action, 1, Origin::network).reason, "panel_only");
  for (int i = 0; i < 1000; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position[0], 0);
}

TEST(Remote, ArmedItStartsAndAnybodyMayStopIt) {
  Bench bench;
  bench.load(kProgram);
  ASSERT_TRUE(bench.press(Action::arm_remote).accepted);
  ASSERT_TRUE(bench.press(Action::cycle_start, 0, Origin::network).accepted);
  for (int i = 0; i < 300; ++i) bench.period();
  bench.press(Action::disarm_remote);
  EXPECT_EQ(bench.state(), State::running) << "disarming does not stop a cut";
  EXPECT_TRUE(bench.press(Action::feed_hold, 0, Origin::network).accepted);
  for (int i = 0; i < 500; ++i) bench.period();
  EXPECT_EQ(bench.state(), State::hold);
  EXPECT_EQ(bench.press(Action::cycle_start, 0, Origin::network).reason, "not_armed");
  EXPECT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle));
}

TEST(Remote, ArmingEndsWithTheLinkTheEmergencyStopAndAClearedAlarm) {
  Bench bench;
  const auto armed = [&] { return bench.controller.live().remote_armed; };
  bench.press(Action::arm_remote);
  EXPECT_TRUE(armed());
  bench.controller.link_lost();
  EXPECT_FALSE(armed());

  bench.press(Action::arm_remote);
  bench.press(Action::emergency_stop);
  EXPECT_FALSE(armed());
  EXPECT_EQ(bench.press(Action::arm_remote).reason, "emergency_stop");
  for (int i = 0; i < 100; ++i) bench.period();
  ASSERT_TRUE(bench.press(Action::emergency_stop_release).accepted);
  EXPECT_FALSE(armed());

  bench.press(Action::arm_remote);
  bench.load("O1\nG777\nM30\n");
  ASSERT_TRUE(bench.press(Action::cycle_start, 0, Origin::network).accepted);
  ASSERT_TRUE(bench.until_state(State::alarm, 5));
  EXPECT_TRUE(armed());
  EXPECT_TRUE(bench.press(Action::reset, 0, Origin::network).accepted);
  EXPECT_FALSE(armed());
}

TEST(Remote, LinkLossDoesNotStopACut) {
  Bench bench;
  bench.load(kProgram);
  bench.press(Action::arm_remote);
  bench.press(Action::cycle_start, 0, Origin::network);
  for (int i = 0; i < 300; ++i) bench.period();
  bench.controller.link_lost();
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_NEAR(bench.controller.sample().position[0], 50, 1e-9);
}

TEST(Remote, AProgramChosenFromAfarIsNotStartedUnseen) {
  Bench bench;
  bench.programs->texts["O1"] = kProgram;
  ASSERT_TRUE(bench.controller.select("O1", "h", bench.programs, Origin::network).accepted);
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "selected_remotely");
  EXPECT_TRUE(bench.press(Action::cycle_start).accepted);
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  // Arming is having seen it.
  ASSERT_TRUE(bench.controller.select("O1", "h", bench.programs, Origin::network).accepted);
  bench.press(Action::arm_remote);
  EXPECT_TRUE(bench.press(Action::cycle_start, 0, Origin::network).accepted);
}

TEST(Remote, NothingIsChangedWhileRunning) {
  Bench bench;
  bench.load(kProgram);
  ASSERT_TRUE(bench.start());
  EXPECT_EQ(bench.controller.select("O1", "h", bench.programs).reason, "running");
  EXPECT_EQ(bench.press(Action::set_mode, 0).reason, "running");
  EXPECT_EQ(bench.press(Action::set_dry_run, 1).reason, "running");
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "running");
  EXPECT_EQ(bench.controller.edit_data([](interp::MachineData&) {}, {"work/G54/X", 0, 1}, "panel").reason,
            "running");
}

TEST(Remote, ModeAndProgramMustFit) {
  Bench bench;
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "no_program");
  EXPECT_EQ(bench.controller.select("O404", "h", bench.programs).reason, "not_found");
  bench.load(kProgram);
  bench.press(Action::set_mode, static_cast<double>(Mode::jog));
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "wrong_mode");
  bench.press(Action::set_mode, static_cast<double>(Mode::remote));
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "no_program");
}

}  // namespace
}  // namespace headstock::operation

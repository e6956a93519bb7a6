// Interruption macros (M96 P … M97) on the machine: between blocks and inside them, by edge and by level, and
// what becomes of the block that was broken into.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"

namespace headstock::operation {
namespace {

machine::Machine with_signal(const std::string& profile = "fanuc-0i-m") {
  machine::Machine machine = *machine::default_machine(profile);
  machine.interruption_input = true;
  return machine;
}

struct Interrupted {
  explicit Interrupted(const std::string& text, const std::string& macro,
                       const std::string& profile = "fanuc-0i-m", const std::string& parameter = {})
      : bench(with_signal(profile)) {
    const auto set = [&](interp::MachineData& data) {
      if (!parameter.empty()) data.parameters[parameter] = 1;
    };
    EXPECT_TRUE(bench.controller.edit_data(set, {}, "test").accepted);
    bench.programs->texts["O13"] = macro;
    bench.load(text);
    EXPECT_TRUE(bench.start());
  }
  bool at_x(double more_than) {
    return bench.until([&] { return position(0) > more_than; }, 20);
  }
  double position(std::size_t axis) const { return bench.controller.sample().position[axis]; }
  void pulse() {
    bench.controller.set_interruption_signal(true);
    bench.controller.set_interruption_signal(false);
  }
  Bench bench;
};

constexpr const char* kTwoMoves = "O1\nG90 G94 G21 G54\nM96 P13\nG01 X40. F1200.\nX60.\nM97\nM30\n";
constexpr const char* kLift = "O13\nG91 G01 Z5. F3000.\nM99\n";

TEST(Interruption, AMachineWithoutTheSignalRefusesM96) {
  Bench bench;
  bench.load(kTwoMoves);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 20));
  EXPECT_EQ(bench.controller.sample().position[0], 0);
}

TEST(Interruption, WithoutASignalTheProgramRunsAsWritten) {
  Interrupted run(kTwoMoves, kLift);
  ASSERT_TRUE(run.bench.until_state(State::idle, 60));
  EXPECT_EQ(run.position(0), 60);
  EXPECT_EQ(run.position(2), 0);
}

// 0i-D type I (6003#2 = 0): with a statement that moves, the rest of the broken block is dropped.
TEST(Interruption, InsideABlockItsRestIsDroppedWhenTheProgramMoves) {
  Interrupted run(kTwoMoves, kLift);
  ASSERT_TRUE(run.at_x(10));
  run.pulse();
  ASSERT_TRUE(run.bench.until([&] { return run.position(2) > 1; }, 20));
  const double stood = run.position(0);
  EXPECT_GT(stood, 10);
  EXPECT_LT(stood, 20) << "it was broken off at once";
  ASSERT_TRUE(run.bench.until([&] { return run.position(0) > stood + 1; }, 20));
  EXPECT_EQ(run.position(2), 5) << "Z is at its end before the next block";
  ASSERT_TRUE(run.bench.until_state(State::idle, 60));
  EXPECT_EQ(run.position(0), 60);
  run.bench.commit();
  EXPECT_EQ(run.bench.all<RunEnded>().back().outcome, "completed");
}

TEST(Interruption, InsideABlockAProgramThatOnlyCalculatesLetsItGoOn) {
  Interrupted run(kTwoMoves, "O13\n#500=#500+1\nM99\n");
  ASSERT_TRUE(run.at_x(10));
  run.pulse();
  bool stood = false;
  ASSERT_TRUE(run.bench.until(
      [&] {
        stood = stood || (!run.bench.controller.sample().moving && run.position(0) < 39);
        return run.position(0) >= 40;
      },
      60));
  EXPECT_TRUE(stood);
  ASSERT_TRUE(run.bench.until_state(State::idle, 60));
  EXPECT_EQ(run.position(0), 60);
  EXPECT_EQ(run.bench.controller.data().common_variables[500], 1);
}

// Type II (6003#2 = 1): the block is carried out to its end first.
TEST(Interruption, BetweenBlocksTheBlockIsCarriedOutFirst) {
  Interrupted run(kTwoMoves, kLift, "fanuc-0i-m", "6003#2");
  ASSERT_TRUE(run.at_x(10));
  run.pulse();
  ASSERT_TRUE(run.bench.until([&] { return run.position(2) > 0.1; }, 20));
  EXPECT_EQ(run.position(0), 40);
  ASSERT_TRUE(run.bench.until_state(State::idle, 60));
  EXPECT_EQ(run.position(0), 60);
  EXPECT_EQ(run.position(2), 5);
}

TEST(Interruption, ASignalThatWasOnBeforeCountsByItsLevelOnly) {
  for (const bool by_level : {false, true}) {
    Interrupted run(kTwoMoves, "O13\n#500=#500+1\nM99\n", "fanuc-0i-m", by_level ? "6003#3" : "");
    run.bench.controller.set_interruption_signal(true);
    ASSERT_TRUE(run.bench.until_state(State::idle, 600));
    const auto variables = run.bench.controller.data().common_variables;
    const double times = variables.count(500) != 0 ? variables.at(500) : 0;
    EXPECT_EQ(times >= 2, by_level) << times;
    EXPECT_EQ(times == 0, !by_level) << times;
    EXPECT_EQ(run.position(0), 60);
  }
}

TEST(Interruption, ASignalBehindM97IsNotTaken) {
  Interrupted run("O1\nG90 G94 G21\nM96 P13\nG01 X10. F1200.\nM97\nX40.\nM30\n", kLift);
  ASSERT_TRUE(run.at_x(20));
  run.pulse();
  ASSERT_TRUE(run.bench.until_state(State::idle, 60));
  EXPECT_EQ(run.position(0), 40);
  EXPECT_EQ(run.position(2), 0);
}

TEST(Interruption, ResetInTheMiddleLeavesNothingBehind) {
  Interrupted run(kTwoMoves, kLift);
  ASSERT_TRUE(run.at_x(10));
  run.pulse();
  for (int i = 0; i < 20; ++i) run.bench.period();  // braking
  ASSERT_TRUE(run.bench.press(Action::reset).accepted);
  ASSERT_TRUE(run.bench.until_state(State::idle, 20));
  const double stood = run.position(0);
  run.bench.load("O1\nG91 G94 G21 G01 X3. F1200.\nM30\n");
  ASSERT_TRUE(run.bench.start());
  ASSERT_TRUE(run.bench.until_state(State::idle, 20));
  EXPECT_NEAR(run.position(0), std::round((stood + 3) * 1000) / 1000, 1e-6) << "a whole least increment";
  EXPECT_EQ(run.position(2), 0);
}

TEST(Interruption, FeedHoldWhileItBrakesIsObeyed) {
  Interrupted run(kTwoMoves, kLift);
  ASSERT_TRUE(run.at_x(10));
  run.pulse();
  run.bench.period();
  ASSERT_TRUE(run.bench.press(Action::feed_hold).accepted);
  for (int i = 0; i < 2'000; ++i) run.bench.period();
  EXPECT_EQ(run.position(2), 0) << "nothing begins in feed hold";
  const double stood = run.position(0);
  for (int i = 0; i < 500; ++i) run.bench.period();
  EXPECT_EQ(run.position(0), stood);
  ASSERT_TRUE(run.bench.start());
  ASSERT_TRUE(run.bench.until_state(State::idle, 60));
  EXPECT_EQ(run.position(0), 60);
  EXPECT_EQ(run.position(2), 5);
}

// K2000TC type I (P4100.3 = 1): the block that was broken into is carried out again (L20751).
TEST(Interruption, TheK2000CarriesTheBrokenBlockOutAgain) {
  Interrupted run("O1\nG98 G01 F1200\nM96 P13\nG01 U40.\nU0.\nM97\nM30\n", "O13\nG98 G01 W-5. F3000\nM99\n",
                  "k2000tc", "P4100.3");
  const double x = run.position(0), z = run.position(1);
  ASSERT_TRUE(run.bench.until([&] { return run.position(0) > x + 5; }, 20));
  run.pulse();
  ASSERT_TRUE(run.bench.until([&] { return run.position(1) < z - 1; }, 20));
  const double stood = run.position(0);
  EXPECT_LT(stood, x + 15);
  ASSERT_TRUE(run.bench.until([&] { return run.bench.state() != State::running; }, 60));
  EXPECT_EQ(run.bench.state(), State::idle);
  EXPECT_GT(run.position(0), stood + 1);
  EXPECT_EQ(run.position(1), z - 5);
}

// Mirror image by the setting (No.0012): from where the axis stood when it was switched on.
TEST(MirrorSetting, HoldsFromWhereItWasSwitchedOnAndIsNotGuessedAfterARestart) {
  Bench bench;
  const auto write = [](Bench& on, double value) {
    ASSERT_TRUE(
        on.controller
            .edit_data([=](interp::MachineData& data) { data.parameters["0012#0/X"] = value; }, {}, "test")
            .accepted);
  };
  const auto run = [](Bench& on, const char* text) {
    on.load(text);
    ASSERT_TRUE(on.start());
    ASSERT_TRUE(on.until_state(State::idle, 60));
  };
  run(bench, "O1\nG90 G94 G21 G00 X10.\nM30\n");
  write(bench, 1);
  run(bench, "O1\nG90 G94 G21 G01 X30. Y5. F3000.\nM30\n");
  EXPECT_NEAR(bench.controller.sample().position[0], -10, 1e-9);
  EXPECT_NEAR(bench.controller.sample().position[1], 5, 1e-9);
  run(bench, "O1\nG90 G94 G21 G00 X10.\nM30\n");
  EXPECT_NEAR(bench.controller.sample().position[0], 10, 1e-9) << "the mirror stays where it was";

  interp::MachineData kept = bench.controller.data();
  Controller again(*machine::default_machine("fanuc-0i-m"), kept, virtual_options());
  ASSERT_TRUE(again.select("O1", "hash", bench.programs).accepted);
  EXPECT_EQ(again.command({Action::cycle_start}).reason, "mirror_place");
  const auto set = [&](double value) {
    return again
        .edit_data([=](interp::MachineData& data) { data.parameters["0012#0/X"] = value; }, {}, "test")
        .accepted;
  };
  ASSERT_TRUE(set(0));
  ASSERT_TRUE(set(1));
  EXPECT_TRUE(again.command({Action::cycle_start}).accepted);
}

}  // namespace
}  // namespace headstock::operation

// Macros as the operation layer meets them: standstill, pause and stop, interruption, changes of variables, restart.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "macro/environment.hpp"
#include "program/library.hpp"

namespace headstock::interp {
namespace {

struct Running final : macro::Environment {
  bool takes_time() const override { return true; }
  bool wants_pause() override { return pauses; }
  bool wants_stop() override { return ++asked >= stop_after; }
  bool pauses = false;
  std::uint64_t asked = 0, stop_after = UINT64_MAX;
};

struct Bench {
  explicit Bench(std::string_view profile = "fanuc-0i-m")
      : machine(*machine::default_machine(profile)),
        interpreter(*dialects::find(profile), machine, data, &programs) {}
  machine::Machine machine;
  MachineData data;
  program::FilePrograms programs;
  Interpreter interpreter;
  std::string text;

  void start(std::string program) {
    text = std::move(program);
    interpreter.start(program::source_from_text(text), {});
  }
  Pull next() { return interpreter.next(operation); }
  std::string alarm_of_run(int most = 100'000) {
    for (int i = 0; i < most; ++i) {
      const Pull pull = next();
      if (pull == Pull::finished) return "none";
      if (const auto* alarm = std::get_if<Alarm>(&operation); pull == Pull::operation && alarm != nullptr)
        return alarm->code;
    }
    return "endless";
  }
  Operation operation;
};

const Motion* motion(const Operation& operation) {
  if (const auto* rapid = std::get_if<Rapid>(&operation)) return rapid;
  return std::get_if<Feed>(&operation);
}

TEST(Macro, ASignalIsReadAtAStandstill) {
  Bench bench;
  Running environment;
  bench.interpreter.set_environment(&environment);
  bench.start("G0 X1.\nIF[#1000 EQ 1]GOTO 9\nX2.\nN9 X3.\nM30\n");
  ASSERT_EQ(bench.next(), Pull::operation);
  ASSERT_EQ(bench.next(), Pull::standstill);
  environment.set_input(0, true);  // comes while the first move is under way
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_EQ(motion(bench.operation)->end_work[0], 3.0);
}

TEST(Macro, AnOutputDoesNotRunAheadOfAMove) {
  Bench bench;
  Running environment;
  bench.interpreter.set_environment(&environment);
  bench.start("G0 X1.\n#1100=1\nX2.\nM30\n");
  ASSERT_EQ(bench.next(), Pull::operation);
  ASSERT_EQ(bench.next(), Pull::standstill);
  EXPECT_FALSE(environment.output(0));
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_TRUE(environment.output(0));
}

TEST(Macro, PlainVariablesDoNotStopTheMachine) {
  Bench bench;
  Running environment;
  bench.interpreter.set_environment(&environment);
  bench.start("G0 X1.\n#1=#5001+1\n#500=#1\n#2001=0.1\nX#1\nM30\n");
  ASSERT_EQ(bench.next(), Pull::operation);
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_EQ(motion(bench.operation)->end_work[0], 2.0);
}

TEST(Macro, ALongCalculationPausesAndGoesOn) {
  Bench bench;
  Running environment;
  environment.pauses = true;
  bench.interpreter.set_environment(&environment);
  bench.start("#1=0\nWHILE[#1 LT 10000]DO1\n#1=#1+1\nEND1\nG0 X#1\nM30\n");
  int pauses = 0;
  Pull pull = bench.next();
  for (; pull == Pull::pause; pull = bench.next()) ++pauses;
  EXPECT_GT(pauses, 10);
  ASSERT_EQ(pull, Pull::operation);
  EXPECT_EQ(motion(bench.operation)->end_work[0], 10'000.0);
}

TEST(Macro, AStopEndsAnyLoopAtOnce) {
  Bench bench;
  Running environment;
  environment.stop_after = 3;
  bench.interpreter.set_environment(&environment);
  bench.start("DO1\n#1=#1+1\nEND1\n");
  EXPECT_EQ(bench.next(), Pull::finished);
  EXPECT_EQ(environment.asked, 3u);
  EXPECT_EQ(bench.next(), Pull::finished);
}

TEST(Macro, EndlessLoopsAreAlarms) {
  Bench bench;
  Switches switches;
  switches.most_jumps = 50'000;
  bench.interpreter.set_switches(switches);
  bench.start("DO1\n#1=#1+1\nEND1\nM30\n");
  EXPECT_EQ(bench.alarm_of_run(), "HS0001");
  bench.start("N1 GOTO 1\nM30\n");
  EXPECT_EQ(bench.alarm_of_run(), "HS0001");
}

TEST(Macro, AStreamCannotBeSearched) {
  struct Stream final : program::Source {
    explicit Stream(std::string_view whole) : source(program::source_from_text(whole)) {}
    program::ReadResult read(std::span<char> buffer) override { return source->read(buffer); }
    bool seek(std::uint64_t) override { return false; }
    std::unique_ptr<program::Source> source;
  };
  for (const char* text : {"GOTO 5\nN5 M30\n", "#1=0\nWHILE[#1 LT 1]DO1\n#1=1\nEND1\nM30\n"}) {
    Bench bench;
    bench.interpreter.start(std::make_unique<Stream>(text), {});
    EXPECT_EQ(bench.alarm_of_run(), "PS0123") << text;
  }
  Bench bench;
  bench.programs.add_text("O5\n#1=0\nWHILE[#1 LT 3]DO1\n#1=#1+1\nEND1\nG0X#1\nM99\n");
  bench.interpreter.start(std::make_unique<Stream>("#2=1\nG65 P5\nM30\n"), {});
  ASSERT_EQ(bench.next(), Pull::operation);  // in memory they may
  EXPECT_EQ(motion(bench.operation)->end_work[0], 3.0);
}

TEST(Macro, ChangesAreToldOnceAndStored) {
  Bench bench;
  std::vector<DataChange> changes;
  bench.interpreter.on_data_change([&](const DataChange& change) { changes.push_back(change); });
  bench.start("#500=0\nWHILE[#500 LT 1000]DO1\n#500=#500+1\nEND1\nG0 X1.\nM30\n");
  ASSERT_EQ(bench.next(), Pull::operation);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].what, "variable/500");
  EXPECT_EQ(changes[0].after, 1000);
  EXPECT_EQ(bench.data.common_variables.at(500), 1000);
}

TEST(Macro, ResetClearsWhatIsNotKept) {
  Bench bench;
  bench.start("#100=1\n#500=2\nG0X1.\nX2.\n");
  bench.next();
  ASSERT_EQ(bench.data.common_variables.count(100), 1u);
  bench.interpreter.reset({});
  EXPECT_EQ(bench.data.common_variables.count(100), 0u);
  EXPECT_EQ(bench.data.common_variables.at(500), 2);
}

TEST(Macro, AnInterruptionRunsAndBringsTheModalStateBack) {
  Bench bench;
  bench.programs.add_text("O13\nG91 G01 Z1. F50\n#100=#4401\nM99\n");
  bench.start("G90 G0\nM96 P13\nX1.\nX2.\nM97\nX3.\nM30\n");
  EXPECT_FALSE(bench.interpreter.interrupt({}));
  ASSERT_EQ(bench.next(), Pull::operation);
  ASSERT_TRUE(bench.interpreter.interruption_enabled());
  AxisVector here{};
  here[0] = 0.5;  // in the middle of the move
  ASSERT_TRUE(bench.interpreter.interrupt(here));
  EXPECT_FALSE(bench.interpreter.interrupt(here));  // not while it runs
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_EQ(motion(bench.operation)->at.program, 13u);
  EXPECT_EQ(motion(bench.operation)->end_work[2], 1.0);
  EXPECT_EQ(motion(bench.operation)->end_work[0], 0.5);
  ASSERT_EQ(bench.next(), Pull::operation);
  ASSERT_TRUE(std::holds_alternative<Rapid>(bench.operation));  // G00 and G90 again
  EXPECT_EQ(motion(bench.operation)->end_work[0], 2.0);
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_FALSE(bench.interpreter.interrupt(here));  // after M97
}

// Type I without an NC statement: the block that was broken into goes on where it was (0i-D 14.9.3).
TEST(Macro, AnInterruptionThatOnlyCalculatesLeavesTheBlockAsItWas) {
  Bench bench;
  bench.programs.add_text("O13\n#500=#500+1\nM99\n");
  bench.start("G90 G0\nM96 P13\nX10.\nG91 X1.\nM30\n");
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_EQ(motion(bench.operation)->end_work[0], 10.0);
  AxisVector here{};
  here[0] = 4;
  ASSERT_TRUE(bench.interpreter.interrupt(here, true));
  EXPECT_TRUE(bench.interpreter.interruption_only_looks());
  EXPECT_FALSE(bench.interpreter.interruption_enabled());  // not inside its own program
  ASSERT_EQ(bench.next(), Pull::operation);                // of the main program: the move to 10 is still due
  EXPECT_FALSE(bench.interpreter.interruption_only_looks());
  EXPECT_EQ(motion(bench.operation)->at.program, 0u);
  EXPECT_EQ(motion(bench.operation)->end_work[0], 11.0);
  EXPECT_EQ(bench.data.common_variables.at(500), 1.0);
}

// K2000TC: the power-on codes inside, and the block that was broken into is carried out again (L20720, L20751).
TEST(Macro, TheK2000RepeatsTheBlockThatWasBrokenInto) {
  Bench bench("k2000tc");
  bench.data.parameters["P4100.3"] = 1;
  bench.programs.add_text("O13\nG00 Z5.\nM99\n");
  bench.start("O1\nG98 G01 F100\nM96 P13\nX10.\nX20.\nM97\nX30.\nM30\n");
  const auto next_motion = [&bench] {  // the power-on codes may say something to the spindle between
    while (bench.next() == Pull::operation) {
      if (motion(bench.operation) != nullptr) return true;
      if (const auto* alarm = std::get_if<Alarm>(&bench.operation))
        ADD_FAILURE() << alarm->code << " line " << alarm->at.line << " of O" << alarm->at.program << ' ' << alarm->detail;
    }
    return false;
  };
  ASSERT_TRUE(next_motion());
  const double first = motion(bench.operation)->end_machine[0];
  ASSERT_TRUE(bench.interpreter.interruption_signal().inside_blocks);
  AxisVector here{};
  here[0] = first / 2;
  ASSERT_TRUE(bench.interpreter.interrupt(here, true));
  ASSERT_TRUE(next_motion());
  EXPECT_EQ(motion(bench.operation)->at.program, 13u);
  ASSERT_TRUE(next_motion());
  EXPECT_TRUE(std::holds_alternative<Feed>(bench.operation));  // G01 again
  EXPECT_EQ(motion(bench.operation)->end_machine[0], first);
  ASSERT_TRUE(next_motion());
  EXPECT_EQ(motion(bench.operation)->end_machine[0], 2 * first);
}

TEST(Macro, TheK2000TakesNoInterruptionFromALine) {
  Bench bench("k2000tc");
  Switches switches;
  switches.origin = ProgramOrigin::dnc;
  bench.interpreter.set_switches(switches);
  bench.programs.add_text("O13\nM99\n");
  bench.start("O1\nM96 P13\nG00 X10.\nM30\n");
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_FALSE(bench.interpreter.interruption_enabled());
}

TEST(Macro, AnInterruptionInsideACycleIsAnAlarm) {
  Bench bench("fanuc-0i-t");
  bench.programs.add_text("O13\nM99\n");
  bench.start("G0 X60. Z2.\nM96 P13\nG71 U2. R1.\nG71 P1 Q2 U0.5 W0.1 F0.2\nN1 G0 X20.\nG1 Z-10. F0.1\nN2 X60.\nM30\n");
  for (;;) {
    ASSERT_EQ(bench.next(), Pull::operation);
    const Motion* move = motion(bench.operation);
    if (move != nullptr && move->cycle != nullptr) break;
  }
  ASSERT_TRUE(bench.interpreter.interrupt({}));
  EXPECT_EQ(bench.alarm_of_run(), "PS0324");
}

TEST(Macro, AGroupThatBroughtItsModeMayNotBeginAnother) {
  Bench bench;
  bench.programs.add_text("O13\nG68 X0 Y0 R30.\nM99\n");
  bench.start("G51 X0 Y0 P2000000\nM96 P13\nG0 X1.\nX2.\nM30\n");
  ASSERT_EQ(bench.next(), Pull::operation);
  ASSERT_TRUE(bench.interpreter.interrupt({}));
  EXPECT_EQ(bench.alarm_of_run(), "PS1101");
}

// What stands behind M00, an M code of No.3411…3432 or G53 is read when the machine has come so far.
TEST(Macro, NothingIsReadAheadOfCodesThatStopTheLookAhead) {
  for (const char* held : {"M00", "M61", "M85", "G53 X0"}) {
    Bench bench;
    Running environment;
    bench.data.parameters["3411"] = 61;
    bench.data.parameters["3421"] = 80;
    bench.data.parameters["3422"] = 90;
    bench.interpreter.set_environment(&environment);
    bench.start(std::string("G0 X1.\n") + held + "\n#100=1\nG0 X2.\nM30\n");
    ASSERT_EQ(bench.next(), Pull::operation);
    ASSERT_EQ(bench.next(), Pull::operation) << held;
    EXPECT_EQ(bench.next(), Pull::standstill) << held;
    EXPECT_FALSE(bench.data.common_variables.contains(100)) << held;
    EXPECT_EQ(bench.next(), Pull::operation) << held;
    EXPECT_TRUE(bench.data.common_variables.contains(100)) << held;
  }
  Bench bench;
  Running environment;
  bench.interpreter.set_environment(&environment);
  bench.start("G0 X1.\nM61\n#100=1\nG0 X2.\nM30\n");
  ASSERT_EQ(bench.next(), Pull::operation);
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_EQ(bench.next(), Pull::operation);  // not one of them: read on
}

TEST(Macro, NamesOutliveTheController) {
  Bench bench;
  bench.start("SETVN 510[DEPTH]\nM30\n");
  while (bench.next() == Pull::operation) {
  }
  ASSERT_EQ(bench.data.variable_names.at(510), "DEPTH");
  Bench later;
  later.data.variable_names = bench.data.variable_names;
  later.interpreter.reset({});
  later.start("[#DEPTH]=3\nG0 X#510\nM30\n");
  ASSERT_EQ(later.next(), Pull::operation);
  EXPECT_EQ(motion(later.operation)->end_work[0], 3.0);
}

// 2000TC CLV: 0 leaves the main program's locals as they are at RESET, 1 clears them; 0i-D always clears.
TEST(Macro, LocalsOutliveResetWhereTheParameterSaysSo) {
  const auto second_run = [](std::string_view profile, double clear) {
    Bench bench(profile);
    bench.data.parameters["S173.1"] = clear;
    bench.start("O1\n#1=5\nM30\n");
    while (bench.next() == Pull::operation) {
    }
    bench.interpreter.reset({});
    bench.start("O1\nG00 X1. Z#1\nM30\n");
    EXPECT_EQ(bench.next(), Pull::operation);
    return motion(bench.operation)->axes;
  };
  EXPECT_NE(second_run("gsk-2000tc", 0), second_run("gsk-2000tc", 1));
  EXPECT_EQ(second_run("fanuc-0i-t", 0), second_run("fanuc-0i-t", 1));
}

// Ports of 200T and K2000TC: read when they are true, unknown where nothing is connected.
struct Unconnected final : macro::Environment {
  bool takes_time() const override { return true; }
  bool has_signals() const override { return false; }
};

TEST(Macro, PortsAreReadAtAStandstillOrNotAtAll) {
  struct Control {
    const char *profile, *program;
    unsigned port;
  };
  for (const Control& control : {Control{"k2000tc", "O1\nG00 X1.\n#1=#1003\nG00 X[#1+5]\nM30\n", 3},
                                 Control{"lathe-200t", "G00 X1\nG65 H01 P#200 Q#3\nG00 X#200\nM02\n", 3}}) {
    Bench bench(control.profile);
    Running environment;
    bench.interpreter.set_environment(&environment);
    bench.start(control.program);
    ASSERT_EQ(bench.next(), Pull::operation) << control.profile;
    ASSERT_EQ(bench.next(), Pull::standstill) << control.profile;
    environment.set_input(control.port, true);
    ASSERT_EQ(bench.next(), Pull::operation) << control.profile;
    EXPECT_EQ(motion(bench.operation)->end_work[0], control.port == 3 && control.profile[0] == 'k' ? 6.0 : 1.0);

    Bench loose(control.profile);
    Unconnected nothing;
    loose.interpreter.set_environment(&nothing);
    loose.start(control.program);
    EXPECT_NE(loose.alarm_of_run(100), "none") << control.profile;
  }
}

constexpr const char* kRestarted =
    "O1\nG90 G54 G0 X1. M3 S500\nT2\n#500=#500+1\n#1=0\nWHILE[#1 LT 5]DO1\n#1=#1+1\nN10 G1 X#1 F100.\nY#1\nEND1\n"
    "N20 G91 Z-1.\nM30\n";

TEST(Restart, FromASequenceNumberWithItsModalState) {
  Bench bench;
  bench.data.common_variables[500] = 7;
  bench.text = kRestarted;
  RestartPoint point;
  point.sequence = 10;
  point.occurrence = 3;
  ASSERT_EQ(bench.interpreter.restart(program::source_from_text(bench.text), {}, point), Pull::operation);
  const RestartState& state = bench.interpreter.restart_state();
  EXPECT_EQ(state.position[0], 2.0);
  EXPECT_EQ(state.position[1], 2.0);
  EXPECT_EQ(state.tool, 2);
  EXPECT_EQ(state.spindle, 500);
  EXPECT_EQ(bench.data.common_variables.at(500), 7);  // not counted a second time
  ASSERT_EQ(bench.next(), Pull::operation);
  ASSERT_TRUE(std::holds_alternative<Feed>(bench.operation));
  EXPECT_EQ(motion(bench.operation)->end_work[0], 3.0);
}

TEST(Restart, FromABlockNumberGivesTheSameRest) {
  Bench whole;
  whole.start(kRestarted);
  std::vector<Operation> all;
  while (whole.next() == Pull::operation) all.push_back(whole.operation);
  for (std::size_t from = 1; from < all.size(); ++from) {
    const Motion* expected = motion(all[from]);
    const auto block_of = [](const Operation& op) { return std::visit([](const auto& o) { return o.at.block; }, op); };
    if (expected == nullptr || block_of(all[from - 1]) == expected->at.block) continue;
    Bench bench;
    bench.text = kRestarted;
    RestartPoint point;
    point.block = expected->at.block;
    ASSERT_EQ(bench.interpreter.restart(program::source_from_text(bench.text), {}, point), Pull::operation);
    for (std::size_t i = from; i < all.size(); ++i) {
      ASSERT_EQ(bench.next(), Pull::operation) << from;
      if (motion(bench.operation) == nullptr && motion(all[i]) == nullptr) continue;
      ASSERT_NE(motion(all[i]), nullptr);
      ASSERT_NE(motion(bench.operation), nullptr);
      EXPECT_EQ(motion(bench.operation)->end_machine, motion(all[i])->end_machine) << from << ' ' << i;
      EXPECT_EQ(motion(bench.operation)->at.block, motion(all[i])->at.block);
    }
  }
}

// Where the path is displaced, or a corner waits for its next block, the axes would begin beside it.
TEST(Restart, NotInsideCompensationOrAtAChamfer) {
  for (const char* text : {"O1\nG90 G54 G0 X0\nG41 D1 G1 X5. Y5. F100\nN10 X20.\nG40 X30.\nM30\n",
                           "O1\nG90 G54 G0 X0\nG1 X5. F100 ,C1.\nN10 Y20.\nM30\n"}) {
    Bench bench;
    bench.data.tools.resize(2);
    bench.data.tools[1].radius = 2;
    bench.text = text;
    RestartPoint point;
    point.sequence = 10;
    ASSERT_EQ(bench.interpreter.restart(program::source_from_text(bench.text), {}, point), Pull::finished) << text;
    EXPECT_EQ(bench.alarm_of_run(), "PS0412") << text;
  }
}

// A machine on which time passes: a restart does not wait for a standstill that nothing brings about.
TEST(Restart, PassesWhatLooksAtTheMachine) {
  Bench bench;
  Running environment;
  bench.interpreter.set_environment(&environment);
  bench.text = "O1\nG90 G0 X1.\nM00\n#1=#5021\nG53 X0\nN10 X7.\nM30\n";
  RestartPoint point;
  point.sequence = 10;
  ASSERT_EQ(bench.interpreter.restart(program::source_from_text(bench.text), {}, point), Pull::operation);
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_EQ(motion(bench.operation)->end_work[0], 7.0);
}

TEST(Restart, ABlockThatIsNotThereIsAnAlarm) {
  Bench bench;
  bench.text = kRestarted;
  RestartPoint point;
  point.sequence = 99;
  ASSERT_EQ(bench.interpreter.restart(program::source_from_text(bench.text), {}, point), Pull::finished);
  EXPECT_EQ(bench.alarm_of_run(), "PS0078");
}

// A profile is read before it is cut: what would have to wait for the machine in it is an alarm, not a wait
// for ever.
TEST(Macro, ASignalInsideAProfileIsAnAlarm) {
  Bench bench("fanuc-0i-t");
  Running environment;
  bench.interpreter.set_environment(&environment);
  bench.start(
      "G98 M03 S100\nG00 X60. Z5.\nG71 U2. R1.\nG71 P1 Q3 U2. W1. F100\nN1 G00 X20.\nN2 G01 Z-[20+#1000]\nN3 "
      "X50.\n"
      "M30\n");
  const std::string code = bench.alarm_of_run(1'000);
  EXPECT_TRUE(code.starts_with("PS")) << code;
}

// A dialect that reads its text itself is given the block it begins with as it stands in the program.
TEST(Restart, InALanguageOfItsOwn) {
  for (const char* profile : {"lathe-200t", "k2000tc"}) {
    Bench bench(profile);
    bench.text = "G00 X1.\nG00 X2.\nG00 X3.\nM02\n";
    RestartPoint point;
    point.block = 3;
    ASSERT_EQ(bench.interpreter.restart(program::source_from_text(bench.text), {}, point), Pull::operation)
        << profile;
    ASSERT_EQ(bench.next(), Pull::operation) << profile;
    ASSERT_NE(motion(bench.operation), nullptr) << profile;
    EXPECT_EQ(motion(bench.operation)->end_work[0], 3) << profile;
    EXPECT_EQ(motion(bench.operation)->at.line, 3u) << profile;
  }
}

// The blocks between P and Q belong to their cycle: a restart there is refused, and comes to its end.
TEST(Restart, ABlockOfAProfileIsNoPlaceToBegin) {
  for (const bool by_number : {true, false}) {
    Bench bench("fanuc-0i-t");
    bench.text =
        "G98 M03 S100\nG00 X60. Z5.\nG71 U2. R1.\nG71 P1 Q3 U2. W1. F100\nN1 G00 X20.\nN2 G01 Z-20.\nN3 "
        "X50.\nM30\n";
    RestartPoint point;
    if (by_number) {
      point.block = 6;
    } else {
      point.sequence = 2;
    }
    ASSERT_EQ(bench.interpreter.restart(program::source_from_text(bench.text), {}, point), Pull::finished);
    EXPECT_EQ(bench.alarm_of_run(), "PS0078");
  }
}

}  // namespace
}  // namespace headstock::interp

// One part from cycle start to the count on disk.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"

namespace headstock::operation {
namespace {

const char* const kPart =
    "O1\nG21 G90 G94 G17\nG00 X10. Y10. Z-5.\nM03 S1000\nG01 X50. F1000.\nG02 X60. Y20. I0. J10.\nG01 Y50.\n"
    "G04 P500\nM08\nG01 X10. Y10.\nM09\nM05\nM30\n%\n";

// Nothing could break in: better no motion than a program that waits for a signal which cannot come.
TEST(Interruption, IsRefusedBeforeAnythingMoves) {
  Bench bench;
  bench.programs->texts["O13"] = "O13\nG01 Z1. F50\nM99\n";
  bench.load("G90 G0\nM96 P13\nX1.\nM97\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm));
  EXPECT_EQ(bench.controller.sample().position[0], 0);
  ASSERT_FALSE(bench.controller.live().alarms.empty());
  EXPECT_EQ(bench.controller.live().alarms[0].code, "HS0002");
}

TEST(Cycle, APartIsCountedOnceAndOnlyWhenItIsOnDisk) {
  Bench bench;
  bench.load(kPart);
  ASSERT_TRUE(bench.start());
  EXPECT_EQ(bench.state(), State::running);
  bench.committing = false;
  ASSERT_TRUE(bench.until([&] { return bench.controller.retained().parts == 1; }));
  for (int i = 0; i < 2000; ++i) bench.period();
  EXPECT_EQ(bench.state(), State::running) << "M30 is not finished while the count is not committed";
  EXPECT_FALSE(bench.start());
  bench.commit();
  ASSERT_TRUE(bench.until_state(State::idle, 1));
  bench.commit();

  const auto counted = bench.all<PartCounted>();
  ASSERT_EQ(counted.size(), 1u);
  EXPECT_EQ(counted[0].count, 1u);
  EXPECT_EQ(counted[0].program, "O1");
  EXPECT_EQ(counted[0].revision_hash, "hash-O1");
  EXPECT_GT(counted[0].cycle_s, 1);
  const auto ended = bench.all<RunEnded>();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].outcome, "completed");
  EXPECT_EQ(ended[0].run, bench.all<RunStarted>().at(0).run);
  EXPECT_GT(ended[0].cutting_s, 0);
  EXPECT_GT(ended[0].run_s, ended[0].cutting_s);
}

TEST(Cycle, TenPartsCountTen) {
  Bench bench;
  bench.load(kPart);
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until_state(State::idle));
  }
  bench.commit();
  EXPECT_EQ(bench.all<PartCounted>().size(), 10u);
  EXPECT_EQ(bench.controller.live().parts, 10u);
}

// M901 of 200T: the count begins anew where the machine has come so far (L4689).
TEST(Cycle, AnMCodeClearsTheCount) {
  Bench bench("lathe-200t");
  bench.load("G00 X1\nM02\n");
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until_state(State::idle));
  }
  EXPECT_EQ(bench.controller.live().parts, 3u);
  bench.load("G00 X2\nM901\nG00 X1\nM02\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.retained().parts == 0; }));
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_EQ(bench.controller.live().parts, 1u);
}

TEST(Cycle, ResetWhileTheCountIsBeingWrittenKeepsTheOneCount) {
  Bench bench;
  bench.load(kPart);
  ASSERT_TRUE(bench.start());
  bench.committing = false;
  ASSERT_TRUE(bench.until([&] { return bench.controller.retained().parts == 1; }));
  bench.press(Action::reset);
  bench.committing = true;
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  for (int i = 0; i < 100; ++i) bench.period();
  EXPECT_EQ(bench.all<PartCounted>().size(), 1u);
  EXPECT_EQ(bench.controller.live().parts, 1u);
}

TEST(Cycle, TheAxesStandWhereTheProgramSays) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\nG01 X12.5 Y-7.25 F2000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle));
  const Live live = bench.controller.live();
  EXPECT_NEAR(live.machine[0], 12.5, 1e-9);
  EXPECT_NEAR(live.machine[1], -7.25, 1e-9);
  EXPECT_EQ(bench.controller.sample().moving, false);
}

TEST(Cycle, DwellTakesItsTimeExactly) {
  Bench bench;
  bench.load("O1\nG04 X2.5\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle));
  const double cycle_s = bench.controller.live().last_cycle_s;
  EXPECT_NEAR(cycle_s, 2.5, 0.010);
}

TEST(Cycle, WhatIsShownIsWhatMoves) {
  // The block shown must be the one whose segment the commanded position lies on, at every period.
  Bench bench;
  std::string program = "O1\nG90 G94 G21\n";  // block N<i> (line i+2) goes to X = i
  for (int i = 1; i <= 60; ++i)
    program += "N" + std::to_string(i) + " G01 X" + std::to_string(i) + ". F3000.\n";
  bench.load(program + "M30\n");
  ASSERT_TRUE(bench.start());
  int seen = 0;
  while (bench.state() == State::running) {
    bench.period();
    const Live live = bench.controller.live();
    if (live.at.line < 3 || live.at.line > 62 || !bench.controller.sample().moving) continue;
    const int block = static_cast<int>(live.at.line) - 2;
    const double x = bench.controller.sample().position[0];
    ASSERT_GE(x, block - 1 - 0.02) << "block " << block;
    ASSERT_LE(x, block + 0.02) << "block " << block;
    EXPECT_EQ(live.block, "N" + std::to_string(block) + " G01 X" + std::to_string(block) + ". F3000.");
    EXPECT_EQ(live.at.sequence, static_cast<std::uint32_t>(block));
    EXPECT_NEAR(live.absolute[0], x, 1e-9);
    EXPECT_GE(live.distance_to_go[0], -0.02);
    ++seen;
  }
  EXPECT_GT(seen, 500);
}

TEST(Cycle, ProgressGrowsToTheEnd) {
  Bench bench;
  bench.load(kPart);
  ASSERT_TRUE(bench.start());
  double last = 0;
  while (bench.state() == State::running) {
    bench.period();
    const double progress = bench.controller.live().progress;
    if (bench.state() != State::running) break;
    ASSERT_GE(progress, last - 1e-12);
    ASSERT_LE(progress, 1);
    last = progress;
  }
  EXPECT_GT(last, 0.8);
}

TEST(Cycle, SurfaceSpeedFollowsTheDiameter) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-t");
  machine.axes[0].reference_mm = 100;
  Bench bench(machine);
  bench.load(
      "O1\nG21 G99\nG50 S3000\nG96 S200 M03\nG00 X100. Z0.\nG04 X3.\nG01 X40. F0.3\nG04 X2.\nM05\nM30\n");
  ASSERT_TRUE(bench.start());
  bool at_100 = false, at_40 = false;
  while (bench.state() == State::running) {
    bench.period();
    const Live live = bench.controller.live();
    if (bench.controller.sample().moving || live.spindle_commanded_rpm == 0) continue;
    if (live.at.line == 6) at_100 |= std::abs(live.spindle_commanded_rpm - 200'000 / (M_PI * 100)) < 1;
    if (live.at.line == 8) at_40 |= std::abs(live.spindle_commanded_rpm - 200'000 / (M_PI * 40)) < 1;
  }
  EXPECT_TRUE(at_100);
  EXPECT_TRUE(at_40);
}

TEST(Cycle, TwoControllersMakeTheSameSamplesBitForBit) {
  std::vector<AxisVector> runs[2];
  for (auto& run : runs) {
    Bench bench;
    bench.load("O1\nG90 G94 G21\nG01 X20. F4000.\nX20. Y10.\nG03 X0. Y10. I-10. J0.\nG01 X0. Y0.\nM30\n");
    ASSERT_TRUE(bench.start());
    while (bench.state() == State::running) {
      bench.period();
      run.push_back(bench.controller.sample().position);
    }
  }
  EXPECT_GT(runs[0].size(), 1000u);
  EXPECT_TRUE(runs[0] == runs[1]);
}

TEST(Cycle, AnAlarmOfTheProgramLetsTheMotionBeforeItFinish) {
  Bench bench;
  bench.load("O1\nG90 G94 G21\nG01 X30. F3000.\nG01 X40. Q1 G777\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm));
  const Live live = bench.controller.live();
  EXPECT_NEAR(live.machine[0], 30, 1e-9);
  ASSERT_EQ(live.alarms.size(), 1u);
  EXPECT_EQ(live.alarms[0].code, "PS0010");
  EXPECT_EQ(live.alarms[0].at.line, 4u);
  EXPECT_FALSE(live.alarms[0].text_en.empty());
  EXPECT_FALSE(live.alarms[0].text_zh.empty());
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "alarm");
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  bench.commit();
  ASSERT_EQ(bench.all<AlarmRaised>().size(), 1u);
  EXPECT_EQ(bench.all<AlarmRaised>()[0].block, "G01 X40. Q1 G777");
  EXPECT_EQ(bench.all<AlarmCleared>().size(), 1u);
  EXPECT_EQ(bench.all<RunEnded>().at(0).outcome, "alarm");
  EXPECT_TRUE(bench.all<PartCounted>().empty());
}

// G04 ends the look-ahead of the K2000TC (L5382), but a profile is read whole before it is roughed.
TEST(Cycle, AProfileMayDwell) {
  Bench bench("k2000tc");
  bench.load(
      "O1\nG98 G00 X50. Z2.\nG71 U2. R1.\nG71 P10 Q20 U0.5 W0.2 F200.\nN10 G00 X20.\nG01 Z-20. F100.\nG04 "
      "P100\n"
      "X40. Z-30.\nN20 X50.\nG70 P10 Q20\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.state() != State::running; }));
  EXPECT_EQ(bench.state(), State::idle);
}

}  // namespace
}  // namespace headstock::operation

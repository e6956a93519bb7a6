// Drip-feed: a program that comes while it runs.
#include <gtest/gtest.h>

#include "bench.hpp"

namespace headstock::operation {
namespace {

std::shared_ptr<Feeder> zigzag(int blocks) {
  auto feeder = std::make_shared<Feeder>();
  feeder->text = "O5\nG90 G94 G21\nG01 F3000.\n";
  for (int i = 1; i <= blocks; ++i)
    feeder->text += "X" + std::to_string(i % 2 ? 5 : 0) + ". Y" + std::to_string(i * 0.1).substr(0, 5) + "\n";
  feeder->text += "M30\n%\n";
  return feeder;
}

void select(Bench& bench, const std::shared_ptr<Feeder>& feeder) {
  const auto result = bench.controller.select_stream("drip.nc", "h", std::make_unique<FedSource>(feeder),
                                                     feeder->text.size());
  ASSERT_TRUE(result.accepted) << result.reason;
}

TEST(Drip, RunsWhileItComes) {
  Bench bench;
  const auto feeder = zigzag(100);
  feeder->released = 400;
  select(bench, feeder);
  EXPECT_EQ(bench.controller.live().mode, Mode::remote);
  ASSERT_TRUE(bench.start());
  while (bench.state() == State::running) {
    bench.period();
    feeder->released += 2;  // faster than it is used up
    feeder->closed = feeder->released >= feeder->text.size();
  }
  EXPECT_EQ(bench.state(), State::idle);
  EXPECT_NEAR(bench.controller.sample().position[1], 10, 1e-9);
  EXPECT_EQ(bench.controller.live().parts, 1u);
  EXPECT_EQ(bench.press(Action::cycle_start).reason, "no_program") << "a stream runs once";
}

TEST(Drip, DataThatRunOutAreAHoldThatNobodyButAPersonEnds) {
  Bench bench;
  const auto feeder = zigzag(100);
  feeder->released = feeder->text.size() / 2;
  select(bench, feeder);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::hold, 120));
  bench.period();
  EXPECT_FALSE(bench.controller.sample().moving);
  Live live = bench.controller.live();
  ASSERT_EQ(live.alarms.size(), 1u);
  EXPECT_TRUE(live.alarms[0].message);
  const AxisVector held = bench.controller.sample().position;

  for (int i = 0; i < 1000; ++i) bench.period();
  EXPECT_EQ(bench.controller.live().alarms.size(), 1u) << "said once, however long it lasts";

  // The data come: still nothing moves.
  feeder->released = feeder->text.size();
  feeder->closed = true;
  for (int i = 0; i < 5000; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position, held);
  EXPECT_EQ(bench.state(), State::hold);

  ASSERT_TRUE(bench.start());
  EXPECT_TRUE(bench.controller.live().alarms.empty());
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_NEAR(bench.controller.sample().position[1], 10, 1e-9);
  EXPECT_EQ(bench.controller.live().parts, 1u);
  EXPECT_EQ(bench.all<AlarmRaised>().size(), 1u);
  EXPECT_EQ(bench.all<AlarmCleared>().size(), 1u);
}

TEST(Drip, EveryBlockOnceWhateverThePiecesAre) {
  for (const std::size_t piece : {1u, 3u, 7u, 64u, 1000u}) {
    Bench bench;
    const auto feeder = zigzag(40);
    select(bench, feeder);
    std::vector<std::uint32_t> lines;
    bench.controller.on_operation([&](const interp::Operation& operation) {
      if (const auto* feed = std::get_if<interp::Feed>(&operation)) lines.push_back(feed->at.line);
    });
    ASSERT_TRUE(bench.start());
    for (int i = 0; i < 400'000 && bench.state() != State::idle; ++i) {
      if (i % 2 == 0) feeder->released = std::min(feeder->released + piece, feeder->text.size());
      feeder->closed = feeder->released == feeder->text.size();
      bench.period();
      if (bench.state() == State::hold) bench.start();  // the person
    }
    ASSERT_EQ(bench.state(), State::idle) << piece;
    ASSERT_EQ(lines.size(), 40u) << piece;
    for (std::size_t i = 0; i < lines.size(); ++i) EXPECT_EQ(lines[i], i + 4) << piece;
    EXPECT_EQ(bench.controller.live().parts, 1u);
  }
}

TEST(Drip, TwoSecondsWithoutDataAreNothingToAFullBuffer) {
  Bench bench;
  const auto feeder = zigzag(4'000);
  // The agent's buffer ahead of the cut: 8,000 bytes are some seconds of these blocks.
  constexpr std::size_t kBuffer = 8'000;
  select(bench, feeder);
  feeder->released = kBuffer;
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.live().at.line > 50; }));
  const auto stalled = static_cast<std::uint64_t>(2e6 / bench.controller.machine().period_us);
  const auto line = bench.controller.live().at.line;
  for (std::uint64_t i = 0; i < stalled; ++i) {
    bench.period();
    ASSERT_TRUE(bench.controller.sample().moving) << "the axes never stand, period " << i;
  }
  EXPECT_GT(bench.controller.live().at.line, line + 2);
  EXPECT_EQ(bench.state(), State::running);
  feeder->released = feeder->text.size();
  feeder->closed = true;
  ASSERT_TRUE(bench.until([&] { return bench.controller.live().at.line > line + 500; }));
  EXPECT_TRUE(bench.all<AlarmRaised>().empty());
}

/// Runs a program that comes from outside and breaks off with `fault` behind its last released byte.
std::string code_of_fault(const std::string& profile, const std::string& fault) {
  Bench bench(profile);
  const auto feeder = std::make_shared<Feeder>();
  feeder->text = "O5\nG98\nG01 Z-5. F1000.\nZ-10.\nZ-3";
  feeder->released = feeder->text.size();
  feeder->broken = true;
  const auto selected =
      bench.controller.select_stream("DNC", "", std::make_unique<FedSource>(feeder), 0, Origin::panel, [&] { return fault; });
  EXPECT_TRUE(selected.accepted);
  EXPECT_TRUE(bench.start());
  EXPECT_TRUE(bench.until_state(State::alarm, 60)) << profile;
  bench.until([&] { return !bench.controller.sample().moving; }, 5);
  const std::size_t z = *bench.controller.machine().axis_index('Z');
  EXPECT_NEAR(bench.controller.sample().position[z], -10, 1e-9) << "whole blocks only: half a Z word is not a position";
  const auto alarms = bench.controller.live().alarms;
  EXPECT_EQ(alarms.size(), 1u);
  EXPECT_EQ(bench.press(Action::cycle_start).accepted, false);
  return alarms.empty() ? "" : alarms[0].code;
}

TEST(Drip, AFaultOfTheLineIsTheControllersAlarmAfterTheLastGoodBlock) {
  EXPECT_EQ(code_of_fault("fanuc-0i-m", "line_parity"), "PS0085");
  EXPECT_EQ(code_of_fault("fanuc-0i-t", "line_overrun"), "PS0085");
  EXPECT_EQ(code_of_fault("fanuc-0i-m", "line_framing"), "PS1823");
  EXPECT_EQ(code_of_fault("fanuc-0i-m", "buffer_overflow"), "PS0087");
  EXPECT_EQ(code_of_fault("fanuc-0i-m", "disconnected"), "PS0086");
  EXPECT_EQ(code_of_fault("fanuc-0i-m", "th"), "PS0001");
  EXPECT_EQ(code_of_fault("fanuc-0i-m", "tv"), "PS0002");
  EXPECT_EQ(code_of_fault("gsk-218t", "line_parity"), "032");
  EXPECT_EQ(code_of_fault("fanuc-0i-m", "no_start_mark"), "HS0041");
  EXPECT_EQ(code_of_fault("fanuc-0i-m", "closed_by_server"), "PS0086") << "not of a line: the dialect's own input alarm";
}

std::string code_of_program(const std::string& block) {
  Bench bench;
  bench.programs->texts["O1234"] = "O1234\nM99\n";
  const auto feeder = std::make_shared<Feeder>();
  feeder->text = "O5\nG01 X1. F1000.\n" + block + "\nX2.\nM30\n%\n";
  feeder->released = feeder->text.size();
  feeder->closed = true;
  select(bench, feeder);
  EXPECT_TRUE(bench.start());
  EXPECT_TRUE(bench.until([&] { return bench.state() == State::alarm || bench.state() == State::idle; }, 60));
  const auto alarms = bench.controller.live().alarms;
  return alarms.empty() ? "" : alarms[0].code;
}

TEST(Drip, WhatIsForbiddenInAProgramThatIsFedFromOutside) {
  EXPECT_EQ(code_of_program("GOTO 10"), "PS0123");
  EXPECT_EQ(code_of_program("WHILE [#1 LT 3] DO1"), "PS0123");
  EXPECT_EQ(code_of_program("M198 P1234"), "PS0210") << "0i-D L29963";
  EXPECT_EQ(code_of_program("IF [#1 EQ 1] THEN #2=3"), "") << "a statement that jumps nowhere may stand there";
}

TEST(Drip, NoDataAtAllAfterCycleStartIsAHoldTooNotALateStart) {
  Bench bench;
  const auto feeder = zigzag(10);
  select(bench, feeder);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::hold, 5));
  feeder->released = feeder->text.size();
  feeder->closed = true;
  for (int i = 0; i < 3000; ++i) bench.period();
  EXPECT_EQ(bench.controller.sample().position[0], 0);
}

TEST(Drip, ResetDropsTheStream) {
  Bench bench;
  const auto feeder = zigzag(100);
  feeder->released = feeder->text.size() / 2;
  select(bench, feeder);
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 500; ++i) bench.period();
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  EXPECT_EQ(feeder.use_count(), 1) << "the source is given back";
}

}  // namespace
}  // namespace headstock::operation

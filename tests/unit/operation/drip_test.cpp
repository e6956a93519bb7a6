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

// G63 (0i-D 5.4): the feed override is 100 % and feed hold waits for the end of the mode.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/operation/bench.hpp"

namespace headstock::operation {
namespace {

constexpr const char* kPart = "O1\nG90 G94 G21 G54\nG63 G01 X20. F600.\nG64 X40.\nM30\n";

TEST(TappingMode, TheFeedOverrideDoesNotAct) {
  Bench bench;
  bench.load(kPart);
  bench.press(Action::set_feed_override, 0.5);
  ASSERT_TRUE(bench.start());
  double inside = 0, behind = 0;
  ASSERT_TRUE(bench.until([&] {
    const motion::Sample& now = bench.controller.sample();
    double& fastest = now.position[0] < 18 ? inside : behind;
    if (now.position[0] < 18 || now.position[0] > 25) fastest = std::max(fastest, std::abs(now.velocity[0]));
    return bench.state() == State::idle;
  }));
  EXPECT_NEAR(inside, 10, 0.01);
  EXPECT_NEAR(behind, 5, 0.01);
}

TEST(TappingMode, FeedHoldWaitsForItsEnd) {
  Bench bench;
  bench.load(kPart);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 5; }));
  bench.press(Action::feed_hold);
  ASSERT_TRUE(bench.until_state(State::hold));
  ASSERT_TRUE(bench.until([&] { return !bench.controller.sample().moving; }));
  EXPECT_GE(bench.controller.sample().position[0], 20 - 1e-6);
  EXPECT_LT(bench.controller.sample().position[0], 25);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle));
  EXPECT_EQ(bench.controller.sample().position[0], 40);
}

}  // namespace
}  // namespace headstock::operation

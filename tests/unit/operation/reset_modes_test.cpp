// What RESET leaves of the modes: those of blocks that have been carried out, not those that were read ahead
// (0i-D K.32.1).
#include <gtest/gtest.h>

#include <algorithm>

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

}  // namespace
}  // namespace headstock::operation

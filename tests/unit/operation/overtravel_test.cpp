// Soft limits on lines and arcs for every profile: the axes never pass, the alarm is the controller's own.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"

namespace headstock::operation {
namespace {

struct Case {
  const char* profile;
  const char* program;
  const char* code;
  char axis;
  bool positive;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.profile << ' ' << c.code << ' ' << c.axis;
}

class Overtravel : public testing::TestWithParam<Case> {};

TEST_P(Overtravel, StopsBeforeTheLimitWithTheControllersAlarm) {
  const Case& c = GetParam();
  machine::Machine machine = *machine::default_machine(c.profile);
  for (auto& axis : machine.axes) {
    axis.min_mm = -50;
    axis.max_mm = 50;
    axis.reference_mm = 0;
  }
  Bench bench(machine);
  bench.load(c.program);
  ASSERT_TRUE(bench.start());
  double furthest = 0;
  while (bench.state() == State::running && bench.periods < 100'000) {
    bench.period();
    for (std::size_t i = 0; i < machine.axes.size(); ++i)
      furthest = std::max(furthest, std::abs(bench.controller.sample().position[i]));
  }
  EXPECT_LE(furthest, 50.0) << "an axis passed its limit";
  ASSERT_EQ(bench.state(), State::alarm);
  const Live live = bench.controller.live();
  ASSERT_EQ(live.alarms.size(), 1u);
  EXPECT_EQ(live.alarms[0].code, c.code);
  EXPECT_EQ(live.alarms[0].at.line, 4u);
  EXPECT_NE(live.alarms[0].text_en, c.code);
  EXPECT_NE(live.alarms[0].text_zh, c.code);
  const std::size_t axis = *machine.axis_index(c.axis);
  EXPECT_NEAR(live.machine[axis], c.positive ? 49.999 : -49.999, 1e-6) << "as far as permitted";

  // Cleared by reset; a move back is then possible.
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  EXPECT_TRUE(bench.controller.live().alarms.empty());
  bench.load("O1\nG00 X0. Z0.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_NEAR(bench.controller.sample().position[*machine.axis_index('Z')], 0, 1e-9);
}

// Line 4 passes the limit. On lathes X is a diameter: X120. is 60 mm of slide.
INSTANTIATE_TEST_SUITE_P(
    Profiles, Overtravel,
    testing::Values(
        Case{"fanuc-0i-m", "O1\nG90 G94 G21\nG01 X10. Y0. F3000.\nX60.\nM30\n", "OT0500", 'X', true},
        Case{"fanuc-0i-m", "O1\nG90 G94 G21\nG01 X10. Y0. F3000.\nY-70.\nM30\n", "OT0501", 'Y', false},
        Case{"fanuc-0i-m", "O1\nG90 G94 G21\nG00 X0. Y0.\nG00 Z-80.\nM30\n", "OT0501", 'Z', false},
        Case{"fanuc-0i-m", "O1\nG90 G94 G21 G17\nG01 X30. Y-30. F3000.\nG03 X30. Y30. I0. J30.\nM30\n",
             "OT0500", 'X', true},
        Case{"fanuc-0i-t", "O1\nG21 G98\nG01 X10. Z0. F3000.\nX120.\nM30\n", "OT0500", 'X', true},
        Case{"fanuc-0i-t", "O1\nG21 G98\nG01 X60. Z-40. F1000.\nG02 X60. Z40. R40.1\nM30\n", "OT0500", 'X',
             true},
        Case{"gsk-2000tc", "O1\nG21 G98\nG01 X10. Z0. F3000.\nX-120.\nM30\n", "202", 'X', false},
        Case{"gsk-218t", "O1\nG21 G98\nG01 X10. Z0. F3000.\nZ60.\nM30\n", "203", 'Z', true},
        Case{"k2000tc", "O1\nG21 G98\nG01 X10. Z0. F3000.\nZ-60.\nM30\n", "OT0501", 'Z', false},
        Case{"lathe-200t", "G00 X10 Z0\nG01 X12 F1000\nG01 X14 F1000\nG01 Z60 F1000\nM02\n", "A10", 'Z',
             true}));

}  // namespace
}  // namespace headstock::operation

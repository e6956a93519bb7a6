// Interpolators at the machine: where a programmed path becomes another one of the slides (polar, cylinder),
// or changes its radius (spiral), or goes the shorter way round (roll-over), the limits of the physical axes
// hold in every period. And the cutting modes that change what the operator may do (G63).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

machine::Machine with_c(const std::string& profile) {
  machine::Machine machine = *machine::default_machine(profile);
  machine::Axis c;
  c.name = 'C';
  c.rotary = true;
  c.rapid_mm_min = 7'200;
  c.max_feed_mm_min = 3'600;  // 60 degrees a second
  c.max_acceleration_mm_s2 = 600;
  c.max_jerk_mm_s3 = 30'000;
  c.min_mm = -1e5;
  c.max_mm = 1e5;
  machine.axes.push_back(c);
  return machine;
}

void set_values(Bench& bench, std::map<std::string, double> values) {
  ASSERT_TRUE(bench.controller
                  .edit_data(
                      [&](interp::MachineData& data) {
                        for (const auto& [number, value] : values) data.parameters[number] = value;
                      },
                      {}, "test")
                  .accepted);
}

// 0.1 mm past the centre the rotary axis would have to turn 180 degrees in a moment: it does so at its own
// rate, and the path in the plane stays what was programmed.
TEST(PolarInterpolation, LimitsOfTheRotaryAxisHoldNearTheCentre) {
  Bench bench(with_c("fanuc-0i-t"));
  const std::size_t c = 2;
  bench.load("O1\nG98 G21\nG00 X40. C0\nG12.1\nG01 C0.1 F2000.\nX-40.\nC10.\nX40.\nG13.1\nM30\n");
  ASSERT_TRUE(bench.start());
  LimitsOnBench limits(bench);
  double fastest_c = 0, nearest = 1e9, off = 0;
  ASSERT_TRUE(limits.until(
      [&] {
        const auto& sample = bench.controller.sample();
        const double x = sample.position[0] * std::cos(sample.position[c] * kDegree);
        const double y = sample.position[0] * std::sin(sample.position[c] * kDegree);
        fastest_c = std::max(fastest_c, std::abs(sample.velocity[c]));
        const std::uint32_t line = bench.controller.traced_block().line;
        if (line == 6 && sample.moving) {
          nearest = std::min(nearest, std::hypot(x, y));
          if (x > -19.9 && x < 19.9) off = std::max(off, std::abs(y - 0.1));
        }
        return bench.state() != State::running && bench.periods > 100;
      },
      300));
  EXPECT_EQ(bench.state(), State::idle);
  limits.expect_inside();
  EXPECT_LT(nearest, 0.12) << "it went past the centre";
  EXPECT_GT(fastest_c, 55) << "and the rotary axis was at its rate there";
  EXPECT_LE(fastest_c, 60 * 1.001) << "of cutting, not of positioning";
  EXPECT_LT(off, 0.02);
}

TEST(PolarInterpolation, ThroughTheCentreTheAxisTurnsOnTheSpotInsideItsLimits) {
  Bench bench(with_c("fanuc-0i-t"));
  bench.load("O1\nG98 G21\nG00 X40. C0\nG12.1\nG01 X-40. F1000.\nG13.1\nM30\n");
  ASSERT_TRUE(bench.start());
  LimitsOnBench limits(bench);
  double least = 1e9;
  ASSERT_TRUE(limits.until(
      [&] {
        least = std::min(least, bench.controller.sample().position[0]);
        return bench.state() != State::running && bench.periods > 100;
      },
      300));
  EXPECT_EQ(bench.state(), State::idle);
  limits.expect_inside();
  EXPECT_GE(least, -0.011) << "the slide does not cross the centre";
  EXPECT_NEAR(std::abs(bench.controller.sample().position[2]), 180, 0.01);
}

TEST(CylindricalInterpolation, LimitsOfTheRotaryAxisHoldOnTheUnrolledPath) {
  Bench bench(with_c("fanuc-0i-m"));
  set_values(bench, {{"1022/C", 5}});
  // On a small cylinder a fast cut is a fast turn: 3000 mm/min on a radius of 10 mm would be 286 degrees/s.
  bench.load(
      "O1\nG21 G94 G00 G90 Z-10. C0\nG01 G91 G18 Z0 C0\nG07.1 C10.\nG90 G01 Z-20. F3000.\nC30.\nG03 Z-22. "
      "C42. R12.\n"
      "G01 Z-40.\nC0\nG07.1 C0\nM30\n");
  ASSERT_TRUE(bench.start());
  LimitsOnBench limits(bench);
  double fastest_c = 0, most_c = 0;
  ASSERT_TRUE(limits.until(
      [&] {
        fastest_c = std::max(fastest_c, std::abs(bench.controller.sample().velocity[3]));
        most_c = std::max(most_c, bench.controller.sample().position[3]);
        return bench.state() != State::running && bench.periods > 100;
      },
      300));
  EXPECT_EQ(bench.state(), State::idle)
      << (bench.controller.live().alarms.empty() ? "" : bench.controller.live().alarms.front().code);
  limits.expect_inside();
  EXPECT_NEAR(most_c, 42, 0.02);
  EXPECT_GT(fastest_c, 59);
  EXPECT_LE(fastest_c, 60 * 1.001);
}

// Start and end radius differ by what No. 3410 permits: the radius changes evenly with the angle.
TEST(Spiral, TheRadiusChangesEvenlyWithTheAngleAndLimitsHold) {
  Bench bench("fanuc-0i-m");
  set_values(bench, {{"3410", 5}});
  bench.load("O1\nG21 G94 G90 G17\nG00 X20. Y0. Z0.\nG03 X-23. Y0. I-20. J0. F6000.\nM30\n");
  ASSERT_TRUE(bench.start());
  LimitsOnBench limits(bench);
  double worst = 0;
  int seen = 0;
  ASSERT_TRUE(limits.until(
      [&] {
        const auto& at = bench.controller.sample().position;
        if (bench.controller.cutting() && bench.controller.sample().moving) {
          const double angle = std::atan2(at[1], at[0]), radius = std::hypot(at[0], at[1]);
          worst = std::max(worst, std::abs(radius - (20 + 3 * angle / std::numbers::pi)));
          ++seen;
        }
        return bench.state() != State::running && bench.periods > 100;
      },
      60));
  EXPECT_EQ(bench.state(), State::idle)
      << (bench.controller.live().alarms.empty() ? "" : bench.controller.live().alarms.front().code);
  limits.expect_inside();
  EXPECT_GT(seen, 500);
  EXPECT_LT(worst, bench.controller.machine().tolerance_mm);
  EXPECT_EQ(bench.controller.sample().position[0], -23);
}

// 0i-D roll-over (No. 1008#0 ROA, #1 RAB = 0): an absolute command goes the shorter way round and the page
// shows 0…360; an incremental one goes as far as it says.
TEST(RollOver, AbsoluteCommandsGoTheShorterWayRoundAndThePageStaysInOneTurn) {
  Bench bench(with_c("fanuc-0i-m"));
  set_values(bench, {{"1008#0/C", 1}, {"1008#2/C", 1}, {"1006#0/C", 1}});
  const auto ends_at = [&](const std::string& block, double degrees, double shown) {
    bench.load("O1\nG21 G94\n" + block + "\nM30\n", "O" + std::to_string(10 + bench.events.size()));
    ASSERT_TRUE(bench.start());
    LimitsOnBench limits(bench);
    ASSERT_TRUE(limits.until([&] { return bench.state() != State::running && bench.periods > 100; }, 60));
    limits.expect_inside();
    EXPECT_NEAR(bench.controller.sample().position[3], degrees, 1e-9) << block;
    EXPECT_NEAR(bench.controller.live().absolute[3], shown, 1e-6) << block;
  };
  ends_at("G90 G00 C350.", -10, 350);
  ends_at("G90 G00 C10.", 10, 10);
  ends_at("G91 G00 C370.", 380, 20);
  ends_at("G90 G00 C200.", 560, 200);
  ends_at("G90 G01 C190. F1000.", 550, 190);
}

// The axes know where they are when the agent starts: no reference return, and the limits hold at once.
TEST(AbsoluteEncoder, ProgramsMoveAtOnceAndAnAxisWithoutOneDoesNot) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.axes[1].homing = machine::Homing::dog;
  Bench bench(machine);
  EXPECT_EQ(bench.controller.live().homed & 7, 5u);
  bench.load("O1\nG90 G94 G21\nG01 X5. F3000.\nY5.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 20));
  EXPECT_EQ(bench.controller.live().alarms.front().code, "PS0224");
  EXPECT_EQ(bench.controller.sample().position[0], 5);
  EXPECT_EQ(bench.controller.sample().position[1], 0);
  // And the limit of the axis that knows its place holds before any reference return.
  ASSERT_TRUE(bench.press(Action::reset).accepted);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  bench.load("O2\nG90 G94 G21\nG01 X99999. F3000.\nM30\n", "O2");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 600));
  EXPECT_LE(bench.controller.sample().position[0], machine.axes[0].max_mm);
}

// G63: the feed is as programmed whatever the override says, and feed hold waits for the end of the block.
TEST(TappingMode, OverrideAndFeedHoldDoNotActUnderG63) {
  Bench bench("fanuc-0i-m");
  bench.load("O1\nG90 G94 G21\nG63\nG01 Z-20. F600.\nG64\nZ-30.\nM30\n");
  ASSERT_TRUE(bench.start());
  bench.press(Action::set_feed_override, 0.5);
  LimitsOnBench limits(bench);
  ASSERT_TRUE(limits.until([&] { return bench.controller.sample().position[2] < -5; }, 20));
  EXPECT_NEAR(bench.controller.sample().path_speed_mm_s, 10, 0.01);
  bench.press(Action::feed_hold);
  for (int i = 0; i < 500; ++i) limits.period();
  EXPECT_NEAR(bench.controller.sample().path_speed_mm_s, 10, 0.01) << "it goes on to its end";
  ASSERT_TRUE(limits.until([&] { return !bench.controller.sample().moving; }, 20));
  for (int i = 0; i < 200; ++i) limits.period();
  EXPECT_LE(bench.controller.sample().position[2], -20 + 1e-9);
  EXPECT_GT(bench.controller.sample().position[2], -21) << "and then it holds";
  EXPECT_EQ(bench.state(), State::hold);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(limits.until([&] { return bench.controller.sample().position[2] < -25; }, 20));
  EXPECT_NEAR(bench.controller.sample().path_speed_mm_s, 5, 0.01) << "G64: the override acts again";
  ASSERT_TRUE(limits.until([&] { return bench.state() == State::idle; }, 20));
  limits.expect_inside();
}

// An emergency stop lets the synchronous axes part; afterwards the slave is brought back slowly.
TEST(SynchronousAxes, AreBroughtTogetherAgainAfterAnEmergencyStop) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine::Axis slave = machine.axes[1];
  slave.name = 'V';
  slave.follows = 'Y';
  machine.axes.push_back(slave);
  auto made = std::make_unique<axes::SimulatedDrive>(machine);
  axes::SimulatedDrive* drive = made.get();
  ControllerOptions options;
  options.drive = std::move(made);
  options.now_ms = [] { return std::int64_t{0}; };
  Bench bench(machine, std::move(options));
  bench.load("O1\nG90 G94 G21\nG01 Y-50. F3000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[1] < -10; }, 20));
  bench.press(Action::emergency_stop);
  ASSERT_TRUE(bench.until([&] { return !bench.controller.sample().moving; }, 5));
  for (int i = 0; i < 200; ++i) bench.period();
  drive->push(3, 0.2);  // without power the slave sinks
  for (int i = 0; i < 50; ++i) bench.period();
  ASSERT_TRUE(bench.press(Action::emergency_stop_release).accepted);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  const double apart = bench.controller.sample().position[3] - bench.controller.sample().position[1];
  EXPECT_NEAR(apart, 0.2, 0.02) << "nothing jumps when the drives come on";
  LimitsOnBench limits(bench);
  double fastest = 0;
  for (int i = 0; i < 1500; ++i) {
    const double before = bench.controller.sample().position[3];
    limits.period();
    fastest = std::max(fastest, std::abs(bench.controller.sample().position[3] - before) / 0.001);
  }
  limits.expect_inside();
  EXPECT_LE(fastest, 1.001) << "slowly: 1 mm/s";
  EXPECT_NEAR(bench.controller.sample().position[3], bench.controller.sample().position[1], 1e-9);
  EXPECT_EQ(bench.state(), State::idle);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 60));
  EXPECT_EQ(bench.controller.sample().position[3], -50);
}

}  // namespace
}  // namespace headstock::operation

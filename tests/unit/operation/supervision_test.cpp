// Supervision inside the controller: what happens, which alarm, and how the machine comes back. And the
// emergency stop by its own deceleration.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

struct ServoBench {
  explicit ServoBench(machine::Machine machine)
      : ServoBench(machine, std::make_unique<axes::SimulatedDrive>(machine)) {}
  ServoBench(const machine::Machine& machine, std::unique_ptr<axes::SimulatedDrive> made)
      : drive(made.get()), bench(machine, options(std::move(made))) {}
  static ControllerOptions options(std::unique_ptr<axes::Drive> drive) {
    ControllerOptions made;
    made.drive = std::move(drive);
    made.now_ms = [] { return std::int64_t{0}; };
    return made;
  }
  std::string alarm() {
    const auto alarms = bench.controller.live().alarms;
    return alarms.empty() ? std::string() : alarms.front().code;
  }
  axes::SimulatedDrive* drive;
  Bench bench;
};

TEST(FollowingError, AJammedSlideStopsTheMachineWithTheControllersAlarm) {
  struct Case {
    const char* profile;
    const char* program;
    std::size_t axis;
    const char* code;
  };
  for (const Case& test : {Case{"fanuc-0i-m", "O1\nG90 G94 G21\nG01 X50. F3000.\nM30\n", 0, "SV0411"},
                           Case{"gsk-2000tc", "O1\nG98\nG01 Z-80. F3000.\nM30\n", 1, "222"},
                           Case{"gsk-218t", "O1\nG98\nG01 X-60. F3000.\nM30\n", 0, "221"},
                           Case{"k2000tc", "O1\nG98\nG01 Z-80. F3000.\nM30\n", 1, "HS0020"},
                           Case{"lathe-200t", "G98\nG01 Z-80 F3000\nM02\n", 1, "A14"}}) {
    ServoBench servo(*machine::default_machine(test.profile));
    Bench& bench = servo.bench;
    bench.load(test.program);
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until([&] { return std::abs(bench.controller.sample().position[test.axis]) > 5; }, 20))
        << test.profile;
    servo.drive->jam(test.axis, true);
    ASSERT_TRUE(bench.until_state(State::alarm, 5)) << test.profile;
    EXPECT_EQ(servo.alarm(), test.code) << test.profile;
    EXPECT_EQ(bench.press(Action::cycle_start).reason, "alarm");
    servo.drive->jam(test.axis, false);
    for (int i = 0; i < 500; ++i) bench.period();
    const double stood = bench.controller.live().machine[test.axis];
    ASSERT_TRUE(bench.press(Action::reset).accepted);
    ASSERT_TRUE(bench.until_state(State::idle, 5));
    for (int i = 0; i < 300; ++i) bench.period();
    EXPECT_NEAR(bench.controller.live().machine[test.axis], stood, 1e-3) << "RESET moves nothing";
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until([&] { return bench.state() != State::running; }, 60));
    EXPECT_EQ(bench.state(), State::idle) << servo.alarm();
  }
}

TEST(FollowingError, APushedSlideAtRestIsSeenWithoutAnyProgram) {
  ServoBench servo(*machine::default_machine("fanuc-0i-m"));
  Bench& bench = servo.bench;
  for (int i = 0; i < 500; ++i) bench.period();
  servo.drive->jam(1, true);
  servo.drive->push(1, 0.7);
  ASSERT_TRUE(bench.until_state(State::alarm, 2));
  EXPECT_EQ(servo.alarm(), "SV0410");
  servo.drive->jam(1, false);
  for (int i = 0; i < 500; ++i) bench.period();
  EXPECT_NEAR(bench.controller.live().machine[1], 0.7, 1e-3) << "the drives are off: it is not driven back";
}

TEST(FollowingError, SynchronousAxesThatPart) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine::Axis slave = machine.axes[1];
  slave.name = 'V';
  slave.follows = 'Y';
  machine.axes.push_back(slave);
  ServoBench servo(machine);
  Bench& bench = servo.bench;
  bench.load("O1\nG90 G94 G21\nG01 Y-50. F3000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[1] < -10; }, 20));
  EXPECT_EQ(bench.controller.sample().position[3], bench.controller.sample().position[1]);
  servo.drive->jam(3, true);
  ASSERT_TRUE(bench.until_state(State::alarm, 5));
  EXPECT_EQ(servo.alarm(), "SV0005");
  bench.press(Action::reset);
  servo.drive->jam(3, false);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  LimitsOnBench limits(bench);
  for (int i = 0; i < 3000; ++i) limits.period();
  limits.expect_inside();
  EXPECT_EQ(bench.state(), State::idle) << "what they have parted is taken away slowly";
  EXPECT_NEAR(bench.controller.live().machine[3], bench.controller.live().machine[1], 1e-3);
  bench.load("O2\nG90 G94 G21\nG01 V5. F3000.\nM30\n", "O2");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 5));
  EXPECT_EQ(servo.alarm(), "PS0213") << "no program commands the slave";
}

TEST(Fluctuation, G26StopsTheMachineWithOH0704) {
  Bench bench("fanuc-0i-t");
  bench.load("O1\nG98 G21 G97\nG26 P1000 Q5 R10\nM03 S1000\nG01 Z-50. F300.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[1] < -2; }, 20));
  bench.controller.spindle().load(0.93);
  for (int i = 0; i < 300; ++i) bench.period();
  EXPECT_EQ(bench.state(), State::running) << "7 % is allowed";
  bench.controller.spindle().load(0.85);
  ASSERT_TRUE(bench.until_state(State::alarm, 1));
  EXPECT_EQ(bench.controller.live().alarms.front().code, "OH0704");
  EXPECT_FALSE(bench.controller.sample().moving && bench.controller.sample().path_speed_mm_s > 5);
  ASSERT_TRUE(bench.until([&] { return !bench.controller.sample().moving; }, 2));
  bench.controller.spindle().load(1);
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  bench.load("O2\nG98 G21 G97\nG26 P1000 Q5 R10\nG25\nM03 S1000\nG01 Z-20. F300.\nM30\n", "O2");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[1] < -10; }, 20));
  bench.controller.spindle().load(0.5);
  ASSERT_TRUE(bench.until_state(State::idle, 60)) << "G25 has ended the supervision";
}

TEST(EmergencyStop, EveryAxisBrakesByItsOwnDecelerationBeforeTheDrivesGoOff) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.axes[0].emergency_deceleration_mm_s2 = 4'000;
  machine.axes[1].emergency_deceleration_mm_s2 = 3'000;
  Bench bench(machine);
  bench.load("O1\nG90 G94 G21\nG01 X80. Y40. F6000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 30; }, 20));
  const AxisVector v = bench.controller.sample().velocity, from = bench.controller.sample().position;
  EXPECT_GT(v[0], 80);
  bench.press(Action::emergency_stop, 0, Origin::network);
  AxisVector last = from, last_v = v;
  for (int i = 0; i < 200; ++i) {
    bench.period();
    const AxisVector& now = bench.controller.sample().position;
    for (std::size_t k = 0; k < 2; ++k) {
      const double speed = (now[k] - last[k]) / 1e-3;
      ASSERT_LE(std::abs(speed - last_v[k]) / 1e-3, machine.axes[k].emergency_deceleration_mm_s2 * 1.01) << i;
      last_v[k] = speed;
      last[k] = now[k];
    }
  }
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(last[k] - from[k], v[k] * v[k] / 2 / machine.axes[k].emergency_deceleration_mm_s2,
                v[k] * 2e-3);
  EXPECT_EQ(bench.state(), State::emergency_stop);
  EXPECT_FALSE(bench.controller.sample().moving);
}

TEST(EmergencyStop, WhatMovesTheAxesWhileTheDrivesAreOffIsTakenUp) {
  ServoBench servo(*machine::default_machine("fanuc-0i-m"));
  Bench& bench = servo.bench;
  bench.press(Action::emergency_stop);
  for (int i = 0; i < 300; ++i) bench.period();
  servo.drive->push(2, -3);  // the head sinks
  for (int i = 0; i < 100; ++i) bench.period();
  ASSERT_TRUE(bench.press(Action::emergency_stop_release).accepted);
  ASSERT_TRUE(bench.until_state(State::idle, 2));
  for (int i = 0; i < 300; ++i) bench.period();
  EXPECT_NEAR(bench.controller.live().machine[2], -3, 1e-4) << "nothing jumps back";
  bench.load("O1\nG90 G94 G21\nG01 Z-1. F1000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  EXPECT_NEAR(bench.controller.live().machine[2], -1, 0.025);
}

TEST(StrokeChecks, TheThirdIsABoxFromTheParameters) {
  Bench bench("fanuc-0i-m");
  bench.controller.edit_data(
      [](interp::MachineData& data) {
        for (const char axis : {'X', 'Y'}) {
          data.parameters[std::string("1324/") + axis] = 60;
          data.parameters[std::string("1325/") + axis] = 40;
        }
      },
      {}, "test");
  bench.load("O1\nG90 G94 G21\nG01 X20. Y20. F3000.\nX80. Y80.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 20));
  EXPECT_EQ(bench.controller.live().alarms.front().code, "OT0504");
  EXPECT_EQ(bench.controller.sample().position[0], 20) << "the block is not begun";
}

TEST(StrokeChecks, BeforeMoveNothingOfTheBlockIsRun) {
  Bench bench("fanuc-0i-m");
  bench.controller.edit_data([](interp::MachineData& data) { data.parameters["1301#7"] = 1; }, {}, "test");
  bench.load("O1\nG90 G94 G21\nG01 X20. F3000.\nX90000.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 20));
  EXPECT_EQ(bench.controller.live().alarms.front().code, "OT0510");
  EXPECT_EQ(bench.controller.sample().position[0], 20);
}

TEST(AxisLock, TheDriveKeepsItsPlaceAndIsTakenUpThere) {
  Bench bench("fanuc-0i-m");
  bench.load("O1\nG90 G94 G21\nG01 X10. Z-15. F3000.\nM30\n");
  EXPECT_EQ(bench.press(Action::set_axis_lock, 4, Origin::network).reason, "panel_only");
  ASSERT_TRUE(bench.press(Action::set_axis_lock, 4).accepted);  // Z
  ASSERT_TRUE(bench.start());
  EXPECT_EQ(bench.press(Action::set_axis_lock, 0).reason, "running");
  ASSERT_TRUE(bench.until_state(State::idle, 20));
  EXPECT_NEAR(bench.controller.live().machine[2], -15, 1e-9) << "shown";
  EXPECT_EQ(bench.controller.live().axis_lock, 4u);
  ASSERT_TRUE(bench.press(Action::set_axis_lock, 0).accepted);
  ASSERT_TRUE(
      bench.until([&] { return bench.controller.live().axis_lock == 0 && bench.state() == State::idle; }, 2));
  EXPECT_NEAR(bench.controller.live().machine[0], 10, 1e-9);
  EXPECT_NEAR(bench.controller.live().machine[2], 0, 1e-9) << "it never left its place";
}

}  // namespace
}  // namespace headstock::operation

#include "axes/drive.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "axes/spindle.hpp"

namespace headstock::axes {
namespace {

TEST(SimulatedDrive, LagsBySpeedOverGainAndSettlesOnTheTarget) {
  const machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  SimulatedDrive drive(machine);
  AxisVector command = drive.actual();
  const double from = command[0];
  const double speed_mm_s = 50, period_s = machine.period_us * 1e-6;
  for (int i = 0; i < 1000; ++i) {
    command[0] += speed_mm_s * period_s;
    drive.command(command);
  }
  EXPECT_NEAR(drive.following_error()[0], speed_mm_s / machine.axes[0].position_gain_per_s, 0.05);
  double overshoot = 0;
  for (int i = 0; i < 2000; ++i) {
    drive.command(command);
    overshoot = std::max(overshoot, drive.actual()[0] - command[0]);
  }
  EXPECT_NEAR(drive.actual()[0], from + 50, 1e-6);
  EXPECT_LT(overshoot, 1e-3);
}

TEST(SimulatedDrive, WithoutPowerItBrakesAndIgnoresCommands) {
  const machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  SimulatedDrive drive(machine);
  AxisVector command = drive.actual();
  for (int i = 0; i < 500; ++i) {
    command[0] += 0.1;
    drive.command(command);
  }
  drive.enable(false);
  for (int i = 0; i < 500; ++i) {
    command[0] += 0.1;
    drive.command(command);
  }
  const double stopped = drive.actual()[0];
  drive.command(command);
  EXPECT_NEAR(drive.actual()[0], stopped, 1e-9);
  EXPECT_LT(stopped, command[0] - 40);
  // Power again: it stands still until it is commanded elsewhere.
  drive.enable(true);
  for (int i = 0; i < 100; ++i) drive.command(drive.actual());
  EXPECT_NEAR(drive.actual()[0], stopped, 1e-6);
}

TEST(SimulatedDrive, TorqueAndInertiaBoundTheAcceleration) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.axes[0].torque_reserve = 1.5;
  machine.axes[0].inertia_ratio = 3;
  SimulatedDrive drive(machine);
  AxisVector command = drive.actual();
  command[0] += 20;  // a step: more than any motor can follow
  double last = 0, last_v = 0, most = 0;
  for (int i = 0; i < 3000; ++i) {
    drive.command(command);
    const double v = (drive.actual()[0] - last) / 1e-3;
    most = std::max(most, std::abs(v - last_v) / 1e-3);
    last = drive.actual()[0];
    last_v = v;
  }
  EXPECT_LE(most, machine.axes[0].max_acceleration_mm_s2 * 1.5 / 3 * 1.001);
  EXPECT_GT(most, machine.axes[0].max_acceleration_mm_s2 * 1.5 / 3 * 0.9);
  EXPECT_NEAR(drive.actual()[0], 20, 1e-3);
}

TEST(SimulatedDrive, FrictionHoldsWhatTheMotorDoesNotOvercome) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.axes[0].friction_mm_s2 = 300;
  SimulatedDrive drive(machine);
  AxisVector command = drive.actual();
  command[0] += 0.005;  // 50/s × 600/s × 0.005 mm = 150 mm/s²: less than the friction
  for (int i = 0; i < 500; ++i) drive.command(command);
  EXPECT_EQ(drive.actual()[0], 0);
  command[0] += 0.1;
  for (int i = 0; i < 2000; ++i) drive.command(command);
  EXPECT_NEAR(drive.actual()[0], command[0], 300.0 / 50 / 600 + 1e-3);
  EXPECT_GT(drive.actual()[0], 0.08);
}

TEST(SimulatedDrive, TheEncoderMeasuresInItsSteps) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.axes[1].encoder_um = 5;
  SimulatedDrive drive(machine);
  AxisVector command = drive.actual();
  for (int i = 0; i < 400; ++i) {
    command[1] += 0.0013;
    drive.command(command);
    const double steps = drive.actual()[1] / 0.005;
    ASSERT_NEAR(steps, std::round(steps), 1e-6);
  }
}

TEST(SimulatedDrive, ThePulseGearPutsItOnWholePulses) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.axes[0].gear_numerator = 1;
  machine.axes[0].gear_denominator = 10;  // 0.01 mm a pulse
  SimulatedDrive drive(machine);
  AxisVector command = drive.actual();
  command[0] = 1.2345;
  for (int i = 0; i < 2000; ++i) drive.command(command);
  EXPECT_NEAR(drive.actual()[0], 1.23, 1e-6);
}

TEST(SimulatedDrive, ANewNameForWhereItStandsMovesNothing) {
  SimulatedDrive drive(*machine::default_machine("fanuc-0i-m"));
  drive.place(0, 37);
  EXPECT_EQ(drive.actual()[0], 0);
  AxisVector called{};
  called[0] = -5;
  drive.set_position(called);
  EXPECT_EQ(drive.actual()[0], -5);
  EXPECT_NEAR(drive.true_position(0), 37, 1e-12);
}

TEST(RecorderDrive, KeepsTheFirstSetPointsInOrderAndFollowsIdeally) {
  RecorderDrive drive(3);
  for (int i = 1; i <= 5; ++i) {
    drive.command({0.1 * i});
    EXPECT_EQ(drive.actual()[0], 0.1 * i);
  }
  ASSERT_EQ(drive.record().size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(drive.record()[static_cast<std::size_t>(i)][0], 0.1 * (i + 1));
  drive.enable(false);
  drive.command({9});
  EXPECT_EQ(drive.actual()[0], 0.5) << "without power it stays";
}

TEST(SimulatedSpindle, ItsRampIsRoundedAndItsStopIsForeseen) {
  machine::Spindle data;
  data.acceleration_rpm_s = 2000;
  SimulatedSpindle spindle(data, 0.001);
  spindle.command(1500);
  double last = 0, last_change = 0, sharpest = 0;
  for (int i = 0; i < 1000; ++i) {
    spindle.step();
    sharpest = std::max(sharpest, std::abs(spindle.rpm() - last - last_change));
    last_change = spindle.rpm() - last;
    last = spindle.rpm();
  }
  EXPECT_EQ(spindle.rpm(), 1500);
  EXPECT_LT(sharpest, 2000 * 0.001 / 25) << "no jump of the torque";
  const double foreseen = spindle.stopping_angle_rad(), from = spindle.phase_rad();
  spindle.command(0);
  while (!spindle.stands()) spindle.step();
  EXPECT_LE(spindle.phase_rad() - from, foreseen * 1.001);
  EXPECT_GT(spindle.phase_rad() - from, foreseen * 0.97);
}

TEST(SimulatedSpindle, RampsAndTurns) {
  machine::Spindle data;
  data.acceleration_rpm_s = 1000;
  SimulatedSpindle spindle(data, 0.001);
  spindle.command(-600);
  EXPECT_FALSE(spindle.at_speed());
  for (int i = 0; i < 640; ++i) spindle.step();
  EXPECT_NEAR(spindle.rpm(), -600, 1e-6);
  EXPECT_TRUE(spindle.at_speed());
  const double before = spindle.phase_rad();
  for (int i = 0; i < 100; ++i) spindle.step();
  EXPECT_NEAR(spindle.phase_rad() - before, -2 * std::numbers::pi, 1e-9);  // 600 rpm: one turn in 0.1 s
}

}  // namespace
}  // namespace headstock::axes

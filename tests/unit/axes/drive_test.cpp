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

// Backlash, pitch error, inclined and synchronous axes between the program and the motors.
#include "axes/mechanics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "axes/electronic_gear.hpp"
#include "motion/limits_check.hpp"

namespace headstock::axes {
namespace {

machine::Machine mill_with_screws() {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.period_us = 1000;
  return machine;
}

TEST(Mechanics, WithoutErrorsMotorsDoWhatTheAxesDo) {
  Mechanics mechanics(mill_with_screws(), 0.001);
  AxisVector axes{1.5, -2, 3};
  EXPECT_EQ(mechanics.to_motors(axes), axes);
  EXPECT_EQ(mechanics.to_axes(axes), axes);
}

TEST(Mechanics, BacklashIsTakenUpOnceOnEachReversalAndSmoothly) {
  machine::Machine machine = mill_with_screws();
  machine.axes[0].backlash_um = 12;
  Mechanics mechanics(machine, 0.001);
  motion::LimitsCheck extra(1, 0.001);
  AxisVector axes{};
  mechanics.set_position(axes);
  const auto run = [&](double by_mm, int periods) {
    for (int i = 0; i < periods; ++i) {
      axes[0] += by_mm;
      const AxisVector motors = mechanics.to_motors(axes);
      EXPECT_NEAR(mechanics.to_axes(motors)[0], axes[0], 1e-12) << "the screen does not show the play";
      extra.add(mechanics.compensation());
    }
  };
  run(0.01, 300);
  EXPECT_EQ(mechanics.compensation()[0], 0) << "positive is the side of reference return";
  run(-0.01, 300);
  EXPECT_NEAR(mechanics.compensation()[0], -0.012, 1e-12);
  run(0, 300);
  EXPECT_NEAR(mechanics.compensation()[0], -0.012, 1e-12) << "standing is no reversal";
  run(0.01, 300);
  EXPECT_NEAR(mechanics.compensation()[0], 0, 1e-12);
  // Smoothly: no more than half of the axis' acceleration and jerk beside the motion itself.
  EXPECT_GT(extra.max_velocity()[0], 0);
  EXPECT_LE(extra.max_acceleration()[0], 0.5 * machine.axes[0].max_acceleration_mm_s2 * 1.01);
  EXPECT_LE(extra.max_jerk()[0], 0.5 * machine.axes[0].max_jerk_mm_s3 * 1.05);
}

TEST(Mechanics, PitchErrorIsTakenAwayLinearBetweenThePoints) {
  machine::Machine machine = mill_with_screws();
  machine.axes[1].pitch_error = {{-100, 4}, {0, 0}, {100, -10}};
  Mechanics mechanics(machine, 0.001);
  AxisVector axes{};
  for (const auto& [at, error_um] :
       {std::pair{-200.0, 4.0}, {-50.0, 2.0}, {0.0, 0.0}, {25.0, -2.5}, {500.0, -10.0}}) {
    axes[1] = at;
    EXPECT_NEAR(mechanics.to_motors(axes)[1], at - error_um / 1000, 1e-12) << at;
  }
}

TEST(Mechanics, BidirectionalPitchErrorHasATableForEachDirection) {
  machine::Machine machine = mill_with_screws();
  machine.axes[0].pitch_error = {{0, 0}, {100, 10}};
  machine.axes[0].pitch_error_negative = {{0, 6}, {100, 20}};
  Mechanics mechanics(machine, 0.001);
  AxisVector axes{};
  mechanics.set_position(axes);
  for (int i = 0; i < 500; ++i) {
    axes[0] += 0.1;
    mechanics.to_motors(axes);
  }
  EXPECT_NEAR(mechanics.compensation()[0], -0.005, 1e-12);
  for (int i = 0; i < 400; ++i) {
    axes[0] -= 0.05;
    mechanics.to_motors(axes);
  }
  EXPECT_NEAR(axes[0], 30, 1e-9);
  EXPECT_NEAR(mechanics.compensation()[0], -(0.006 + 0.3 * 0.014), 1e-12);
}

TEST(Mechanics, AnInclinedAxisRunsLongerAndCarriesThePerpendicularOneAlong) {
  machine::Machine machine = mill_with_screws();
  machine.axes[1].inclined_deg = 30;
  machine.axes[1].inclined_to = 'Z';
  Mechanics mechanics(machine, 0.001);
  AxisVector axes{};
  axes[1] = 20;
  axes[2] = 5;
  const AxisVector motors = mechanics.to_motors(axes);
  EXPECT_NEAR(motors[1], 20 / std::cos(std::numbers::pi / 6), 1e-12);
  EXPECT_NEAR(motors[2], 5 - 20 * std::tan(std::numbers::pi / 6), 1e-12);
  const AxisVector back = mechanics.to_axes(motors);
  EXPECT_NEAR(back[1], 20, 1e-12);
  EXPECT_NEAR(back[2], 5, 1e-12);
}

TEST(Mechanics, ASynchronousAxisKeepsItsDistanceFromItsMaster) {
  machine::Machine machine = mill_with_screws();
  machine::Axis slave = machine.axes[1];
  slave.name = 'V';
  slave.follows = 'Y';
  slave.reference_mm = machine.axes[1].reference_mm - 3;
  machine.axes.push_back(slave);
  Mechanics mechanics(machine, 0.001);
  AxisVector axes{};
  axes[1] = -40;
  mechanics.couple(axes);
  EXPECT_EQ(axes[3], -43);
  EXPECT_EQ(mechanics.to_motors(axes)[3], -43);
}

TEST(ElectronicGear, AMillionStepsLeaveNoRounding) {
  const ElectronicGear gear(3, 7);
  double position = 0;
  for (int i = 1; i <= 1'000'000; ++i) position = i * 0.001;
  EXPECT_EQ(gear.pulses(position), std::llround(1'000'000.0 * 3 / 7));
  EXPECT_LE(std::abs(gear.position(position) - position), 0.5 * 7 / 3 / 1000);
  EXPECT_FALSE(ElectronicGear().geared());
  EXPECT_EQ(ElectronicGear().position(0.12345), 0.12345);
}

}  // namespace
}  // namespace headstock::axes

#include "axes/drive.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::axes {
namespace {
// The loops of a servo amplifier run faster than the interpolation; four times keeps the simulation stable up
// to 8 ms.
constexpr int kLoopsAPeriod = 4;
constexpr double kVelocityGain_per_s =
    600;  // 1 / time constant of the velocity loop with the inertia it is tuned for
}  // namespace

double SimulatedDrive::Servo::measured() const noexcept {
  return encoder_mm > 0 ? std::round(position / encoder_mm) * encoder_mm : position;
}

SimulatedDrive::SimulatedDrive(const machine::Machine& machine)
    : axes_(machine.axes.size()), period_s_(machine.period_us * 1e-6) {
  const double loop_s = period_s_ / kLoopsAPeriod;
  for (std::size_t i = 0; i < axes_; ++i) {
    const machine::Axis& axis = machine.axes[i];
    Servo& servo = servo_[i];
    // The velocity loop must not be faster than what one simulated loop can follow.
    servo.velocity_gain_per_s = std::min(kVelocityGain_per_s / axis.inertia_ratio, 0.5 / loop_s);
    servo.position_gain_per_s = std::min(axis.position_gain_per_s, servo.velocity_gain_per_s / 4);
    servo.acceleration_limit = axis.max_acceleration_mm_s2 * axis.torque_reserve / axis.inertia_ratio;
    servo.friction = axis.friction_mm_s2;
    servo.encoder_mm = axis.encoder_um / 1000;
    servo.gear = ElectronicGear(axis.gear_numerator, axis.gear_denominator);
    servo.dog = axis.dog_mm;
    servo.dog_width = axis.dog_width_mm;
    servo.grid = axis.grid_mm;
    servo.position = servo.command = axis.reference_mm;
  }
}

void SimulatedDrive::command(const AxisVector& position) noexcept {
  const double loop_s = period_s_ / kLoopsAPeriod;
  for (std::size_t i = 0; i < axes_; ++i) {
    Servo& servo = servo_[i];
    const double from = servo.command;
    servo.command = enabled_ ? servo.gear.position(position[i]) : servo.position;
    for (int loop = 1; loop <= kLoopsAPeriod; ++loop) {
      // Without power the brake acts: the velocity wanted is zero.
      const double fine = from + (servo.command - from) * loop / kLoopsAPeriod;
      const double velocity_wanted = enabled_ ? (fine - servo.measured()) * servo.position_gain_per_s : 0;
      double acceleration = std::clamp((velocity_wanted - servo.velocity) * servo.velocity_gain_per_s,
                                       -servo.acceleration_limit, servo.acceleration_limit);
      // Friction holds what the motor does not overcome and brakes what moves.
      const double driven = servo.velocity + acceleration * loop_s;
      const double held = servo.friction * loop_s;
      servo.velocity = servo.jammed || std::abs(driven) <= held ? 0 : driven - std::copysign(held, driven);
      servo.position += servo.velocity * loop_s;
    }
  }
}

AxisVector SimulatedDrive::actual() const noexcept {
  AxisVector measured{};
  for (std::size_t i = 0; i < axes_; ++i) measured[i] = servo_[i].measured();
  return measured;
}

void SimulatedDrive::set_position(const AxisVector& position) noexcept {
  for (std::size_t i = 0; i < axes_; ++i) {
    Servo& servo = servo_[i];
    servo.zero += servo.position - position[i];
    servo.command = servo.position = position[i];
    servo.velocity = 0;
  }
}

void SimulatedDrive::place(std::size_t axis, double true_position_mm) noexcept {
  servo_[axis].zero = true_position_mm - servo_[axis].position;
}

bool SimulatedDrive::dog(std::size_t axis) const noexcept {
  return std::abs(true_position(axis) - servo_[axis].dog) <= servo_[axis].dog_width / 2;
}

double SimulatedDrive::way_to_mark(std::size_t axis, double sense) const noexcept {
  const double grid = servo_[axis].grid, turns = true_position(axis) / grid;
  return ((sense > 0 ? std::floor(turns) + 1 : std::ceil(turns) - 1) - turns) * grid;
}

AxisVector SimulatedDrive::following_error() const noexcept {
  AxisVector error{};
  for (std::size_t i = 0; i < axes_; ++i) error[i] = servo_[i].command - servo_[i].position;
  return error;
}

std::unique_ptr<Drive> make_drive(const machine::Machine& machine) {
  if (machine.drive == "ideal") return std::make_unique<IdealDrive>();
  return std::make_unique<SimulatedDrive>(machine);
}

}  // namespace headstock::axes

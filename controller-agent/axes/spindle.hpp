// The simulated spindle: ramps to the commanded speed, turns an encoder, and can be put under position
// control (rigid tapping, orientation, Cs axis). Real-time thread; no allocation.
#pragma once

#include <array>
#include <cstddef>

#include "machine/machine.hpp"

namespace headstock::axes {

class SimulatedSpindle {
 public:
  SimulatedSpindle(const machine::Spindle& spindle, double period_s);

  /// Speed control. @param rpm signed: > 0 turns clockwise (M03).
  void command(double rpm) noexcept;
  /// Position control: be at this angle at the end of the next period. It follows as far as its acceleration
  /// allows; how far it is behind is position_error_rad().
  /// @param gain_per_s of its position loop, so that it lags as a servo axis of that gain does; 0: no lag
  void command_phase(double phase_rad, double gain_per_s = 0) noexcept;
  /// Acceleration in speed control from now on [rpm/s], > 0; 0: the spindle's own.
  void limit_acceleration(double rpm_s) noexcept { acceleration_limit_rpm_s_ = rpm_s; }
  void step() noexcept;

  double commanded_rpm() const noexcept { return commanded_rpm_; }
  double rpm() const noexcept { return rpm_; }
  bool positioned() const noexcept { return position_control_; }
  bool stands() const noexcept { return rpm_ == 0; }
  /// Angle turned since start, not reduced to one turn.
  double phase_rad() const noexcept { return phase_rad_; }
  double position_error_rad() const noexcept {
    return position_control_ ? commanded_phase_rad_ - phase_rad_ : 0;
  }
  /// Angle that it turns through when it is stopped now.
  double stopping_angle_rad() const noexcept;
  /// The speed-arrival signal: within 2 % or 1 rpm of what is commanded.
  bool at_speed() const noexcept;

  // ---- faults, for tests and training
  /// A load changes the speed by this factor (1: none) without the spindle's regulator helping.
  void load(double factor) noexcept { load_ = factor; }

 private:
  static constexpr double kRounding_s =
      0.03;  // the ramp begins and ends softly, as a spindle amplifier makes it
  static constexpr std::size_t kMostPeriods = 128;

  double acceleration_rpm_s_, acceleration_limit_rpm_s_ = 0;
  double period_s_;
  std::size_t periods_;
  std::array<double, kMostPeriods> window_{};
  std::size_t newest_ = 0;
  double ramp_rpm_ = 0;  // before the rounding
  double commanded_rpm_ = 0, rpm_ = 0, phase_rad_ = 0, load_ = 1;
  bool position_control_ = false;
  double commanded_phase_rad_ = 0, gain_per_s_ = 0;
};

}  // namespace headstock::axes

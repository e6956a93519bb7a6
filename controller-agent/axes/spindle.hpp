// The simulated spindle: ramps to the commanded speed and turns an encoder. Real-time thread; no allocation.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "machine/machine.hpp"

namespace headstock::axes {

class SimulatedSpindle {
 public:
  explicit SimulatedSpindle(const machine::Spindle& spindle)
      : acceleration_rpm_s_(spindle.acceleration_rpm_s) {}

  /// @param rpm signed: > 0 turns clockwise (M03).
  void command(double rpm) noexcept { commanded_rpm_ = rpm; }
  void step(double period_s) noexcept {
    const double most = acceleration_rpm_s_ * period_s;
    const double before = rpm_;
    rpm_ += std::clamp(commanded_rpm_ - rpm_, -most, most);
    phase_rad_ += (before + rpm_) / 2 / 60 * 2 * std::numbers::pi * period_s;
  }
  double commanded_rpm() const noexcept { return commanded_rpm_; }
  double rpm() const noexcept { return rpm_; }
  /// Angle turned since start, not reduced to one turn.
  double phase_rad() const noexcept { return phase_rad_; }
  /// The speed-arrival signal: within 2 % or 1 rpm of what is commanded.
  bool at_speed() const noexcept {
    return std::abs(rpm_ - commanded_rpm_) <= std::max(1.0, std::abs(commanded_rpm_) * 0.02);
  }

 private:
  double acceleration_rpm_s_;
  double commanded_rpm_ = 0, rpm_ = 0, phase_rad_ = 0;
};

}  // namespace headstock::axes

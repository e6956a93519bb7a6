#include "axes/spindle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headstock::axes {
namespace {
constexpr double kRadPerRpmSecond = 2 * std::numbers::pi / 60;
}  // namespace

SimulatedSpindle::SimulatedSpindle(const machine::Spindle& spindle, double period_s)
    : acceleration_rpm_s_(spindle.acceleration_rpm_s),
      period_s_(period_s),
      periods_(static_cast<std::size_t>(
          std::clamp(std::ceil(kRounding_s / period_s), 1.0, static_cast<double>(kMostPeriods)))) {}

void SimulatedSpindle::command(double rpm) noexcept {
  if (position_control_) {  // the ramp goes on from the speed it has
    position_control_ = false;
    window_.fill(rpm_);
    ramp_rpm_ = rpm_;
  }
  commanded_rpm_ = rpm;
}

void SimulatedSpindle::command_phase(double phase_rad, double gain_per_s) noexcept {
  gain_per_s_ = gain_per_s;
  position_control_ = true;
  commanded_phase_rad_ = phase_rad;
  commanded_rpm_ = 0;
}

void SimulatedSpindle::step() noexcept {
  const double before = rpm_;
  if (position_control_) {
    // The speed that meets the command, as far as the motor can: without lag it is exact inside its torque;
    // at its end the error shows.
    const double behind = commanded_phase_rad_ - phase_rad_;
    const double even = behind * (gain_per_s_ > 0 ? gain_per_s_ : 1 / period_s_) / kRadPerRpmSecond;
    const double most = acceleration_rpm_s_ * period_s_;
    if (gain_per_s_ == 0 && std::abs(even - rpm_) <= most) {
      rpm_ = even * load_;
      phase_rad_ += behind * load_;
      return;
    }
    rpm_ += std::clamp(even - rpm_, -most, most);
  } else {
    const double most =
        (acceleration_limit_rpm_s_ > 0 ? std::min(acceleration_rpm_s_, acceleration_limit_rpm_s_)
                                       : acceleration_rpm_s_) *
        period_s_;
    ramp_rpm_ += std::clamp(commanded_rpm_ - ramp_rpm_, -most, most);
    newest_ = (newest_ + 1) % periods_;
    window_[newest_] = ramp_rpm_;
    double sum = 0;
    bool even = true;
    for (std::size_t i = 0; i < periods_; ++i) {
      sum += window_[i] - ramp_rpm_;
      even = even && window_[i] == ramp_rpm_;
    }
    rpm_ = (even ? ramp_rpm_ : ramp_rpm_ + sum / static_cast<double>(periods_)) * load_;
  }
  phase_rad_ += (before + rpm_) / 2 * kRadPerRpmSecond * period_s_;
}

double SimulatedSpindle::stopping_angle_rad() const noexcept {
  const double acceleration = acceleration_limit_rpm_s_ > 0
                                  ? std::min(acceleration_rpm_s_, acceleration_limit_rpm_s_)
                                  : acceleration_rpm_s_;
  // The ramp down, and what the rounding still holds back.
  double held = 0;
  for (std::size_t i = 0; i < periods_; ++i) held += window_[i];
  held /= static_cast<double>(periods_);
  const double lag_s = 0.5 * static_cast<double>(periods_) * period_s_;
  const double rpm = std::max(std::abs(held), std::abs(ramp_rpm_));
  return (rpm * rpm / (2 * acceleration) + rpm * (lag_s + period_s_)) * kRadPerRpmSecond;
}

bool SimulatedSpindle::at_speed() const noexcept {
  return std::abs(rpm_ - commanded_rpm_) <= std::max(1.0, std::abs(commanded_rpm_) * 0.02);
}

}  // namespace headstock::axes

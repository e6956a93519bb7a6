#include "axes/drive.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::axes {
namespace {
// The loops of a servo amplifier run faster than the interpolation; four times keeps the simulation stable up
// to 8 ms.
constexpr int kLoopsAPeriod = 4;
}  // namespace

SimulatedDrive::SimulatedDrive(const machine::Machine& machine, const ServoTuning& tuning)
    : tuning_(tuning), axes_(machine.axes.size()), period_s_(machine.period_us * 1e-6) {
  // The velocity loop must not be faster than what one simulated loop can follow.
  const double loop_s = period_s_ / kLoopsAPeriod;
  tuning_.velocity_gain_per_s = std::min(tuning_.velocity_gain_per_s, 0.5 / loop_s);
  tuning_.position_gain_per_s = std::min(tuning_.position_gain_per_s, tuning_.velocity_gain_per_s / 4);
  for (std::size_t i = 0; i < axes_; ++i) {
    acceleration_limit_[i] = machine.axes[i].max_acceleration_mm_s2 * tuning_.torque_reserve;
    position_[i] = command_[i] = machine.axes[i].reference_mm;
  }
}

void SimulatedDrive::command(const AxisVector& position) noexcept {
  const double loop_s = period_s_ / kLoopsAPeriod;
  for (std::size_t i = 0; i < axes_; ++i) {
    const double from = command_[i];
    if (enabled_) command_[i] = position[i];
    if (!enabled_) command_[i] = position_[i];
    for (int loop = 1; loop <= kLoopsAPeriod; ++loop) {
      // Without power the brake acts: the velocity wanted is zero.
      const double fine = from + (command_[i] - from) * loop / kLoopsAPeriod;
      const double velocity_wanted = enabled_ ? (fine - position_[i]) * tuning_.position_gain_per_s : 0;
      const double acceleration = std::clamp((velocity_wanted - velocity_[i]) * tuning_.velocity_gain_per_s,
                                             -acceleration_limit_[i], acceleration_limit_[i]);
      velocity_[i] += acceleration * loop_s;
      position_[i] += velocity_[i] * loop_s;
    }
  }
}

void SimulatedDrive::set_position(const AxisVector& position) noexcept {
  command_ = position_ = position;
  velocity_ = {};
}

AxisVector SimulatedDrive::following_error() const noexcept {
  AxisVector error{};
  for (std::size_t i = 0; i < axes_; ++i) error[i] = command_[i] - position_[i];
  return error;
}

}  // namespace headstock::axes

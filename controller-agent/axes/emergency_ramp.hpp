// Emergency stop: every axis is brought to rest by its own deceleration, on its own, before the drives go off
// (stop category 1). The path is left; what counts is that everything stands soon. Real-time thread.
#pragma once

#include <algorithm>
#include <cmath>

#include "machine/machine.hpp"

namespace headstock::axes {

using machine::AxisVector;

/// An axis without a figure of its own brakes twice as hard as it may accelerate.
inline double emergency_deceleration(const machine::Axis& axis) {
  return axis.emergency_deceleration_mm_s2 > 0 ? axis.emergency_deceleration_mm_s2
                                               : 2 * axis.max_acceleration_mm_s2;
}

class EmergencyRamp {
 public:
  EmergencyRamp(const machine::Machine& machine, double period_s)
      : axes_(machine.axes.size()), period_s_(period_s) {
    for (std::size_t i = 0; i < axes_; ++i) deceleration_[i] = emergency_deceleration(machine.axes[i]);
  }

  void begin(const AxisVector& position, const AxisVector& velocity) noexcept {
    position_ = position;
    velocity_ = velocity;
    active_ = true;
  }
  void end() noexcept { active_ = false; }
  /// @return true when every axis stands
  bool step() noexcept {
    bool stands = true;
    for (std::size_t i = 0; i < axes_; ++i) {
      const double before = velocity_[i], least = deceleration_[i] * period_s_;
      velocity_[i] = std::abs(before) <= least ? 0 : before - std::copysign(least, before);
      position_[i] += velocity_[i] * period_s_;
      stands = stands && velocity_[i] == 0;
    }
    return stands;
  }
  bool active() const noexcept { return active_; }
  const AxisVector& position() const noexcept { return position_; }
  /// The axis is moved by somebody else: it stands here for the ramp.
  void set(std::size_t axis, double position) noexcept {
    position_[axis] = position;
    velocity_[axis] = 0;
  }

 private:
  std::size_t axes_;
  double period_s_;
  AxisVector deceleration_{}, position_{}, velocity_{};
  bool active_ = false;
};

}  // namespace headstock::axes

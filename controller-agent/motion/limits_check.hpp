// Judges commanded samples from outside the kernel: velocity, acceleration and jerk of every axis by finite
// differences.
#pragma once

#include <cstddef>

#include "machine/machine.hpp"

namespace headstock::motion {

using machine::AxisVector;

class LimitsCheck {
 public:
  /// @param period_s between two samples
  LimitsCheck(std::size_t axes, double period_s) : axes_(axes), period_s_(period_s) {}

  /// One period's commanded position. The axes stood at the first one before.
  void add(const AxisVector& position);
  /// Forgets the history, keeps the maxima: the position was set anew (homing, a new work piece of a test).
  void jump() { count_ = 0; }

  /// Largest magnitudes so far: mm/s, mm/s², mm/s³ (degrees for rotary axes).
  const AxisVector& max_velocity() const { return velocity_; }
  const AxisVector& max_acceleration() const { return acceleration_; }
  const AxisVector& max_jerk() const { return jerk_; }

 private:
  std::size_t axes_;
  double period_s_;
  std::size_t count_ = 0;
  AxisVector p1_{}, v1_{}, a1_{};  // previous sample's
  AxisVector velocity_{}, acceleration_{}, jerk_{};
};

}  // namespace headstock::motion

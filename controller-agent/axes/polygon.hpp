// Polygon turning: the tool axis turns with the spindle's encoder in a fixed ratio. It is coupled and let go
// over a smooth ramp inside the axis' limits; between them it keeps its phase to the spindle. Real-time
// thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "machine/machine.hpp"

namespace headstock::axes {

class Polygon {
 public:
  struct Order {
    bool on = false;
    std::size_t axis = 0;
    double ratio = 1;  ///< turns of the tool for one of the spindle; negative: the other way
  };

  Polygon(const machine::Machine& machine, double period_s) : machine_(&machine), period_s_(period_s) {}

  /// @param rpm of the spindle now; the ramp is made for it
  void set(const Order& order, double phase_rad, double rpm) noexcept {
    const std::size_t axis = order.on ? order.axis : order_.axis;
    const double ratio = order.on ? order.ratio : order_.ratio;
    if (order.on) order_ = order;
    order_.on = order.on;
    last_phase_rad_ = phase_rad;
    const machine::Axis& data = machine_->axes[axis];
    const double speed = std::abs(rpm * 6 * ratio), share = 0.9;  // degrees a second
    const double by_acceleration = std::numbers::pi * speed / (2 * share * data.max_acceleration_mm_s2);
    const double by_jerk = std::numbers::pi * std::sqrt(speed / (2 * share * data.max_jerk_mm_s3));
    ramp_s_ = std::max({by_acceleration, by_jerk, period_s_});
  }
  /// Let go at once: the machine is stopped as a whole.
  void drop() noexcept {
    order_.on = false;
    share_ = progress_ = 0;
  }
  void step(double phase_rad) noexcept {
    const double turned = phase_rad - last_phase_rad_;
    last_phase_rad_ = phase_rad;
    const double change = period_s_ / ramp_s_;
    progress_ = std::clamp(progress_ + (order_.on ? change : -change), 0.0, 1.0);
    share_ = 0.5 - 0.5 * std::cos(std::numbers::pi * progress_);
    if (progress_ == 1) share_ = 1;
    if (progress_ == 0) share_ = 0;
    offset_deg_ += share_ * order_.ratio * turned * 180 / std::numbers::pi;
  }
  void clear() noexcept { offset_deg_ = 0; }
  bool moving() const noexcept { return progress_ > 0; }
  /// Coupled in full, or let go in full, as ordered.
  bool settled() const noexcept { return progress_ == (order_.on ? 1 : 0); }
  std::size_t axis() const noexcept { return order_.axis; }
  double offset_deg() const noexcept { return offset_deg_; }

 private:
  const machine::Machine* machine_;
  double period_s_;
  Order order_;
  double last_phase_rad_ = 0, ramp_s_ = 1, progress_ = 0, share_ = 0, offset_deg_ = 0;
};

}  // namespace headstock::axes

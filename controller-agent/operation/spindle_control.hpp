// What the spindle does in a period: speed by M03/M04, constant surface speed with its clamp, orientation,
// the Cs axis, and standing held after a rigid tap. Real-time thread; no allocation.
#pragma once

#include <cstdint>

#include "axes/point_motion.hpp"
#include "axes/spindle.hpp"
#include "machine/machine.hpp"
#include "plc/auxiliary.hpp"

namespace headstock::operation {

class SpindleControl {
 public:
  SpindleControl(const machine::Machine& machine, double period_s);

  struct Wanted {
    double override = 1;
    bool off = false;              ///< emergency stop
    double surface_radius_mm = 0;  ///< distance of the tool from the centre
    double contour_deg = 0;        ///< position of the Cs axis
  };
  /// @param tapping somebody else commands the spindle in this period
  void step(const plc::Outputs& outputs, const Wanted& wanted, bool tapping) noexcept;
  /// A rigid tap is over: stands held until the next order of the ladder.
  void hold_after_tap(std::uint32_t order, double phase_rad, double gain_per_s) noexcept {
    held_order_ = order;
    held_ = true;
    held_phase_rad_ = phase_rad;
    held_gain_per_s_ = gain_per_s;
  }

  axes::SimulatedSpindle& spindle() noexcept { return spindle_; }
  const axes::SimulatedSpindle& spindle() const noexcept { return spindle_; }
  double commanded_rpm() const noexcept { return commanded_rpm_; }
  bool oriented() const noexcept { return state_ == State::oriented; }
  bool contour_ready() const noexcept { return state_ == State::contour; }
  /// The rpm that the ladder's order means at this radius, before the override; ≥ 0.
  double speed_for(const plc::Outputs& outputs, double radius_mm) const noexcept;

 private:
  enum class State : std::uint8_t { speed, stopping, turning, oriented, contour };
  void place(const plc::Outputs& outputs, const Wanted& wanted) noexcept;

  const double max_rpm_, orient_rad_, orient_speed_rad_s_;
  axes::SimulatedSpindle spindle_;
  axes::PointMotion turn_;  // radians
  State state_ = State::speed;
  bool held_ = false;
  std::uint32_t held_order_ = 0;
  double held_phase_rad_ = 0, held_gain_per_s_ = 0;
  double commanded_rpm_ = 0;
  double contour_origin_rad_ = 0, contour_origin_deg_ = 0;
};

}  // namespace headstock::operation

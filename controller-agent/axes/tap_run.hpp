// Tapping with the axis and the spindle in step: in to the bottom, reversed, and out again. Real-time thread.
//
// Rigid: one motion moves the axis inside the limits of both, and the spindle is put at the angle that
// belongs to it; so they stay in step while they speed up, reverse, or are stopped by RESET. Follows: the
// spindle turns by itself (a drive without position control) and the axis goes with its encoder from
// standstill to standstill; the spindle is stopped in time for the bottom.
#pragma once

#include <cstddef>
#include <cstdint>

#include "axes/point_motion.hpp"
#include "axes/spindle.hpp"

namespace headstock::axes {

struct TapOrder {
  std::size_t axis = 0;
  double start = 0, bottom = 0, end = 0;  ///< machine coordinates of the axis [mm]
  double pitch_mm = 0;                    ///< > 0
  double rpm = 0;                         ///< > 0
  int turning = 1;                        ///< inward: 1 clockwise, -1 counter-clockwise
  bool follows = false;                   ///< the axis goes with the spindle's encoder
  double dwell_s = 0;                     ///< at the bottom
  double out_ratio = 1;                ///< speed on the way out over that on the way in, > 0
  bool out_only = false;                  ///< pull-out: the tap is in the hole already
};

class TapRun {
 public:
  TapRun() = default;
  TapRun(const machine::Machine& machine, double period_s);

  /// Precondition: the axis stands at order.start (pull-out: anywhere in the hole).
  void begin(const TapOrder& order, double position) noexcept;
  /// RESET, emergency stop: both brake in step and stay where they are.
  void stop() noexcept;
  /// The drives are off: nothing keeps the step any more.
  void drop() noexcept;
  /// One period: commands the spindle and moves the axis. Call before the spindle's own step.
  /// @param gain_per_s of the axis' position loop: the spindle has to lag as the axis does; 0: neither lags
  void step(SimulatedSpindle& spindle, double gain_per_s) noexcept;
  /// How far the spindle is from where the axis is, as the way of the axis [mm].
  double error_mm(double actual_position, double phase_rad) const noexcept;

  bool running() const noexcept { return phase_ != Phase::off; }
  double position() const noexcept { return position_; }
  std::size_t axis() const noexcept { return order_.axis; }
  /// The tap was stopped in its hole: what pulls it out.
  bool in_hole() const noexcept { return in_hole_; }
  const TapOrder& order() const noexcept { return order_; }
  void forget() noexcept { in_hole_ = false; }
  /// The angle that belongs to where the axis is commanded to be.
  double phase_rad() const noexcept { return phase_of(position_); }
  bool coupled() const noexcept {
    return phase_ != Phase::off && phase_ != Phase::wait && phase_ != Phase::trim;
  }
  /// Deepest the axis has been beyond `bottom` [mm]; 0: never.
  double beyond_mm() const noexcept { return beyond_mm_; }

 private:
  enum class Phase : std::uint8_t { off, wait, in, dwell, out, trim, stopping };

  void step_rigid(SimulatedSpindle& spindle, double gain_per_s) noexcept;
  void step_follows(SimulatedSpindle& spindle) noexcept;
  double inward() const noexcept { return order_.bottom < order_.start ? -1 : 1; }
  double phase_of(double position) const noexcept;
  double position_of(double phase_rad) const noexcept;

  const machine::Machine* machine_ = nullptr;
  double period_s_ = 0.001;
  TapOrder order_;
  Phase phase_ = Phase::off;
  PointMotion motion_;
  double position_ = 0, speed_in_ = 0, speed_out_ = 0;
  double origin_ = 0, origin_phase_ = 0;  // where axis and spindle were coupled
  double dwell_left_ = 0;
  bool stop_given_ = false, in_hole_ = false;
  double beyond_mm_ = 0;
};

}  // namespace headstock::axes

// What watches the axes and the spindle in every period and stops the machine when they do not do what they
// are told: following error while moving and at rest, synchronous axes that part, a rigid tap whose spindle
// lags, a spindle whose speed fluctuates. Which alarm a controller shows is the business of operation/.
// Real-time thread; no allocation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "machine/machine.hpp"

namespace headstock::axes {

using machine::AxisVector;

enum class FaultKind : std::uint8_t {
  none,
  following_error_moving,   ///< the servo lags more than it may: drives off at once
  following_error_stopped,  ///< pushed away from where it stands: drives off at once
  synchronous_error,        ///< master and slave have parted: drives off at once
  tap_error,                ///< spindle and axis have left their step in rigid tapping: drives off at once
  spindle_fluctuation,      ///< G26: controlled stop
  overtravel                ///< the commanded position is about to pass a stroke limit: stopped inside it
};

struct Fault {
  FaultKind kind = FaultKind::none;
  std::size_t axis = 0;
  bool positive = false;  ///< overtravel: the side
};

/// Following error and synchronous axes.
class AxisSupervision {
 public:
  explicit AxisSupervision(const machine::Machine& machine);
  /// @param commanded, actual machine coordinates of every axis, compensation left out
  Fault check(const AxisVector& commanded, const AxisVector& actual) noexcept;
  /// Every axis is where it is commanded to be, within its in-position width.
  /// @param besides axes that nothing waits for: they move beside the program; bit: axis
  bool in_position(const AxisVector& commanded, const AxisVector& actual,
                   std::uint32_t besides = 0) const noexcept;
  /// The drives were off, or the position was set: what was before does not count.
  void restart() noexcept { settled_ = false; }

 private:
  struct Axis {
    double moving_mm, stopped_mm, in_position_mm, synchronous_mm;
    int master = -1;
  };
  static constexpr int kSettling = 200;  // periods at rest until the limit at rest counts

  std::size_t axes_;
  std::array<Axis, machine::kMaxAxes> axis_{};
  AxisVector last_commanded_{};
  std::array<int, machine::kMaxAxes> rest_{};
  bool settled_ = false;
};

/// G26 (0i-D 6.5): the speed must stay within max(commanded × ratio, width) of what is commanded, from when
/// it has first come within `reached_ratio`, at the latest `delay_s` after the command has changed.
class SpindleWatch {
 public:
  struct Order {
    bool on = false;
    double delay_s = 0, reached_ratio = 0, ratio = 0, width_rpm = 0;
  };
  void set(const Order& order) noexcept {
    order_ = order;
    waited_s_ = 0;
    watching_ = false;
  }
  bool on() const noexcept { return order_.on; }
  /// @return true: the speed fluctuates too much
  bool check(double commanded_rpm, double actual_rpm, double period_s) noexcept;

 private:
  Order order_;
  double last_commanded_ = 0, waited_s_ = 0;
  bool watching_ = false;
};

}  // namespace headstock::axes

#include "axes/supervision.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::axes {
namespace {

// Without a limit of its own an axis may lag half as much again as its rapid rate makes it lag.
constexpr double kMargin = 1.5, kMarginMm = 1.0;

}  // namespace

AxisSupervision::AxisSupervision(const machine::Machine& machine) : axes_(machine.axes.size()) {
  for (std::size_t i = 0; i < axes_; ++i) {
    const machine::Axis& from = machine.axes[i];
    Axis& to = axis_[i];
    to.moving_mm = from.following_error_mm > 0
                       ? from.following_error_mm
                       : kMargin * from.rapid_mm_min / 60 / from.position_gain_per_s + kMarginMm;
    to.stopped_mm = from.following_error_stopped_mm;
    to.in_position_mm = from.in_position_um / 1000;
    to.synchronous_mm = from.synchronous_error_mm;
    to.master = from.follows != 0 ? static_cast<int>(machine.axis_index(from.follows).value_or(i)) : -1;
  }
}

Fault AxisSupervision::check(const AxisVector& commanded, const AxisVector& actual) noexcept {
  if (!settled_) {
    settled_ = true;
    last_commanded_ = commanded;
    rest_.fill(0);
  }
  Fault fault;
  for (std::size_t i = 0; i < axes_; ++i) {
    rest_[i] = commanded[i] == last_commanded_[i] ? std::min(rest_[i] + 1, kSettling) : 0;
    const double error = std::abs(commanded[i] - actual[i]);
    const bool stopped = rest_[i] == kSettling;
    if (error > (stopped ? std::min(axis_[i].stopped_mm, axis_[i].moving_mm) : axis_[i].moving_mm))
      fault = {stopped ? FaultKind::following_error_stopped : FaultKind::following_error_moving, i, false};
    if (axis_[i].master < 0) continue;
    const auto master = static_cast<std::size_t>(axis_[i].master);
    // Each axis by what it still lacks, so that different zero points do not count.
    const double apart = (commanded[i] - actual[i]) - (commanded[master] - actual[master]);
    if (std::abs(apart) > axis_[i].synchronous_mm) fault = {FaultKind::synchronous_error, i, false};
  }
  last_commanded_ = commanded;
  return fault;
}

bool AxisSupervision::in_position(const AxisVector& commanded, const AxisVector& actual,
                                  std::uint32_t besides) const noexcept {
  for (std::size_t i = 0; i < axes_; ++i)
    if ((besides >> i & 1) == 0 && std::abs(commanded[i] - actual[i]) > axis_[i].in_position_mm) return false;
  return true;
}

bool SpindleWatch::check(double commanded_rpm, double actual_rpm, double period_s) noexcept {
  const double commanded = std::abs(commanded_rpm), error = std::abs(commanded_rpm - actual_rpm);
  if (commanded_rpm != last_commanded_) {
    last_commanded_ = commanded_rpm;
    waited_s_ = 0;
    watching_ = false;
  }
  if (!order_.on || commanded == 0) return false;
  waited_s_ += period_s;
  watching_ = watching_ || error <= commanded * order_.reached_ratio || waited_s_ > order_.delay_s;
  return watching_ && error > std::max(commanded * order_.ratio, order_.width_rpm);
}

}  // namespace headstock::axes

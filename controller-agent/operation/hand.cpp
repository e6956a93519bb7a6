#include "operation/hand.hpp"

#include <cmath>

namespace headstock::operation {
namespace {

constexpr double kSettled_mm = 0.0005;
constexpr double kFar_mm = 1e6;  // a search for the dog ends by the dog, a limit switch, or the operator

}  // namespace

Hand::Hand(const machine::Machine& machine, double period_s) : axes_(machine.axes.size()) {
  for (std::size_t i = 0; i < axes_; ++i) {
    const machine::Axis& axis = machine.axes[i];
    motion_[i] = axes::PointMotion({axis.rapid_mm_min / 60, axis.max_acceleration_mm_s2, axis.max_jerk_mm_s3},
                                   period_s);
    creep_mm_s_[i] = axis.creep_mm_min / 60;
    negative_[i] = axis.home_negative;
  }
}

void Hand::order(std::size_t axis, const HandOrder& order) noexcept {
  Slot& slot = slots_[axis];
  slot.sequence.fetch_add(1, std::memory_order_acq_rel);  // odd: being written
  slot.target.store(order.target, std::memory_order_release);
  slot.speed.store(order.speed_mm_s, std::memory_order_release);
  slot.acceleration.store(order.acceleration_mm_s2, std::memory_order_release);
  slot.bell.store(order.bell_s, std::memory_order_release);
  slot.kind.store(order.kind, std::memory_order_release);
  slot.rapid.store(order.rapid, std::memory_order_release);
  slot.sequence.fetch_add(1, std::memory_order_release);
  given_.fetch_add(1, std::memory_order_release);
}

void Hand::take_orders(const AxisVector& base) noexcept {
  const std::uint64_t given = given_.load(std::memory_order_acquire);
  if (given == taken_) return;
  bool complete = true;
  for (std::size_t i = 0; i < axes_; ++i) {
    Slot& slot = slots_[i];
    const std::uint32_t before = slot.sequence.load(std::memory_order_acquire);
    if (before == seen_[i]) continue;
    HandOrder order;
    order.target = slot.target.load(std::memory_order_acquire);
    order.speed_mm_s = slot.speed.load(std::memory_order_acquire);
    order.acceleration_mm_s2 = slot.acceleration.load(std::memory_order_acquire);
    order.bell_s = slot.bell.load(std::memory_order_acquire);
    order.kind = slot.kind.load(std::memory_order_acquire);
    order.rapid = slot.rapid.load(std::memory_order_acquire);
    if (before % 2 != 0 || slot.sequence.load(std::memory_order_acquire) != before) {
      complete = false;  // in the middle of being written: next period
      continue;
    }
    seen_[i] = before;
    orders_[i] = order;
    if (motion_[i].at_rest()) motion_[i].shape(order.acceleration_mm_s2, order.bell_s);
    homing_[i] = order.kind == HandOrder::Kind::home ? Homing::search : Homing::off;
    switch (order.kind) {
      case HandOrder::Kind::stop:
        motion_[i].stop();
        break;
      case HandOrder::Kind::go:
        goal_[i] = order.target - base[i];
        break;
      case HandOrder::Kind::go_back:
        goal_[i] = 0;
        break;
      case HandOrder::Kind::home:
        goal_[i] = negative_[i] ? -kFar_mm : kFar_mm;
        break;
    }
  }
  if (complete) taken_ = given;
}

// Manual reference return over a dog (0i-D III-3.1): rapid until the dog is touched, slowed down on it, at
// the creep speed off it, on to the next zero mark of the encoder.
void Hand::step_homing(std::size_t axis, double base, const axes::Drive& drive) noexcept {
  const double sense = negative_[axis] ? -1 : 1;
  switch (homing_[axis]) {
    case Homing::off:
      return;
    case Homing::search:
      if (drive.dog(axis)) homing_[axis] = Homing::slow_down;
      return;
    case Homing::slow_down:
      orders_[axis].speed_mm_s = creep_mm_s_[axis];
      if (!drive.dog(axis)) {
        failed_ |= 1u << axis;
        orders_[axis].kind = HandOrder::Kind::stop;
        homing_[axis] = Homing::off;
        motion_[axis].stop();
        return;
      }
      if (std::abs(motion_[axis].velocity()) <= creep_mm_s_[axis] * 1.001) homing_[axis] = Homing::creep;
      return;
    case Homing::creep:
      if (drive.dog(axis)) return;
      // From where the slide is measured, which lags behind the command.
      goal_[axis] = drive.actual()[axis] - base + drive.way_to_mark(axis, sense);
      // Too near to stop at: the one after it.
      if (std::abs(goal_[axis] - motion_[axis].position()) < motion_[axis].stopping_way())
        goal_[axis] += sense * drive.mark_distance(axis);
      homing_[axis] = Homing::mark;
      return;
    case Homing::mark:
      // The slide lags behind: it is called its reference point when it stands there, too.
      if (!motion_[axis].arrived()) return;
      if (std::abs(drive.actual()[axis] - base - motion_[axis].position()) > kSettled_mm) return;
      homed_ |= 1u << axis;
      homing_[axis] = Homing::off;
      return;
  }
}

void Hand::step(const AxisVector& base, double feed_override, double rapid_override,
                const axes::Drive& drive) noexcept {
  take_orders(base);
  moving_ = false;
  busy_ = 0;
  for (std::size_t i = 0; i < axes_; ++i) {
    const HandOrder& order = orders_[i];
    if (homing_[i] == Homing::off && motion_[i].at_rest() &&
        (order.kind == HandOrder::Kind::stop || motion_[i].position() == goal_[i]))
      continue;
    busy_ |= 1u << i;
    step_homing(i, base[i], drive);
    // The creep to the zero mark is what finds it: no override changes it.
    const bool fixed = homing_[i] > Homing::search;
    const double factor = fixed ? 1 : order.rapid ? rapid_override : feed_override;
    if (order.kind != HandOrder::Kind::stop) motion_[i].go(goal_[i], order.speed_mm_s * factor);
    motion_[i].step();
    moving_ = moving_ || !motion_[i].at_rest();
  }
}

void Hand::stop() noexcept {
  homed_ = failed_ = 0;
  for (std::size_t i = 0; i < axes_; ++i) {
    orders_[i].kind = HandOrder::Kind::stop;
    homing_[i] = Homing::off;
    motion_[i].stop();
  }
}

void Hand::clear(std::uint32_t axes) noexcept {
  for (std::size_t i = 0; i < axes_; ++i) {
    if ((axes >> i & 1) == 0) continue;
    orders_[i] = {};
    homing_[i] = Homing::off;
    motion_[i].set(0);
    goal_[i] = 0;
  }
}

}  // namespace headstock::operation

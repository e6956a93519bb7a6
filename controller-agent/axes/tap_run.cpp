#include "axes/tap_run.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headstock::axes {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
// What the spindle's rounding and the axis' smoothing may add; the spindle itself is checked by its error.
constexpr double kSpindleShare = 0.95;

}  // namespace

TapRun::TapRun(const machine::Machine& machine, double period_s) : machine_(&machine), period_s_(period_s) {}

double TapRun::phase_of(double position) const noexcept {
  return origin_phase_ + order_.turning * (position - origin_) * inward() / order_.pitch_mm * kTwoPi;
}

double TapRun::position_of(double phase_rad) const noexcept {
  return origin_ + order_.turning * (phase_rad - origin_phase_) / kTwoPi * order_.pitch_mm * inward();
}

void TapRun::begin(const TapOrder& order, double position) noexcept {
  order_ = order;
  position_ = origin_ = position;
  in_hole_ = stop_given_ = false;
  beyond_mm_ = 0;
  dwell_left_ = order.dwell_s;
  const machine::Axis& axis = machine_->axes[order.axis];
  const machine::Spindle& data = machine_->spindle;
  const double own = data.tap_acceleration_rpm_s > 0
                         ? std::min(data.tap_acceleration_rpm_s, data.acceleration_rpm_s)
                         : data.acceleration_rpm_s;
  PointMotion::Limits limits;
  limits.speed = axis.max_feed_mm_min / 60;
  limits.acceleration = std::min(axis.max_acceleration_mm_s2, kSpindleShare * own * order.pitch_mm / 60);
  limits.jerk = axis.max_jerk_mm_s3;
  motion_ = PointMotion(limits, period_s_);
  motion_.set(position);
  speed_in_ = std::min(order.rpm * order.pitch_mm / 60, limits.speed);
  speed_out_ = std::min(speed_in_ * order.out_ratio, limits.speed);
  phase_ = Phase::wait;
}

void TapRun::stop() noexcept {
  if (phase_ == Phase::off) return;
  motion_.stop();
  if (phase_ == Phase::trim) return;
  phase_ = phase_ == Phase::wait ? Phase::off : Phase::stopping;
}

void TapRun::drop() noexcept {
  if (phase_ == Phase::off) return;
  in_hole_ = (position_ - order_.end) * inward() > 0;
  phase_ = Phase::off;
}

void TapRun::step(SimulatedSpindle& spindle, double gain_per_s) noexcept {
  if (phase_ == Phase::off) return;
  if (phase_ == Phase::wait) {
    spindle.command(0);
    if (!spindle.stands()) return;
    origin_phase_ = spindle.phase_rad();
    phase_ = order_.out_only ? Phase::out : Phase::in;
  }
  if (order_.follows)
    step_follows(spindle);
  else
    step_rigid(spindle, gain_per_s);
  beyond_mm_ = std::max(beyond_mm_, (position_ - order_.bottom) * inward());
}

double TapRun::error_mm(double actual_position, double phase_rad) const noexcept {
  return std::abs(actual_position - position_of(phase_rad));
}

void TapRun::step_rigid(SimulatedSpindle& spindle, double gain_per_s) noexcept {
  switch (phase_) {
    case Phase::in:
      motion_.go(order_.bottom, speed_in_);
      break;
    case Phase::out:
      motion_.go(order_.end, speed_out_);
      break;
    default:
      break;
  }
  motion_.step();
  position_ = motion_.position();
  spindle.command_phase(phase_of(position_), gain_per_s);
  if (!motion_.at_rest()) return;
  if (phase_ == Phase::in && motion_.arrived()) phase_ = Phase::dwell;
  if (phase_ == Phase::dwell) {
    dwell_left_ -= period_s_;
    if (dwell_left_ <= period_s_ * 1e-6) phase_ = Phase::out;
  } else if (phase_ == Phase::out && motion_.arrived()) {
    phase_ = Phase::off;
  } else if (phase_ == Phase::stopping) {
    in_hole_ = (position_ - order_.end) * inward() > 0;
    phase_ = Phase::off;
  }
}

void TapRun::step_follows(SimulatedSpindle& spindle) noexcept {
  const machine::Axis& axis = machine_->axes[order_.axis];
  spindle.limit_acceleration(0.9 * axis.max_acceleration_mm_s2 * 60 / order_.pitch_mm);
  if (phase_ != Phase::trim) {
    const double before = position_;
    position_ = position_of(spindle.phase_rad());
    const double stops_at =
        position_of(spindle.phase_rad() + std::copysign(spindle.stopping_angle_rad(), spindle.rpm()));
    switch (phase_) {
      case Phase::in:
        stop_given_ = stop_given_ || (stops_at - order_.bottom) * inward() >= 0;
        spindle.command(stop_given_ ? 0 : order_.turning * order_.rpm);
        if (stop_given_ && spindle.stands()) {
          stop_given_ = false;
          phase_ = Phase::dwell;
        }
        break;
      case Phase::dwell:
        dwell_left_ -= period_s_;
        if (dwell_left_ <= period_s_ * 1e-6) phase_ = Phase::out;
        break;
      case Phase::out:
        stop_given_ = stop_given_ || (order_.end - stops_at) * inward() >= 0;
        spindle.command(stop_given_ ? 0 : -order_.turning * order_.rpm * order_.out_ratio);
        if (stop_given_ && spindle.stands() && position_ == before) {
          motion_.set(position_);
          phase_ = Phase::trim;
        }
        break;
      case Phase::stopping:
        spindle.command(0);
        if (spindle.stands()) {
          in_hole_ = (position_ - order_.end) * inward() > 0;
          phase_ = Phase::off;
        }
        break;
      default:
        break;
    }
    if (phase_ == Phase::off) spindle.limit_acceleration(0);
    return;
  }
  // The rest of a turn or two to the programmed end: the tap is out.
  motion_.go(order_.end, speed_in_);
  motion_.step();
  position_ = motion_.position();
  if (!motion_.at_rest()) return;
  spindle.limit_acceleration(0);
  phase_ = Phase::off;
}

}  // namespace headstock::axes

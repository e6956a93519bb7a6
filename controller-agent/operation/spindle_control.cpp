#include "operation/spindle_control.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headstock::operation {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kRadSPerRpm = kTwoPi / 60;
// Surface speed at the centre asks for infinite rpm: the clamp decides.
constexpr double kSmallestRadius_mm = 0.01;
constexpr double kTurnShare = 0.9;  // of the spindle's acceleration, for turning to an angle

axes::PointMotion::Limits turn_limits(const machine::Spindle& spindle) {
  axes::PointMotion::Limits limits;
  limits.speed = spindle.orient_rpm * kRadSPerRpm;
  limits.acceleration = kTurnShare * spindle.acceleration_rpm_s * kRadSPerRpm;
  limits.jerk = limits.acceleration / 0.03;
  return limits;
}

}  // namespace

SpindleControl::SpindleControl(const machine::Machine& machine, double period_s)
    : max_rpm_(machine.spindle.max_rpm),
      orient_rad_(machine.spindle.orient_deg / 360 * kTwoPi),
      orient_speed_rad_s_(machine.spindle.orient_rpm * kRadSPerRpm),
      spindle_(machine.spindle, period_s),
      turn_(turn_limits(machine.spindle), period_s) {}

double SpindleControl::speed_for(const plc::Outputs& outputs, double radius_mm) const noexcept {
  double rpm = outputs.speed;
  if (outputs.constant_surface_speed)
    rpm = outputs.speed * 1000 / (kTwoPi * std::max(radius_mm, kSmallestRadius_mm));
  if (outputs.clamp_rpm > 0) rpm = std::min(rpm, outputs.clamp_rpm);
  return std::clamp(rpm, 0.0, max_rpm_);
}

// Orientation and the Cs axis: to a stop, then to the angle the short way round, then held there.
void SpindleControl::place(const plc::Outputs& outputs, const Wanted& wanted) noexcept {
  if (state_ == State::speed) state_ = State::stopping;
  // From the Cs axis to orientation and back the way leads over standing still, too.
  if (state_ == State::contour && !outputs.contour) state_ = State::stopping;
  if (state_ == State::oriented && outputs.contour) state_ = State::stopping;
  if (state_ == State::stopping) {
    if (spindle_.positioned())
      spindle_.command_phase(spindle_.phase_rad());
    else
      spindle_.command(0);
    if (!spindle_.stands()) return;
    const double phase = spindle_.phase_rad();
    const double to = outputs.contour ? wanted.contour_deg / 360 * kTwoPi : orient_rad_;
    turn_.set(phase);
    turn_.go(phase + std::remainder(to - phase, kTwoPi), orient_speed_rad_s_);
    state_ = State::turning;
  }
  if (state_ == State::turning) {
    turn_.step();
    spindle_.command_phase(turn_.position());
    if (!turn_.arrived() || spindle_.position_error_rad() != 0) return;
    state_ = outputs.contour ? State::contour : State::oriented;
    contour_origin_rad_ = turn_.position();
    contour_origin_deg_ = wanted.contour_deg;
  }
  if (state_ == State::contour)
    spindle_.command_phase(contour_origin_rad_ + (wanted.contour_deg - contour_origin_deg_) / 360 * kTwoPi);
  else
    spindle_.command_phase(turn_.position());
}

void SpindleControl::step(const plc::Outputs& outputs, const Wanted& wanted, bool tapping) noexcept {
  if (outputs.spindle_orders != held_order_) held_ = false;
  commanded_rpm_ = 0;
  if (tapping) {
    state_ = State::speed;
    commanded_rpm_ = spindle_.positioned() ? spindle_.rpm() : spindle_.commanded_rpm();
  } else if (wanted.off) {
    state_ = State::speed;
    spindle_.command(0);
  } else if (held_) {
    state_ = State::speed;
    spindle_.command_phase(held_phase_rad_, held_gain_per_s_);
  } else if (outputs.orient || outputs.contour) {
    place(outputs, wanted);
  } else {
    state_ = State::speed;
    commanded_rpm_ = std::min(speed_for(outputs, wanted.surface_radius_mm) * wanted.override, max_rpm_);
    if (outputs.clamp_rpm > 0) commanded_rpm_ = std::min(commanded_rpm_, outputs.clamp_rpm);
    commanded_rpm_ *= static_cast<double>(outputs.turning);
    spindle_.command(commanded_rpm_);
  }
  spindle_.step();
}

}  // namespace headstock::operation

#include "axes/mechanics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headstock::axes {
namespace {

// What the take-up of play may use of the axis' acceleration and jerk, beside the motion itself.
constexpr double kTakeUpShare = 0.5;
constexpr double kMoves_mm = 1e-9;
constexpr double kAlignment_mm_s = 1;  // of a slave that has parted from its master

}  // namespace

double PitchTable::at(double position_mm) const noexcept {
  if (points_.empty()) return 0;
  const auto above = std::upper_bound(
      points_.begin(), points_.end(), position_mm,
      [](double position, const machine::PitchError& point) { return position < point.position_mm; });
  if (above == points_.begin()) return points_.front().error_um / 1000;
  if (above == points_.end()) return points_.back().error_um / 1000;
  const machine::PitchError &left = *(above - 1), &right = *above;
  const double share = (position_mm - left.position_mm) / (right.position_mm - left.position_mm);
  return (left.error_um + share * (right.error_um - left.error_um)) / 1000;
}

Mechanics::Mechanics(const machine::Machine& machine, double period_s) : axes_(machine.axes.size()) {
  master_.fill(-1);
  for (std::size_t i = 0; i < axes_; ++i) {
    const machine::Axis& axis = machine.axes[i];
    if (axis.follows != 0) {
      const std::size_t master = machine.axis_index(axis.follows).value_or(i);
      master_[i] = static_cast<int>(master);
      // Coupled where both stand at their reference points.
      slave_shift_[i] = axis.reference_mm - machine.axes[master].reference_mm;
      slave_off_[i] =
          PointMotion({kAlignment_mm_s, axis.max_acceleration_mm_s2, axis.max_jerk_mm_s3}, period_s);
    }
    if (axis.inclined_to != 0) {
      const double angle = axis.inclined_deg * std::numbers::pi / 180;
      inclined_.push_back(
          {i, machine.axis_index(axis.inclined_to).value_or(i), std::cos(angle), std::tan(angle)});
    }
    Screw& screw = screws_[i];
    screw.positive = PitchTable(axis.pitch_error);
    screw.negative =
        PitchTable(axis.pitch_error_negative.empty() ? axis.pitch_error : axis.pitch_error_negative);
    screw.backlash_mm = axis.backlash_um / 1000;
    screw.compensated = screw.backlash_mm > 0 || !screw.positive.empty() || !screw.negative.empty();
    double most = screw.backlash_mm;
    for (const auto* table : {&axis.pitch_error, &axis.pitch_error_negative})
      for (const machine::PitchError& point : *table)
        most = std::max(most, screw.backlash_mm + std::abs(screw.negative.at(point.position_mm) -
                                                           screw.positive.at(point.position_mm)));
    screw.scale = std::max(most, 1e-6);
    PointMotion::Limits limits;
    limits.speed = axis.rapid_mm_min / 60;
    limits.acceleration = kTakeUpShare * axis.max_acceleration_mm_s2;
    limits.jerk = kTakeUpShare * axis.max_jerk_mm_s3;
    screw.share = PointMotion(limits, period_s);
    // Play is set to the side of reference return (0i-D No. 1851).
    screw.sense = axis.home_negative ? -1 : 1;
    screw.share.set(axis.home_negative ? screw.scale : 0);
  }
}

void Mechanics::couple(AxisVector& axes) noexcept {
  for (std::size_t i = 0; i < axes_; ++i) {
    if (master_[i] < 0) continue;
    slave_off_[i].go(0, kAlignment_mm_s);
    slave_off_[i].step();
    axes[i] = axes[static_cast<std::size_t>(master_[i])] + slave_shift_[i] + slave_off_[i].position();
  }
}

void Mechanics::take_up(const AxisVector& axes) noexcept {
  for (std::size_t i = 0; i < axes_; ++i)
    if (master_[i] >= 0)
      slave_off_[i].set(axes[i] - axes[static_cast<std::size_t>(master_[i])] - slave_shift_[i]);
}

AxisVector Mechanics::kinematics(const AxisVector& axes) const noexcept {
  AxisVector motors = axes;
  for (const Inclined& pair : inclined_) {
    // The inclined slide runs 1/cos as far and carries the straight one along (0i-D angular axis control).
    motors[pair.axis] = axes[pair.axis] / pair.cosine;
    motors[pair.straight] = axes[pair.straight] - axes[pair.axis] * pair.tangent;
  }
  return motors;
}

// Measured minus commanded is what is to be taken away; in the negative direction the play comes on top.
double Mechanics::error_at(const Screw& screw, double position, double share) const noexcept {
  const double positive = -screw.positive.at(position);
  const double negative = -screw.negative.at(position) - screw.backlash_mm;
  return positive + share * (negative - positive);
}

void Mechanics::set_position(const AxisVector& axes) noexcept {
  last_ = kinematics(axes);
  for (std::size_t i = 0; i < axes_; ++i) {
    Screw& screw = screws_[i];
    compensation_[i] =
        screw.compensated ? error_at(screw, last_[i], screw.share.position() / screw.scale) : 0;
  }
}

AxisVector Mechanics::to_motors(const AxisVector& axes) noexcept {
  AxisVector motors = kinematics(axes);
  const AxisVector ideal = motors;
  for (std::size_t i = 0; i < axes_; ++i) {
    Screw& screw = screws_[i];
    if (!screw.compensated) continue;
    const double moved = ideal[i] - last_[i];
    if (std::abs(moved) > kMoves_mm) screw.sense = moved < 0 ? -1 : 1;
    screw.share.go(screw.sense < 0 ? screw.scale : 0, 1e9);
    screw.share.step();
    compensation_[i] = error_at(screw, ideal[i], screw.share.position() / screw.scale);
    motors[i] += compensation_[i];
  }
  last_ = ideal;
  return motors;
}

AxisVector Mechanics::to_axes(const AxisVector& motors) const noexcept {
  AxisVector axes = motors;
  for (std::size_t i = 0; i < axes_; ++i) axes[i] -= compensation_[i];
  for (const Inclined& pair : inclined_) {
    axes[pair.axis] *= pair.cosine;
    axes[pair.straight] += axes[pair.axis] * pair.tangent;
  }
  return axes;
}

}  // namespace headstock::axes

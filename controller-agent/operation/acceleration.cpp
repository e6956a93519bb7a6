#include "operation/acceleration.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace headstock::operation {
namespace {

constexpr double kMeanUnit = 1000.0 / 60;  // (m/min)/s in mm/s² (K2000TC L4866)
constexpr double kNoShare = 1e-9;

using enum AccelerationUnit;

std::string of_axis(std::string_view parameter, char name) {
  std::string number(parameter);
  if (parameter.ends_with('/')) number += name;
  return number;
}

bool stands(const ModeBit& bit, char axis, const interp::MachineData& data) {
  if (bit.bit.empty()) return true;
  return (data.parameter(of_axis(bit.bit, axis), bit.unset ? 1 : 0) != 0) == bit.on;
}

bool is_s(AccelerationUnit unit) {
  return unit == s_to_rapid || unit == s_to_highest;
}

/// The smaller of two limits, where 0 means none.
void lower(double& limit, double by) {
  if (by > 0 && (limit <= 0 || by < limit)) limit = by;
}

}  // namespace

/// Fills the rules from the rows of one controller.
struct AccelerationReader {
  const machine::Machine& machine;
  const interp::MachineData& data;
  AccelerationRules& rules;

  /// Calls `take` for every row and axis that counts.
  template <typename Take>
  void each(Take take) const {
    for (const AccelerationRow& row : acceleration_rows()) {
      if (!machine.profile.starts_with(row.profile)) continue;
      AccelerationRules::Kind& kind = rules.kinds_[static_cast<std::size_t>(row.kind)];
      for (std::size_t i = 0; i < machine.axes.size(); ++i) {
        const char name = machine.axes[i].name;
        if (row.axis != 0 && row.axis != name) continue;
        if (!stands(row.first, name, data) || !stands(row.second, name, data)) continue;
        const double value = data.parameter(of_axis(row.parameter, name));
        if (value > 0) take(row, kind, i, value);
      }
    }
  }

  /// How long the acceleration rises and falls: half of an S, the shorter one where ramps or axes differ, so
  /// that none of them takes longer than it should.
  void take_bell(const AccelerationRow& row, AccelerationRules::Kind& kind, double value) const {
    const double seconds = value / 1000;
    if (row.unit == bell) kind.shape.bell_s = std::max(kind.shape.bell_s, seconds);
    if (is_s(row.unit)) lower(kind.shape.bell_s, seconds / 2);
    kind.shape.bell_s = std::min(kind.shape.bell_s, motion::kLongestBell_s);
  }

  void take(const AccelerationRow& row, AccelerationRules::Kind& kind, std::size_t axis, double value) const {
    if (row.ramp != Ramp::down) set(kind.up, kind, row.unit, axis, value);
    if (row.ramp != Ramp::up) set(kind.down, kind, row.unit, axis, value);
  }

  void set(AccelerationRules::Limit& limit, AccelerationRules::Kind& kind, AccelerationUnit unit,
           std::size_t axis, double value) const {
    const machine::Axis& of = machine.axes[axis];
    const double seconds = value / 1000, rapid = of.rapid_mm_min / 60, highest = of.max_feed_mm_min / 60;
    switch (unit) {
      case acceleration:
        return lower(limit.axis[axis], value);
      case time_to_rapid:
        return lower(limit.axis[axis], rapid / seconds);
      case time_to_highest:
        return lower(limit.axis[axis], highest / seconds);
      case s_to_rapid:
        return lower(limit.axis[axis], rapid / (seconds - kind.shape.bell_s));
      case s_to_highest:
        return lower(limit.axis[axis], highest / (seconds - kind.shape.bell_s));
      case time_to_feed:
        limit.time_s[axis] = seconds;
        return;
      case mean:
        return lower(limit.along, value * kMeanUnit);
      case bell:
        return;
      case after_linear:
        return after(kind.shape, motion::FilterShape::linear, axis, seconds, 0);
      case after_bell:
        return after(kind.shape, motion::FilterShape::linear, axis, seconds / 2, seconds / 2);
      case after_exponential:
        return after(kind.shape, motion::FilterShape::exponential, axis, seconds, 0);
    }
  }

  /// Axes of one motion have one shape (0i-D L55684: the same for all axes, or lines and arcs are distorted);
  /// where parameters say otherwise all are linear.
  void after(motion::AccelerationShape& shape, motion::FilterShape wanted, std::size_t axis, double seconds,
             double bell_seconds) const {
    const bool mixed = shape.after != motion::FilterShape::none && shape.after != wanted;
    shape.after = mixed ? motion::FilterShape::linear : wanted;
    shape.after_s[axis] = std::min(seconds, motion::kLongestFilter_s);
    shape.after_bell_s[axis] = std::min(bell_seconds, motion::kLongestFilter_s);
    if (mixed) note("1610#0", "linear for all axes: their curves differ");
  }

  void note(std::string_view parameter, std::string_view instead) const {
    std::string& all = rules.not_done_;
    if (all.find(parameter) != std::string::npos) return;
    if (!all.empty()) all += "; ";
    all += parameter;
    all += ": ";
    all += instead;
  }

  /// Numbers the shapes of a program's motions: equal ones share one, so that the axes need not stop between
  /// them.
  void number_shapes() const {
    std::uint8_t used = 1;
    for (std::size_t k = 0; k < kProgramKinds; ++k) {
      AccelerationRules::Kind& kind = rules.kinds_[k];
      const auto end = rules.shapes_.begin() + used;
      const auto found = std::find(rules.shapes_.begin(), end, kind.shape);
      kind.number = static_cast<std::uint8_t>(found - rules.shapes_.begin());
      if (found == end) rules.shapes_[used++] = kind.shape;
    }
  }
};

AccelerationRules AccelerationRules::read(const machine::Machine& machine, const interp::MachineData& data) {
  AccelerationRules rules;
  for (std::size_t i = 0; i < machine.axes.size(); ++i) rules.rapid_mm_s_[i] = machine.axes[i].rapid_mm_min / 60;
  const AccelerationReader reader{machine, data, rules};
  reader.each([&](const AccelerationRow& row, Kind& kind, std::size_t, double value) {
    reader.take_bell(row, kind, value);
  });
  reader.each([&](const AccelerationRow& row, Kind& kind, std::size_t axis, double value) {
    reader.take(row, kind, axis, value);
  });
  // Without an acceleration of its own a retreat is a positioning; a ratio then counts from the machine's.
  const Kind& positioning = rules.kinds_[static_cast<std::size_t>(MotionKind::rapid)];
  Kind& back = rules.kinds_[static_cast<std::size_t>(MotionKind::retreat)];
  if (!(back.up.along > 0)) {
    back = positioning;
    for (std::size_t i = 0; i < machine.axes.size(); ++i) {
      for (Limit* limit : {&back.up, &back.down}) lower(limit->axis[i], machine.axes[i].max_acceleration_mm_s2);
    }
  }
  back.shape = positioning.shape;
  reader.number_shapes();
  for (const AccelerationGap& gap : acceleration_gaps())
    if (machine.profile.starts_with(gap.profile) && data.bit(gap.parameter))
      reader.note(gap.parameter, gap.instead);
  return rules;
}

namespace {

/// How much of the speed along the path an axis has at most.
double share_of(const motion::Curve& curve, std::size_t axis) {
  const bool turns = curve.is_arc && (axis == curve.axis_1 || axis == curve.axis_2);
  return turns ? 1 : std::abs(curve.direction[axis]);
}

}  // namespace

double AccelerationRules::allowed(const Limit& limit, const motion::Curve& curve, double feed_mm_s) {
  double most = limit.along, time_s = 0;
  for (std::size_t i = 0; i < limit.axis.size(); ++i) {
    const double share = share_of(curve, i);
    if (share <= kNoShare) continue;
    if (limit.axis[i] > 0) lower(most, limit.axis[i] / share);
    time_s = std::max(time_s, limit.time_s[i]);
  }
  if (time_s > 0) lower(most, feed_mm_s / time_s);
  return most;
}

/// 0 for a positioning.
double AccelerationRules::speed_of(const motion::Move& move, double rpm) {
  if (const auto* feed = std::get_if<motion::PathFeed>(&move.feed)) return feed->mm_s;
  if (const auto* feed = std::get_if<motion::RevolutionFeed>(&move.feed)) return feed->mm_rev * rpm / 60;
  if (const auto* cut = std::get_if<motion::ThreadFeed>(&move.feed)) return cut->lead_mm * rpm / 60;
  return 0;
}

void AccelerationRules::without_filter(const motion::Curve& curve, motion::Move& move, double rpm) const {
  const motion::AccelerationShape& shape = shapes_[move.shape];
  double speed = speed_of(move, rpm), time_s = 0;
  for (std::size_t i = 0; i < rapid_mm_s_.size(); ++i) {
    const double share = share_of(curve, i);
    if (share <= kNoShare) continue;
    if (std::holds_alternative<motion::RapidFeed>(move.feed)) lower(speed, rapid_mm_s_[i] / share);
    time_s = std::max(time_s, shape.after_s[i] + shape.after_bell_s[i]);
  }
  move.shape = 0;
  if (!(time_s > 0)) return;
  lower(move.speed_up_mm_s2, speed / time_s);
  lower(move.slow_down_mm_s2, speed / time_s);
}

void AccelerationRules::apply(const motion::Curve& curve, motion::Move& move, MotionKind kind, double rpm,
                              double ratio) const {
  const double feed_mm_s = speed_of(move, rpm);
  const Kind& limits = kinds_[static_cast<std::size_t>(kind)];
  move.speed_up_mm_s2 = allowed(limits.up, curve, feed_mm_s) * ratio;
  move.slow_down_mm_s2 = allowed(limits.down, curve, feed_mm_s) * ratio;
  move.shape = limits.number;
}

AccelerationRules::OfHand AccelerationRules::of_hand(std::size_t axis, MotionKind kind,
                                                     double speed_mm_s) const {
  const Kind& limits = kinds_[static_cast<std::size_t>(kind)];
  OfHand hand;
  for (const Limit* limit : {&limits.up, &limits.down}) {
    lower(hand.acceleration_mm_s2, limit->axis[axis]);
    if (limit->time_s[axis] > 0) lower(hand.acceleration_mm_s2, speed_mm_s / limit->time_s[axis]);
  }
  hand.bell_s = limits.shape.bell_s;
  return hand;
}

}  // namespace headstock::operation

#include "operation/speed_limits.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace headstock::operation {
namespace {

constexpr double kNoTurn = 1e-9;

AxisVector per_axis(const machine::Machine& machine, const interp::MachineData& data, const char* number,
                    double scale) {
  AxisVector values{};
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    values[i] = std::max(0.0, data.parameter(std::string(number) + "/" + machine.axes[i].name)) * scale;
  return values;
}

/// The smaller of two limits, where 0 means none.
double smaller(double a, double b) {
  return a <= 0 ? b : b <= 0 ? a : std::min(a, b);
}

AxisVector change(const motion::Curve& from, const motion::Curve& to) {
  const AxisVector before = from.tangent(from.length), after = to.tangent(0);
  AxisVector turn{};
  for (std::size_t i = 0; i < turn.size(); ++i) turn[i] = std::abs(after[i] - before[i]);
  return turn;
}

}  // namespace

SpeedLimits SpeedLimits::read(const machine::Machine& machine, const interp::MachineData& data) {
  SpeedLimits limits;
  if (machine.profile.starts_with("fanuc-0i")) {
    limits.arc_acceleration = per_axis(machine, data, "1735", 1);
    limits.arc_least_mm_s = data.parameter("1732") / 60;
    limits.corner_mm_s = per_axis(machine, data, "1783", 1.0 / 60);
    limits.corner_alike = data.bit("19500#6");
    limits.segment_acceleration = per_axis(machine, data, "1737", 1);
    limits.segment_least_mm_s = data.parameter("1738") / 60;
    limits.feed_mm_s = per_axis(machine, data, "1432", 1.0 / 60);
    limits.highest_mm_s = std::max(0.0, data.parameter("8465")) / 60;
  } else if (machine.profile == "gsk-2000tc") {
    limits.arc_acceleration.fill(std::max(0.0, data.parameter("P331")));
    limits.arc_least_mm_s = data.parameter("P332") / 60;
    limits.arc_always = true;
  } else if (machine.profile == "k2000tc") {
    limits.retreat_mm_s = std::max(0.0, data.parameter("P6484")) / 60;  // L3955
  }
  return limits;
}

double SpeedLimits::along(const motion::Curve& curve, const motion::Move& move, bool look_ahead) const {
  double speed = 0;
  const auto* arc = std::get_if<motion::Arc>(&move.geometry);
  if (arc != nullptr && (look_ahead || arc_always)) {
    const double acceleration = smaller(arc_acceleration[arc->axis_1], arc_acceleration[arc->axis_2]);
    const double radius = std::min(
        std::hypot(curve.start[arc->axis_1] - arc->center_1, curve.start[arc->axis_2] - arc->center_2),
        std::hypot(curve.end[arc->axis_1] - arc->center_1, curve.end[arc->axis_2] - arc->center_2));
    if (acceleration > 0) speed = std::max({std::sqrt(acceleration * radius), arc_least_mm_s, 1e-3});
  }
  if (!look_ahead) return speed;
  speed = smaller(speed, highest_mm_s);
  const AxisVector direction = curve.tangent(0);
  for (std::size_t i = 0; i < feed_mm_s.size(); ++i) {
    const bool turns = arc != nullptr && (i == arc->axis_1 || i == arc->axis_2);
    const double share = turns ? 1 : std::abs(direction[i]);
    if (share > kNoTurn && feed_mm_s[i] > 0) speed = smaller(speed, feed_mm_s[i] / share);
  }
  return speed;
}

double SpeedLimits::between(const motion::Curve& from, const motion::Curve& to) const {
  const AxisVector turn = change(from, to);
  double speed = 0, least = 0, whole = 0;
  for (std::size_t i = 0; i < turn.size(); ++i) {
    whole = std::hypot(whole, turn[i]);
    if (corner_mm_s[i] <= 0 || turn[i] <= kNoTurn) continue;
    speed = smaller(speed, corner_mm_s[i] / turn[i]);
    least = smaller(least, corner_mm_s[i]);
  }
  return corner_alike && speed > 0 ? least / whole : speed;
}

double SpeedLimits::segments(const motion::Curve& from, const motion::Curve& to) const {
  if (from.is_arc || to.is_arc) return 0;
  const AxisVector turn = change(from, to);
  const double way = (from.length + to.length) / 2;
  double square = 0, least = 0, whole = 0;
  for (std::size_t i = 0; i < turn.size(); ++i) {
    whole = std::hypot(whole, turn[i]);
    if (segment_acceleration[i] <= 0 || turn[i] <= kNoTurn) continue;
    square = smaller(square, segment_acceleration[i] * way / turn[i]);
    least = smaller(least, segment_acceleration[i]);
  }
  if (square <= 0) return 0;
  if (corner_alike) square = least * way / whole;
  return std::max({std::sqrt(square), segment_least_mm_s, 1e-3});
}

}  // namespace headstock::operation

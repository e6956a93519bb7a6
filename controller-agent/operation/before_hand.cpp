// What must be known before a hand moves an axis: how far it may go before a limit or a forbidden zone,
// wherever the other axes that hands move are by then.
#include <algorithm>
#include <optional>

#include "axes/travel_limits.hpp"
#include "operation/controller_impl.hpp"

namespace headstock::operation {
namespace {

constexpr double kNoLimit_mm = 1e6;

bool has(std::uint32_t axes, std::size_t axis) {
  return (axes >> axis & 1) != 0;
}

/// Where axes may be while one of them goes its way.
struct Sweep {
  AxisVector low, high;
};

/// The zone as one axis meets it while the others are anywhere in the sweep; nothing: they never come into
/// it.
std::optional<axes::Zone> met_by(const axes::Zone& zone, std::size_t axis, std::uint32_t others,
                                 const Sweep& sweep) {
  if (!has(zone.axes, axis)) return std::nullopt;
  axes::Zone met = zone;
  if (zone.outside_forbidden) return met;  // each axis has its own limits
  for (std::size_t i = 0; i < sweep.low.size(); ++i) {
    if (i == axis || !has(others, i) || !has(zone.axes, i)) continue;
    if (sweep.high[i] <= zone.least[i] || sweep.low[i] >= zone.most[i]) return std::nullopt;
    met.axes &= ~(1u << i);
  }
  return met;
}

}  // namespace

double Controller::Impl::reach(std::size_t axis, int direction) {
  const machine::Axis& limits = machine.axes[axis];
  const std::uint32_t homed = realtime.homed.load();
  double limit = direction > 0 ? limits.max_mm : limits.min_mm;
  if (!has(homed, axis)) limit = direction > 0 ? kNoLimit_mm : -kNoLimit_mm;
  AxisVector here = standing();
  Sweep sweep{here, here};
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    if (!has(hand_moving, i)) continue;
    sweep.low[i] = has(homed, i) ? std::min(here[i], hand_goal[i]) : -kNoLimit_mm;
    sweep.high[i] = has(homed, i) ? std::max(here[i], hand_goal[i]) : kNoLimit_mm;
  }
  here[axis] = hand_position(axis);
  motion::Line way{here};
  way.end[axis] = limit;
  for (const axes::Zone& each : zones()) {
    const auto met = met_by(each, axis, hand_moving, sweep);
    if (!met || !axes::find_entry(*met, here, way)) continue;
    // Up to the border that it would pass first.
    double border = direction > 0 ? each.least[axis] : each.most[axis];
    if (each.outside_forbidden) border = direction > 0 ? each.most[axis] : each.least[axis];
    const double stop = border - direction * axes::kStopBeforeLimit_mm;
    if ((limit - stop) * direction > 0) limit = stop;
  }
  return limit;
}

/// Every axis goes back by itself, as quickly as it can: they may be anywhere between here and there.
bool Controller::Impl::way_back_is_free() {
  const AxisVector from = standing();
  const AxisVector to = realtime.state().base;
  Sweep sweep;
  for (std::size_t i = 0; i < from.size(); ++i) {
    sweep.low[i] = std::min(from[i], to[i]);
    sweep.high[i] = std::max(from[i], to[i]);
  }
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    if (from[i] == to[i]) continue;
    motion::Line way{from};
    way.end[i] = to[i];
    for (const axes::Zone& each : zones()) {
      const auto met = met_by(each, i, ~0u, sweep);
      if (met && axes::find_entry(*met, from, way)) return false;
    }
  }
  return true;
}

}  // namespace headstock::operation

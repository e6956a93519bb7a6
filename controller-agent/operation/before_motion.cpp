// What must be known before an axis moves: a thread or a tap that the axes cannot follow, a forbidden zone,
// an axis without a reference point, an axis that is not the program's.
#include <cmath>
#include <utility>

#include "axes/travel_limits.hpp"
#include "operation/controller_impl.hpp"
#include "operation/fault_alarm.hpp"
#include "operation/motion_alarm.hpp"
#include "operation/path_length.hpp"

namespace headstock::operation {
namespace {

// Stored stroke check 3 (0i-D No. 1324, 1325): a box that no axis may enter, in force as soon as it is set.
constexpr std::string_view kCheckBeforeMove = "1301#7";  // stroke check before move (0i-D III-6.4)
constexpr std::string_view kThirdMost = "1324/", kThirdLeast = "1325/";

}  // namespace

std::vector<axes::Zone> Controller::Impl::zones() const {
  std::vector<axes::Zone> found;
  if (zone) found.push_back(*zone);
  axes::Zone third;
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const machine::Axis& axis = machine.axes[i];
    const std::string most = std::string(kThirdMost) + axis.name,
                      least = std::string(kThirdLeast) + axis.name;
    if (!data.parameters.contains(most) || !data.parameters.contains(least)) continue;
    const double page = axis.designation == machine::Designation::diameter ? 0.5 : 1;
    third.most[i] = data.parameter(most) * page;
    third.least[i] = data.parameter(least) * page;
    third.axes |= 1u << i;
  }
  if (third.axes != 0) found.push_back(third);
  return found;
}

std::optional<MachineAlarm> Controller::Impl::before_motion(const interp::Operation& taken) {
  const interp::Motion& motion = motion_of(taken);
  const AxisVector& from = feed.position();
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    if (motion.end_machine[i] == from[i]) continue;
    const bool homed = (realtime.homed.load() >> i & 1) != 0;
    if (const auto refused = axis_alarm(machine, i, homed, realtime.state().contour)) return refused;
  }
  if (const auto* tap = std::get_if<interp::Tap>(&taken)) return before_tap(*tap);
  if (dry_run && !std::holds_alternative<interp::Rapid>(taken) &&
      !(data.parameter("1410", FeedRules{}.dry_run_mm_min) > 0))
    return dry_run_alarm();
  if (const auto refused = feed.corner_override_refusal(taken)) return refused;
  const auto* thread = std::get_if<interp::Thread>(&taken);
  const bool check_first = data.bit(kCheckBeforeMove);
  const bool third = has_third_zone();
  feed.set_zones(zone || third ? zones() : std::vector<axes::Zone>{});
  if (!zone && !third && !thread && !check_first) return std::nullopt;
  AxisVector begin = from;
  for (const motion::Move& part : feed.moves(taken)) {
    if (const auto entered = forbidden(begin, part.geometry)) return entered;
    if (check_first) {
      if (const auto over = axes::find_overtravel(machine, begin, part.geometry))
        return before_move_alarm(over->positive);
    }
    begin = end_of(part);
  }
  if (thread == nullptr) return std::nullopt;
  motion::Move move = feed.make(taken);
  feed.limit_acceleration(move, thread->modal);
  const auto& cut = std::get<motion::ThreadFeed>(move.feed);
  return thread_alarm(machine, from, move, cut, std::abs(realtime.state().spindle_commanded_rpm),
                      thread->run_up_mm, feed.bell_s(move));
}

bool Controller::Impl::has_third_zone() const {
  const auto found = data.parameters.lower_bound(kThirdMost);
  return found != data.parameters.end() && found->first.starts_with(kThirdMost);
}

std::optional<MachineAlarm> Controller::Impl::forbidden(
    const AxisVector& from, const std::variant<motion::Line, motion::Arc>& geometry) const {
  std::size_t check = zone ? 2 : 3;
  for (const axes::Zone& each : zones()) {
    if (const auto entered = axes::find_entry(each, from, geometry))
      return data.bit(kCheckBeforeMove) ? before_move_alarm(entered->positive)
                                        : zone_alarm(check, entered->positive);
    ++check;
  }
  return std::nullopt;
}

std::optional<MachineAlarm> Controller::Impl::before_tap(const interp::Tap& tap) {
  const AxisVector& from = feed.position();
  std::size_t axis = machine.axes.size();
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    if (tap.bottom_machine[i] == from[i] && tap.end_machine[i] == from[i]) continue;
    if (axis != machine.axes.size()) return tap_across_alarm();
    axis = i;
  }
  if (axis == machine.axes.size()) return tap_across_alarm();
  if (const auto refused = axis_alarm(machine, axis, (realtime.homed.load() >> axis & 1) != 0, false))
    return refused;
  for (const AxisVector* to : {&tap.bottom_machine, &tap.end_machine}) {
    const motion::Line way{*to};
    if (const auto entered = forbidden(from, way)) return entered;
    // No part of a tap is cut: it would have to come out where it stands.
    if (const auto over = axes::find_overtravel(machine, from, way))
      return overtravel_alarm(machine.profile, machine.axes[over->axis].name, over->positive);
  }
  return tap_alarm(machine, axis, tap.pitch_mm, tap.rpm, tap.kind == interp::TapKind::rigid);
}

void Controller::Impl::take_tap(const interp::Tap& tap) {
  if (const auto refused = before_motion(tap)) return stop_with(*refused, tap.at, {});
  std::size_t axis = 0;
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    if (tap.bottom_machine[i] != feed.position()[i]) axis = i;
  axes::TapOrder order;
  order.axis = axis;
  order.start = feed.position()[axis];
  order.bottom = tap.bottom_machine[axis];
  order.end = tap.end_machine[axis];
  order.pitch_mm = tap.pitch_mm;
  order.rpm = tap.rpm;
  order.turning = tap.direction == interp::SpindleDirection::ccw ? -1 : 1;
  order.follows = tap.kind == interp::TapKind::follows;
  order.dwell_s = tap.dwell_s;
  order.out_ratio = tap.out_ratio;
  last_tap = order;
  anything_moved = true;
  Interlude interlude;
  interlude.kind = Interlude::Kind::tap;
  interlude.tap = order;
  interlude.tag = feed.add_tag(tap, main_offset);
  post(Await::tap, interlude);
}

/// The axes stand where the tap has come out; the kernel does not know it yet when that is another place.
void Controller::Impl::tap_done() {
  if (last_tap.end != last_tap.start) park();
}

void Controller::Impl::park() {
  await = Await::park;
  realtime.request_park();
}

/// G51.2, G50.2: PS5018 when the tool axis cannot turn that fast (0i-D L72940).
void Controller::Impl::take_polygon(const interp::PolygonTurning& polygon) {
  const std::size_t axis = machine.axis_index(machine.polygon_axis).value_or(0);
  const double ratio = static_cast<double>(polygon.tool_ratio) / polygon.spindle_ratio;
  const double rpm = std::abs(realtime.state().spindle_commanded_rpm);
  if (polygon.on && rpm * std::abs(ratio) * 360 > machine.axes[axis].max_feed_mm_min)
    return stop_with(polygon_alarm(), polygon.at, {});
  polygon_on = polygon.on;
  Interlude interlude;
  interlude.kind = Interlude::Kind::polygon;
  interlude.polygon = {polygon.on, axis, ratio};
  post(Await::polygon, interlude);
}

bool Controller::Impl::work_park() {
  if (!realtime.parked()) return false;
  const RealtimeState& now = realtime.state();
  AxisVector standing = now.base;
  std::uint32_t marks = 0;
  if (std::exchange(polygon_let_go, false)) {  // less the whole turns it has made
    const std::size_t axis = machine.axis_index(machine.polygon_axis).value_or(0);
    standing[axis] = std::remainder(now.sample.position[axis] - now.hand_offset[axis], 360.0);
    marks = 1u << axis;
    interpreter.set_position(standing);
  }
  kernel.set_position(standing);
  feed.set_position(standing);
  realtime.brake = false;  // of an interruption: what it stopped is gone
  realtime.unpark(standing, 0, marks);
  await = Await::nothing;
  return true;
}

/// A stop comes before the kernel has got its new position: it has to be stepped to come to rest.
void Controller::Impl::drop_park() {
  if (parking || await == Await::park) realtime.cancel_park();
  parking = false;
}

/// The supervision has stopped the machine: the alarm of this controller, and RESET before anything moves.
void Controller::Impl::machine_fault(const axes::Fault& fault) {
  const MachineAlarm alarm = fault_alarm(machine.profile, fault, machine.axes[fault.axis].name);
  if (fault.kind != axes::FaultKind::spindle_fluctuation && fault.kind != axes::FaultKind::overtravel) {
    realtime.emergency_stop = true;  // the drives stay off
    tripped = true;
  }
  unlocked_axes = fault.kind == axes::FaultKind::overtravel ? ~0u : unlocked_axes;
  const bool names_axis = fault.kind != axes::FaultKind::spindle_fluctuation;
  raise(std::string(alarm.code), names_axis ? std::string(1, machine.axes[fault.axis].name) : std::string(),
        last_block, alarm);
  armed = false;
  finish_run("alarm");
  drop_park();
  returning = false;
  phase = Phase::aborting;
  realtime.request_abort();
}

}  // namespace headstock::operation

// Moving by hand: jog, steps of the handle or the incremental keys, reference return, manual intervention in
// a held program, and the block typed in MDI mode. Each axis moves on its own beside the kernel (hand.hpp);
// when all stand, the kernel is given the new position.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "axes/travel_limits.hpp"
#include "operation/controller_impl.hpp"
#include "operation/motion_alarm.hpp"

namespace headstock::operation {
namespace {

constexpr double kThere_mm = 1e-6;
constexpr double kManualFeed_mm_min = 1'000;  // FANUC No. 1423, when it is not set

/// The block typed at the panel; the programs it calls are those of the memory.
class TypedBlock final : public program::Programs {
 public:
  TypedBlock(std::string text, std::shared_ptr<program::Programs> memory)
      : text_(std::move(text)), memory_(std::move(memory)) {}
  std::unique_ptr<program::Source> open_number(std::uint32_t number) override {
    return memory_ ? memory_->open_number(number) : nullptr;
  }
  std::unique_ptr<program::Source> open_name(std::string_view name) override {
    if (name == kName) return program::source_from_text(text_);
    return memory_ ? memory_->open_name(name) : nullptr;
  }
  static constexpr std::string_view kName = "MDI";

 private:
  std::string text_;
  std::shared_ptr<program::Programs> memory_;
};

std::string number_of_axis(std::string_view number, char axis) {
  return std::string(number) + '/' + axis;
}

}  // namespace

CommandResult Controller::Impl::mdi(std::string text) {
  if (busy()) return refused("running");
  if (mode != Mode::mdi) return refused("wrong_mode");
  mdi_block = {};
  mdi_block.name = TypedBlock::kName;
  mdi_block.bytes = text.size();
  mdi_block.memory = std::make_shared<TypedBlock>(std::move(text), selection.memory);
  return {true, {}};
}

bool Controller::Impl::held() const {
  if (returning) return false;
  if (phase == Phase::stopped) return true;
  return phase == Phase::running && realtime.hold.load();
}

CommandResult Controller::Impl::may_move_by_hand(std::size_t axis, Mode needed) {
  if (emergency) return refused("emergency_stop");
  if (alarmed() || phase == Phase::faulted) return refused("alarm");
  const bool intervening = held() && !realtime.state().kernel_moving;
  if (phase != Phase::idle && phase != Phase::manual && !intervening) return refused("running");
  if (parking) return refused("running");
  if (mode != needed) return refused("wrong_mode");
  if (axis >= machine.axes.size() || machine.axes[axis].follows != 0 || (plc_axes >> axis & 1) != 0)
    return refused("bad_value");
  return {true, {}};
}

double Controller::Impl::manual_feed(std::size_t axis) const {
  const machine::Axis& limits = machine.axes[axis];
  const double all = data.parameter("1423", kManualFeed_mm_min);
  return std::min(data.parameter(number_of_axis("1423", limits.name), all), limits.rapid_mm_min);
}

double Controller::Impl::hand_position(std::size_t axis) {
  return (hand_moving >> axis & 1) != 0 ? hand_goal[axis] : standing()[axis];
}

double Controller::Impl::hand_offset(std::size_t axis) {
  const RealtimeState& now = realtime.state();
  return now.periods >= set_since + 2 ? now.hand_offset[axis] : 0;
}

AxisVector Controller::Impl::standing() {
  // A held kernel stands somewhere on its way, otherwise at the end of it.
  AxisVector at = held() ? realtime.state().base : feed.position();
  for (std::size_t i = 0; i < machine.axes.size(); ++i) at[i] += hand_offset(i);
  return at;
}

/// Acceleration by the controller's parameters; a rapid jog is accelerated like positioning.
void Controller::Impl::shape_by_hand(std::size_t axis, MotionKind kind, HandOrder& order) const {
  const auto hand = AccelerationRules::read(machine, data)
                        .of_hand(axis, order.rapid ? MotionKind::rapid : kind, order.speed_mm_s);
  order.acceleration_mm_s2 = hand.acceleration_mm_s2;
  order.bell_s = hand.bell_s;
}

void Controller::Impl::move_by_hand(std::size_t axis, const HandOrder& order) {
  realtime.hand().order(axis, order);
  hand_goal[axis] = order.target;
  hand_moving |= 1u << axis;
  hand_stopped &= ~(1u << axis);
  if (phase == Phase::idle) phase = Phase::manual;
}

CommandResult Controller::Impl::jog(std::size_t axis, int direction, JogSpeed speed) {
  if (direction == 0) {
    if ((hand_moving >> std::min<std::size_t>(axis, 31) & 1) != 0) {
      realtime.hand().order(axis, {});
      hand_stopped |= 1u << axis;
    }
    return {true, {}};
  }
  if (const CommandResult may = may_move_by_hand(axis, Mode::jog); !may.accepted) return may;
  const machine::Axis& limits = machine.axes[axis];
  const double least = axes::kStopBeforeLimit_mm;
  HandOrder order;
  order.kind = HandOrder::Kind::go;
  order.target = reach(axis, direction);
  if (order.target == limits.max_mm || order.target == limits.min_mm) order.target -= direction * least;
  if ((order.target - hand_position(axis)) * direction <= kThere_mm) return refused("travel_limit");
  const bool known = (realtime.homed.load() >> axis & 1) != 0;
  // Before reference return there is no rapid by hand (0i-D No. 1401#0).
  order.rapid = speed == JogSpeed::rapid && (known || data.bit("1401#0"));
  const double rapid = data.parameter(number_of_axis("1424", limits.name), limits.rapid_mm_min);
  order.speed_mm_s = (order.rapid ? std::min(rapid, limits.rapid_mm_min) : manual_feed(axis)) / 60;
  shape_by_hand(axis, MotionKind::jog, order);
  move_by_hand(axis, order);
  return {true, {}};
}

CommandResult Controller::Impl::step(std::size_t axis, double distance_mm) {
  const Mode needed = mode == Mode::handle ? Mode::handle : Mode::jog;
  if (const CommandResult may = may_move_by_hand(axis, needed); !may.accepted) return may;
  if (!std::isfinite(distance_mm)) return refused("bad_value");
  if ((hand_stopped >> axis & 1) != 0) return refused("running");
  const double target = hand_position(axis) + distance_mm;
  if (distance_mm == 0) return {true, {}};
  const int direction = distance_mm > 0 ? 1 : -1;
  if ((reach(axis, direction) - target) * direction < 0) return refused("travel_limit");
  HandOrder order;
  order.kind = HandOrder::Kind::go;
  order.target = target;
  order.speed_mm_s = manual_feed(axis) / 60;
  shape_by_hand(axis, mode == Mode::handle ? MotionKind::handle : MotionKind::jog, order);
  move_by_hand(axis, order);
  return {true, {}};
}

CommandResult Controller::Impl::reference(std::size_t axis) {
  if (const CommandResult may = may_move_by_hand(axis, Mode::reference); !may.accepted) return may;
  if (held()) return refused("running");
  if ((hand_moving >> axis & 1) != 0) return refused("running");
  const machine::Axis& limits = machine.axes[axis];
  HandOrder order;
  order.rapid = true;
  order.speed_mm_s = limits.rapid_mm_min / 60;
  order.target = limits.reference_mm;
  order.kind = HandOrder::Kind::go;
  if ((realtime.homed.load() >> axis & 1) == 0) {
    order.kind = HandOrder::Kind::home;
    order.speed_mm_s =
        std::min(data.parameter(number_of_axis("1428", limits.name), limits.rapid_mm_min), limits.rapid_mm_min) / 60;
  } else if (order.target == hand_position(axis)) {
    return {true, {}};
  } else {
    const int direction = order.target > hand_position(axis) ? 1 : -1;
    const double reached = reach(axis, direction);
    const bool zone_on_the_way = reached != (direction > 0 ? limits.max_mm : limits.min_mm);
    if (zone_on_the_way && (reached - order.target) * direction < 0) return refused("travel_limit");
  }
  move_by_hand(axis, order);
  return {true, {}};
}

CommandResult Controller::Impl::move_plc_axis(std::size_t axis, double target_mm, double feed_mm_min) {
  if (emergency) return refused("emergency_stop");
  if (alarmed() || phase == Phase::aborting) return refused("alarm");
  if (axis >= machine.axes.size() || (plc_axes >> axis & 1) == 0) return refused("bad_value");
  const machine::Axis& limits = machine.axes[axis];
  if (!(target_mm >= limits.min_mm && target_mm <= limits.max_mm)) return refused("travel_limit");
  if (!(feed_mm_min > 0)) return refused("bad_value");
  HandOrder order;
  order.kind = HandOrder::Kind::go;
  order.target = target_mm;
  order.speed_mm_s = std::min(feed_mm_min, limits.rapid_mm_min) / 60;
  realtime.hand().order(axis, order);
  return {true, {}};
}

/// Feed hold while hands move: everything of theirs stops.
void Controller::Impl::stop_hands() {
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    if ((hand_moving >> i & 1) == 0) continue;
    realtime.hand().order(i, {});
    hand_stopped |= 1u << i;
  }
  returning = false;
}

bool Controller::Impl::hands_done(std::uint32_t axes) {
  const RealtimeState& now = realtime.state();
  return now.hand_orders == realtime.hand().orders() && (now.hand_busy & axes) == 0;
}

bool Controller::Impl::displaced() {
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    if (hand_offset(i) != 0 && (plc_axes >> i & 1) == 0) return true;
  return false;
}

/// All axes stand: the kernel is given where they do. @return false while that is under way.
bool Controller::Impl::take_over_hands() {
  if (!std::exchange(parking, true)) {
    realtime.request_park();
    return false;
  }
  if (!realtime.parked()) return false;
  parking = false;
  const RealtimeState& now = realtime.state();
  AxisVector standing = now.base;
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    if ((plc_axes >> i & 1) != 0) continue;
    standing[i] += now.hand_offset[i];
    // Where it was sent, without the rounding of base and offset.
    if ((hand_moving >> i & 1) != 0 && std::abs(standing[i] - hand_goal[i]) < 1e-9)
      standing[i] = hand_goal[i];
    if ((now.marks_found >> i & 1) != 0) standing[i] = machine.axes[i].reference_mm;
  }
  kernel.set_position(standing);
  feed.set_position(standing);
  interpreter.set_position(standing);
  realtime.homed |= now.marks_found;
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    if ((now.home_failed >> i & 1) != 0) {
      const MachineAlarm alarm = homing_alarm();
      raise(std::string(alarm.code), std::string(1, machine.axes[i].name), {}, alarm);
    }
  set_since = now.periods;
  realtime.unpark(standing, ~plc_axes, now.marks_found);
  hand_moving = hand_stopped = 0;
  return true;
}

bool Controller::Impl::work_manual() {
  if (await == Await::tap) {  // pulling a tap out
    realtime.planned();
    if (!realtime.idle()) return false;
    await = Await::nothing;
  }
  if (!parking && !hands_done(~plc_axes)) {
    const RealtimeState& now = realtime.state();
    for (std::size_t i = 0; i < machine.axes.size(); ++i)
      if (now.hand_orders == realtime.hand().orders() && (now.hand_busy >> i & 1) == 0) {
        hand_moving &= ~(1u << i);
        hand_stopped &= ~(1u << i);
      }
    return false;
  }
  if (!take_over_hands()) return false;
  phase = Phase::idle;
  state_changed();
  return false;
}

/// Cycle start after an intervention: back to where the program was left.
void Controller::Impl::go_back() {
  const double feed_mm_min = data.parameter("1410", FeedRules{}.dry_run_mm_min);
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    if ((plc_axes >> i & 1) != 0 || machine.axes[i].follows != 0) continue;
    HandOrder order;
    order.kind = HandOrder::Kind::go_back;
    order.speed_mm_s = std::min(feed_mm_min, machine.axes[i].rapid_mm_min) / 60;
    realtime.hand().order(i, order);
    hand_moving |= 1u << i;
  }
  hand_stopped = 0;
  returning = true;
}

/// In a held program: hands that have come to rest, and the way back.
bool Controller::Impl::work_return() {
  if (!hands_done(~plc_axes)) return false;
  hand_moving = hand_stopped = 0;
  if (!returning) return false;
  returning = false;
  go_on();
  state_changed();
  return true;
}

double Controller::Impl::retrace_feed_mm_s() const {
  return data.parameter("1410", FeedRules{}.dry_run_mm_min) / 60;
}

CommandResult Controller::Impl::retrace_way(double way_mm) {
  if (emergency) return refused("emergency_stop");
  if (alarmed() || phase == Phase::faulted) return refused("alarm");
  if (!held() || mode != Mode::handle) return refused("wrong_mode");
  if (!std::isfinite(way_mm)) return refused("bad_value");
  const RealtimeState& now = realtime.state();
  if (retracing || now.kernel_moving || hand_moving != 0 || displaced()) return refused("running");
  if (!retrace.active() && !retrace.begin(now.sample.tag, now.base)) return refused("nothing_to_retrace");
  if (!retrace.go(way_mm, retrace_feed_mm_s())) return refused("nothing_to_retrace");
  retracing = true;
  retrace_since = now.periods;
  realtime.second_kernel = retrace.kernel();
  return {true, {}};
}

void Controller::Impl::end_retrace() {
  realtime.second_kernel = nullptr;
  retrace.end();
}

bool Controller::Impl::work_retrace() {
  const RealtimeState& now = realtime.state();
  // Two periods: the state must have been made after the way was given.
  if (now.periods < retrace_since + 2 || !now.second_done) return false;
  retracing = false;
  retrace.stopped(now.second_tag, now.second_position);
  if (!std::exchange(returning, false)) return false;
  end_retrace();
  go_on();
  state_changed();
  return true;
}

CommandResult Controller::Impl::tap_retract() {
  if (emergency) return refused("emergency_stop");
  if (alarmed() || phase == Phase::faulted) return refused("alarm");
  if (phase != Phase::idle) return refused("running");
  if (!realtime.state().tap_in_hole) return refused("nothing_to_retract");
  Interlude interlude;
  interlude.kind = Interlude::Kind::tap;
  interlude.tap = last_tap;
  interlude.tap.out_only = true;
  interlude.tap.start = interlude.tap.end;
  await = Await::tap;
  phase = Phase::manual;
  realtime.post(interlude);
  realtime.planned();
  return {true, {}};
}

}  // namespace headstock::operation

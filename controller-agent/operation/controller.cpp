// The public face and what people ask for: every command is answered at once, accepted or refused with a
// reason.
#include "operation/controller.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "dialects/dialect.hpp"
#include "operation/controller_impl.hpp"
#include "plc/built_in.hpp"

namespace headstock::operation {
namespace {

/// Who may give a command. The default is: the panel always, the network when armed.
enum class Right : std::uint8_t { panel_or_armed, anyone, panel_only };
struct Rule {
  Action action;
  Right right;
};
constexpr Rule kRules[] = {
    {Action::cycle_start, Right::panel_or_armed},
    {Action::feed_hold, Right::anyone},  // stopping is always allowed
    {Action::reset, Right::panel_or_armed},
    {Action::emergency_stop, Right::anyone},
    {Action::emergency_stop_release, Right::panel_only},
    {Action::arm_remote, Right::panel_only},
    {Action::disarm_remote, Right::anyone},
    {Action::set_mode, Right::panel_or_armed},
    {Action::set_feed_override, Right::panel_or_armed},
    {Action::set_rapid_override, Right::panel_or_armed},
    {Action::set_spindle_override, Right::panel_or_armed},
    {Action::set_single_block, Right::panel_or_armed},
    {Action::set_optional_stop, Right::panel_or_armed},
    {Action::set_block_skip, Right::panel_or_armed},
    {Action::set_dry_run, Right::panel_or_armed},
    {Action::set_machine_lock, Right::panel_only},
    {Action::set_parts_required, Right::anyone},
    {Action::reset_parts, Right::anyone},
    {Action::set_axis_lock, Right::panel_only},
    {Action::set_manual_absolute, Right::panel_only},
    {Action::tap_retract, Right::panel_only},
};

Right right_for(Action action) {
  const auto* rule =
      std::find_if(std::begin(kRules), std::end(kRules), [&](const Rule& r) { return r.action == action; });
  return rule == std::end(kRules) ? Right::panel_only : rule->right;
}

struct Range {
  double least, most;
};
constexpr double kUnmoved_mm = 0.001;
constexpr Range kFeedOverride{0, motion::kMaxOverride}, kRapidOverride{0, 1}, kSpindleOverride{0.5, 1.2};

const dialects::Dialect& dialect_of(const machine::Machine& machine) {
  if (machine.axes.empty()) throw std::invalid_argument("the machine has no axes");
  const dialects::Dialect* dialect = dialects::find(machine.profile);
  if (!dialect) throw std::invalid_argument("no such controller profile: '" + machine.profile + "'");
  return *dialect;
}

std::int64_t system_now_ms() {
  using namespace std::chrono;
  return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

std::unique_ptr<axes::Drive> drive_or_default(ControllerOptions& options, const machine::Machine& machine) {
  if (options.drive) return std::move(options.drive);
  return axes::make_drive(machine);
}

std::unique_ptr<plc::Auxiliary> functions_or_default(ControllerOptions& options,
                                                     const machine::Machine& machine) {
  if (options.functions) return std::move(options.functions);
  const machine::Spindle& spindle = machine.spindle;
  const bool contour = spindle.contour_axis != 0;
  return std::make_unique<plc::BuiltIn>(
      plc::Times{}, plc::SpindleCodes{spindle.orient_m, contour ? spindle.contour_on_m : 0,
                                      contour ? spindle.contour_off_m : 0});
}

/// Axes for which `is` holds; bit: axis.
template <typename Is>
std::uint32_t axes_where(const machine::Machine& machine, Is is) {
  std::uint32_t mask = 0;
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    if (is(machine.axes[i])) mask |= 1u << i;
  return mask;
}

AxisVector reference_position(const machine::Machine& machine) {
  AxisVector position{};
  for (std::size_t i = 0; i < machine.axes.size(); ++i) position[i] = machine.axes[i].reference_mm;
  return position;
}

}  // namespace

Controller::Impl::Impl(machine::Machine machine_in, interp::MachineData data_in, ControllerOptions options)
    : machine(std::move(machine_in)),
      data(std::move(data_in)),
      now_ms(options.now_ms ? std::move(options.now_ms) : system_now_ms),
      kernel(machine),
      realtime(machine, kernel, tags, drive_or_default(options, machine),
               functions_or_default(options, machine)),
      macro_environment(realtime, retained, waiting, period_s()),
      interpreter(dialect_of(machine), machine, data, &programs),
      feed(machine, kernel, tags),
      retrace(machine),
      plc_axes(axes_where(machine, [](const machine::Axis& axis) { return axis.plc; })),
      switches(options.switches),
      skip_input(options.skip_input || machine.skip_input),
      retained(options.retained) {
  const AxisVector home = reference_position(machine);
  feed.set_history(&retrace);
  kernel.set_position(home);
  feed.set_position(home);
  realtime.homed =
      ~axes_where(machine, [](const machine::Axis& axis) { return axis.homing == machine::Homing::dog; });
  realtime.feed_override = retained.feed_override;
  realtime.rapid_override = retained.rapid_override;
  realtime.spindle_override = retained.spindle_override;
  interpreter.set_environment(&macro_environment);
  interpreter.set_switches(switches);
  interpreter.reset(home);
  mirror_unseen = true;
  (void)mirror_place_unknown();
  if (std::exchange(retained.run_open, false))
    emit(RunEnded{retained.last_run, "interrupted", std::nan(""), std::nan(""), retained.parts_total, {}});
  interpreter.on_data_change([this](const interp::DataChange& change) {
    emit(OffsetChanged{change, std::string(change.source)});
    if (change.what == "tool_life/change_due" && change.after != 0) {
      const MachineAlarm text = tool_life_message();
      raise(std::string(text.code), {}, last_block, text, true);
    }
  });
}

CommandResult Controller::Impl::command(const Command& command) {
  const Right right = right_for(command.action);
  if (command.origin == Origin::network) {
    if (right == Right::panel_only) return refused("panel_only");
    if (right == Right::panel_or_armed && !armed) return refused("not_armed");
  }
  const bool on = command.value != 0;
  const auto set_override = [&](std::atomic<double>& target, double& kept, Range range) {
    if (!(command.value >= range.least && command.value <= range.most)) return refused("bad_value");
    target = kept = command.value;
    run_record.overrides(retained.feed_override, retained.rapid_override, retained.spindle_override);
    return accepted();
  };
  const auto set_switch = [&](bool& target) {
    target = on;
    switches.optional_stop = optional_stop;
    switches.block_skip = block_skip ? ~0u : 0u;
    interpreter.set_switches(switches);
    return accepted();
  };
  switch (command.action) {
    case Action::cycle_start:
      if (!run_open) run_by = command.user;
      return cycle_start(command.origin);
    case Action::feed_hold:
      if (phase == Phase::running && !realtime.hold.exchange(true)) ++run_record.holds;
      if (hand_moving != 0) stop_hands();
      if (retracing) {
        retrace.kernel()->abort();
        returning = false;
      }
      return accepted();
    case Action::reset:
      return reset();
    case Action::emergency_stop:
      return emergency_stop();
    case Action::emergency_stop_release:
      return release_emergency_stop();
    case Action::arm_remote:
      if (emergency) return refused("emergency_stop");
      if (alarmed()) return refused("alarm");
      armed = true;
      selection.unseen = false;
      return accepted();
    case Action::disarm_remote:
      armed = false;
      return accepted();
    case Action::set_mode:
      return set_mode(command.value);
    case Action::set_feed_override:
      return set_override(realtime.feed_override, retained.feed_override, kFeedOverride);
    case Action::set_rapid_override:
      return set_override(realtime.rapid_override, retained.rapid_override, kRapidOverride);
    case Action::set_spindle_override:
      return set_override(realtime.spindle_override, retained.spindle_override, kSpindleOverride);
    case Action::set_single_block:
      single_block = on;
      realtime.single_block = on;
      return accepted();
    case Action::set_optional_stop:
      return set_switch(optional_stop);
    case Action::set_block_skip:
      return set_switch(block_skip);
    case Action::set_dry_run:
      if (busy()) return refused("running");
      return set_switch(dry_run);
    case Action::set_machine_lock:
      if (phase != Phase::idle || emergency) return refused("running");
      if (on) {
        realtime.machine_lock = true;
      } else if (realtime.machine_lock) {
        // The shown positions have wandered off; the axes have not: the controller takes up where they stand.
        phase = Phase::aborting;
        unlocked = true;
        realtime.request_abort();
      }
      return accepted();
    case Action::set_axis_lock: {
      if (phase != Phase::idle || emergency) return refused("running");
      const double most = std::pow(2.0, static_cast<double>(machine.axes.size())) - 1;
      if (!(command.value >= 0 && command.value <= most)) return refused("bad_value");
      const auto mask = static_cast<std::uint32_t>(command.value);
      const std::uint32_t before = realtime.axis_lock;
      if ((before & ~mask) != 0) {  // as with the machine lock: taken up where the axes stand
        phase = Phase::aborting;
        unlocked_axes = before & ~mask;
        realtime.request_abort();
      }
      realtime.axis_lock = before | mask;
      return accepted();
    }
    case Action::set_manual_absolute:
      manual_absolute = on;
      return accepted();
    case Action::tap_retract:
      return tap_retract();
    case Action::set_parts_required:
      if (!(command.value >= 0 && command.value <= 999'999'999)) return refused("bad_value");
      retained.parts_required = static_cast<std::uint64_t>(command.value);
      return accepted();
    case Action::reset_parts:
      retained.parts = 0;
      return accepted();
  }
  return refused("unknown_command");
}

CommandResult Controller::Impl::reset() {
  if (alarmed())
    armed = false;  // after an alarm a person looks at the machine before anything starts from afar
  if (!emergency) clear_alarms(false);
  finish_run("reset");
  message.clear();
  trip_reset = tripped && !emergency;
  drop_park();
  returning = false;
  phase = Phase::aborting;
  realtime.request_abort();
  return accepted();
}

CommandResult Controller::Impl::emergency_stop() {
  realtime.emergency_stop = true;
  if (emergency) return accepted();
  emergency = true;
  armed = false;
  finish_run("reset");
  drop_park();
  returning = releasing = false;
  phase = Phase::aborting;
  realtime.request_abort();
  return accepted();
}

CommandResult Controller::Impl::release_emergency_stop() {
  if (!emergency) return refused("no_emergency_stop");
  if (phase == Phase::aborting) return refused("resetting");
  emergency = false;
  clear_alarms(false);
  const RealtimeState& now = realtime.state();
  const AxisVector& commanded = feed.position();
  bool moved = false;
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    moved = moved || std::abs(now.actual[i] - commanded[i]) > kUnmoved_mm;
  if (!moved) {
    realtime.emergency_stop = false;
    tripped = false;
    return accepted();
  }
  // The axes may have been moved while the drives were off: they are taken up where they stand, then the
  // drives go on.
  releasing = true;
  phase = Phase::aborting;
  realtime.request_abort();
  return accepted();
}

CommandResult Controller::Impl::set_mode(double value) {
  const auto to_hand = [&] {  // a hand may intervene in a held program, and the program be gone on with
    const auto wanted = static_cast<Mode>(static_cast<int>(value));
    return wanted == run_mode || wanted == Mode::jog || wanted == Mode::handle;
  };
  if (busy() && !(held() && value >= 0 && hand_moving == 0 && !retracing && to_hand()))
    return refused("running");
  if (!(value >= 0 && value <= static_cast<double>(Mode::remote)) || value != static_cast<int>(value))
    return refused("bad_value");
  mode = static_cast<Mode>(static_cast<int>(value));
  return accepted();
}

bool Controller::Impl::alarmed() const {
  return std::any_of(alarms.begin(), alarms.end(), [](const ActiveAlarm& alarm) { return !alarm.message; });
}

// ---- the public face

Controller::Controller(machine::Machine machine, interp::MachineData data, ControllerOptions options)
    : impl_(std::make_unique<Impl>(std::move(machine), std::move(data), std::move(options))) {}
Controller::~Controller() = default;

CommandResult Controller::command(const Command& command) {
  // Stopping does not wait for the lock.
  if (command.action == Action::emergency_stop) impl_->realtime.emergency_stop = true;
  Access access(impl_->lock, impl_->waiting);
  CommandResult result = impl_->command(command);
  impl_->state_changed();
  if (impl_->wake_storage) impl_->wake_storage();
  return result;
}

CommandResult Controller::select(std::string name, std::string revision_hash,
                                 std::shared_ptr<program::Programs> memory, Origin origin) {
  auto source = memory ? memory->open_name(name) : nullptr;
  if (!source) return refused("not_found");
  Selection selection;
  selection.bytes = measure(*source);
  selection.name = std::move(name);
  selection.revision_hash = std::move(revision_hash);
  selection.memory = std::move(memory);
  Access access(impl_->lock, impl_->waiting);
  return impl_->select(std::move(selection), Mode::memory, origin);
}

CommandResult Controller::select_stream(std::string name, std::string revision_hash,
                                        std::unique_ptr<program::Source> stream, std::uint64_t total_bytes,
                                        Origin origin, std::function<std::string()> why_broken) {
  if (!stream || name.empty()) return refused("bad_value");
  Selection selection;
  selection.name = std::move(name);
  selection.revision_hash = std::move(revision_hash);
  selection.stream = std::move(stream);
  selection.is_stream = true;
  selection.why_broken = std::move(why_broken);
  selection.bytes = total_bytes;
  Access access(impl_->lock, impl_->waiting);
  return impl_->select(std::move(selection), Mode::remote, origin);
}

CommandResult Controller::jog(std::size_t axis, int direction, JogSpeed speed) {
  Access access(impl_->lock, impl_->waiting);
  return impl_->jog(axis, direction, speed);
}
CommandResult Controller::retrace(double way_mm) {
  Access access(impl_->lock, impl_->waiting);
  return impl_->retrace_way(way_mm);
}
CommandResult Controller::move_plc_axis(std::size_t axis, double target_mm, double feed_mm_min) {
  Access access(impl_->lock, impl_->waiting);
  return impl_->move_plc_axis(axis, target_mm, feed_mm_min);
}
CommandResult Controller::step_axis(std::size_t axis, double distance_mm) {
  Access access(impl_->lock, impl_->waiting);
  return impl_->step(axis, distance_mm);
}
CommandResult Controller::reference_return(std::size_t axis) {
  Access access(impl_->lock, impl_->waiting);
  return impl_->reference(axis);
}
CommandResult Controller::enter_mdi(std::string text) {
  Access access(impl_->lock, impl_->waiting);
  return impl_->mdi(std::move(text));
}
CommandResult Controller::restart(const std::optional<interp::RestartPoint>& point) {
  Access access(impl_->lock, impl_->waiting);
  CommandResult result = impl_->restart(point);
  impl_->state_changed();
  return result;
}
void Controller::set_skip_signals(std::uint16_t signals) noexcept {
  impl_->realtime.skip_signals = signals;
}

void Controller::set_interruption_signal(bool on) noexcept {
  impl_->interruption.set_signal(on);
}

void Controller::on_event(std::function<void()> wake) {
  Access access(impl_->lock, impl_->waiting);
  impl_->wake_storage = std::move(wake);
}

void Controller::link_lost() {
  Access access(impl_->lock, impl_->waiting);
  impl_->armed = false;
}

Live Controller::live() const {
  Access access(impl_->lock, impl_->waiting);
  return impl_->live();
}

Retained Controller::retained() const {
  Access access(impl_->lock, impl_->waiting);
  if (impl_->run_open) impl_->mark_breakpoint();
  return impl_->retained;
}

const machine::Machine& Controller::machine() const {
  return impl_->machine;
}

interp::MachineData Controller::data() const {
  Access access(impl_->lock, impl_->waiting);
  return impl_->data;
}

CommandResult Controller::edit_data(const std::function<void(interp::MachineData&)>& edit,
                                    const interp::DataChange& change, const std::string& origin) {
  Access access(impl_->lock, impl_->waiting);
  if (impl_->busy()) return refused("running");
  edit(impl_->data);
  ++impl_->data.version;
  (void)impl_->mirror_place_unknown();
  impl_->interpreter.data_edited();
  impl_->emit(OffsetChanged{change, origin});
  return accepted();
}

bool Controller::take_event(TimedEvent& out) {
  Access access(impl_->lock, impl_->waiting);
  if (impl_->events.empty()) return false;
  out = std::move(impl_->events.front());
  impl_->events.pop_front();
  return true;
}

void Controller::committed(std::uint64_t events) {
  Access access(impl_->lock, impl_->waiting);
  impl_->events_committed = std::max(impl_->events_committed, events);
}

bool Controller::work() {
  return impl_->work();
}
void Controller::step() noexcept {
  impl_->realtime.step();
}
void Controller::count_overruns(std::uint64_t periods) noexcept {
  impl_->realtime.overruns += periods;
}
const motion::Sample& Controller::sample() const noexcept {
  return impl_->realtime.now().sample;
}
axes::SimulatedSpindle& Controller::spindle() noexcept {
  return impl_->realtime.spindle();
}
double Controller::spindle_rpm() const noexcept {
  return impl_->realtime.now().spindle_rpm;
}
interp::SourcePosition Controller::traced_block() const {
  return impl_->tags.find(impl_->realtime.now().sample.tag).at;
}
void Controller::on_operation(std::function<void(const interp::Operation&)> observer) {
  impl_->observer = std::move(observer);
}
void Controller::on_move(std::function<void(const motion::Move&)> observer) {
  impl_->feed.on_move(std::move(observer));
}
bool Controller::cutting() const noexcept {
  return impl_->tags.find(impl_->realtime.now().sample.tag).cutting;
}

}  // namespace headstock::operation

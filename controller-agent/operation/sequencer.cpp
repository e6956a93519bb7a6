// The look-ahead: pulls canonical operations, turns moves into segments of the kernel, and lets happen
// between the moves what has to happen between them. Waits are states, never blocking calls.
#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "operation/controller_impl.hpp"
#include "operation/input_alarm.hpp"
#include "operation/macro_control.hpp"
#include "operation/overtravel_alarm.hpp"
#include "operation/unsupported.hpp"

namespace headstock::operation {
namespace {

constexpr int kOperationsAPiece = 256;
constexpr int kPlansAPiece = 64;
// After cycle start the first data may take a moment; once the axes have moved there is no waiting for more.
constexpr double kFirstDataWithin_s = 2.0;

const interp::SourcePosition& position_of(const interp::Operation& operation) {
  return std::visit([](const auto& o) -> const interp::SourcePosition& { return o.at; }, operation);
}

plc::Turning turning(interp::SpindleDirection direction) {
  switch (direction) {
    case interp::SpindleDirection::cw:
      return plc::Turning::clockwise;
    case interp::SpindleDirection::ccw:
      return plc::Turning::counterclockwise;
    case interp::SpindleDirection::stop:
      break;
  }
  return plc::Turning::stop;
}

Interlude function(const plc::Request& request) {
  Interlude interlude;
  interlude.kind = Interlude::Kind::function;
  interlude.request = request;
  return interlude;
}

}  // namespace

bool Controller::Impl::work() {
  while (waiting.load(std::memory_order_relaxed) > 0) std::this_thread::yield();
  std::lock_guard guard(lock);
  // Before anything changes the tool in use.
  if (const std::uint64_t cut = realtime.state().cutting_periods; cut != life_periods) {
    if (!realtime.machine_lock)
      interpreter.tool_cut_for(static_cast<double>(cut - life_periods) * period_s());
    life_periods = cut;
  }
  if (const std::uint32_t faults = realtime.state().faults; faults != faults_seen) {
    faults_seen = faults;
    machine_fault(realtime.state().fault);
  }
  if (phase == Phase::aborting) {
    if (!realtime.aborted()) return false;
    after_abort();
    state_changed();
    return phase != Phase::aborting;
  }
  if (phase == Phase::manual) return work_manual();
  if (phase == Phase::idle && displaced()) {  // a program that ran displaced is over
    if (hands_done(~plc_axes)) take_over_hands();
    return false;
  }
  if (retracing && work_retrace()) return true;
  if (hand_moving != 0 && work_return()) return true;
  if (phase != Phase::running) return false;
  const RealtimeState& now = realtime.state();
  if (now.block_stopped && now.go == realtime.go.load(std::memory_order_relaxed)) {
    phase = Phase::stopped;  // single block, in the middle of what is queued
    realtime.running = false;
    state_changed();
    return false;
  }

  const std::uint64_t tag_before = tags.newest();
  const Await await_before = await;
  if (await == Await::commit) {
    if (events_committed < commit_event) return false;
    finish_run("completed");
    phase = Phase::idle;
    realtime.running = false;
    await = Await::nothing;
    state_changed();
    return true;
  }
  calculating = false;
  if (await == Await::park) {
    if (!work_park()) return false;
  } else if (await == Await::interruption) {
    work_interruption();
  } else if (await == Await::search) {
    search_restart();
  } else if (await != Await::nothing && realtime.idle()) {
    interlude_done();
  }
  if (phase == Phase::running && await == Await::nothing) pull_operations();

  // Planning can be dear: at most a bounded number of pieces under the lock.
  bool more = true;
  for (int i = 0; i < kPlansAPiece && more; ++i) more = kernel.plan();
  planned = !more;
  if (planned && !realtime.idle()) realtime.planned();
  state_changed();
  return more || calculating || tags.newest() != tag_before || await != await_before;
}

void Controller::Impl::pull_operations() {
  for (int i = 0; i < kOperationsAPiece && await == Await::nothing && phase == Phase::running; ++i) {
    if (!has_operation && !next_approach()) {
      if (!feed.has_room(realtime.state().sample.tag)) return;
      if (wait_for_interruption()) return;
      switch (interpreter.next(operation)) {
        case interp::Pull::wait:
          feed.flush();
          data_ran_out();
          return;
        case interp::Pull::standstill:
          post(Await::standstill, {});
          return;
        case interp::Pull::pause:
          calculating = true;
          return;
        case interp::Pull::finished:  // an End or Alarm has been taken up before: nothing is left to do
          return;
        case interp::Pull::operation:
          break;
      }
      has_operation = true;
      wait_since_period = 0;
      brought_to_end = false;
      if (observer) observer(operation);
      if (!interruption.in_force && wait_for_interruption()) return;
    }
    const interp::SourcePosition& at = position_of(operation);
    if (single_block && !MacroControl(interpreter.macro_control()).no_single_block && last_block.line != 0 &&
        blocks_differ(last_block, at)) {
      last_block = {};
      post(Await::block_stop, {});
      return;
    }
    has_operation = false;
    new_block = last_block.line != 0 && blocks_differ(last_block, at);
    last_block = at;
    if (!programs.knows(at.program)) main_offset = at.byte_offset;
    take(operation);
  }
}

void Controller::Impl::take(const interp::Operation& taken) {
  if (const auto refused = unsupported_alarm(taken, machine, skip_input))
    return stop_with(*refused, position_of(taken), {});
  if (interpreter.interruption_enabled() && !machine.interruption_input)
    return stop_with(interruption_alarm(), position_of(taken), "M96");
  if (const auto* tap = std::get_if<interp::Tap>(&taken)) return take_tap(*tap);
  if (is_motion(taken)) {
    if (const auto refused = before_motion(taken)) return stop_with(*refused, position_of(taken), {});
    anything_moved = true;
    interruption.all_done = false;
    overtravel = feed.add(taken, main_offset);
    if (!overtravel) {
      const auto* probe = std::get_if<interp::Feed>(&taken);
      if (probe && probe->skip_signals != 0) post(Await::skip, {});
      return;
    }
    const char axis = machine.axes[overtravel->axis].name;
    raised_here = overtravel_alarm(machine.profile, axis, overtravel->positive);
    pending_alarm = {motion_of(taken).at, std::string(raised_here.code), std::string(1, axis)};
    post(Await::alarm, {});
    return;
  }
  if (const auto* dwell = std::get_if<interp::Dwell>(&taken)) {
    Interlude interlude;
    interlude.kind = Interlude::Kind::dwell;
    interlude.seconds = dwell->seconds;
    interlude.revolutions = dwell->revolutions;
    interlude.skip_signals = dwell->skip_signals;
    post(Await::dwell, interlude);
  } else if (const auto* spindle = std::get_if<interp::Spindle>(&taken)) {
    plc::Request request;
    request.kind = plc::FunctionKind::spindle;
    request.turning = turning(spindle->direction);
    request.speed = spindle->speed;
    request.constant_surface_speed = spindle->constant_surface_speed;
    request.clamp_rpm = spindle->clamp_rpm;
    request.surface_axis = spindle->surface_axis;
    post(Await::function, function(request));
  } else if (const auto* tool = std::get_if<interp::Tool>(&taken)) {
    plc::Request request;
    request.kind = plc::FunctionKind::tool;
    request.code = tool->tool;
    request.offset = tool->offset;
    post(Await::function, function(request));
  } else if (const auto* m = std::get_if<interp::MCode>(&taken)) {
    parts_due = m->clears_parts ? -1 : m->counts_part ? 1 : 0;
    if (m->clears_parts) return post(Await::standstill, {});
    if (m->input != 0 || m->at_axis >= 0 || m->delay_s != 0) {
      std::string detail(1, 'M');
      detail += std::to_string(m->code);
      return stop_with(port_code_alarm(), m->at, std::move(detail));
    }
    plc::Request request;
    request.code = m->code;
    post(Await::function, function(request));
  } else if (const auto* second = std::get_if<interp::SecondAuxiliary>(&taken)) {
    plc::Request request;
    request.kind = plc::FunctionKind::second_auxiliary;
    request.code = static_cast<std::int32_t>(second->code);
    post(Await::function, function(request));
  } else if (const auto* watch = std::get_if<interp::SpindleWatch>(&taken)) {
    Interlude interlude;
    interlude.kind = Interlude::Kind::watch;
    interlude.watch = {watch->on, watch->delay_s, watch->reached_ratio, watch->ratio, watch->width_rpm};
    post(Await::function, interlude);
  } else if (const auto* polygon = std::get_if<interp::PolygonTurning>(&taken)) {
    take_polygon(*polygon);
  } else if (const auto* contour = std::get_if<interp::ContourMode>(&taken)) {
    feed.set_look_ahead(contour->on);
  } else if (const auto* check = std::get_if<interp::StrokeCheck>(&taken)) {
    zone.reset();
    if (check->on && check->axes != 0)
      zone = axes::Zone{check->axes, check->least, check->most, check->outside_forbidden};
  } else if (const auto* text = std::get_if<interp::Message>(&taken)) {
    if (text->kind == interp::MessageKind::show) message = text->text;
  } else if (const auto* stop = std::get_if<interp::Stop>(&taken)) {
    if (!stop->optional || optional_stop) post(Await::program_stop, {});
  } else if (const auto* alarm = std::get_if<interp::Alarm>(&taken)) {
    pending_alarm = *alarm;
    raised_here = broken_input();
    if (!raised_here.code.empty()) pending_alarm.code = raised_here.code;
    post(Await::alarm, {});
  } else if (const auto* over = std::get_if<interp::End>(&taken)) {
    end = *over;
    // An alarm has been reported by its own operation; the end after it adds nothing.
    if (over->reason != interp::EndReason::alarm) post(Await::end, {});
  }
}

void Controller::Impl::stop_with(const MachineAlarm& alarm, const interp::SourcePosition& at,
                                 std::string detail) {
  raised_here = alarm;
  pending_alarm = {at, std::string(alarm.code), std::move(detail)};
  post(Await::alarm, {});
}

/// The alarm of the line that fed the program, when that is what ended it.
MachineAlarm Controller::Impl::broken_input() const {
  if (!main_window || !main_window->broken || !selection.why_broken) return {};
  return input_alarm(machine.profile, selection.why_broken());
}

void Controller::Impl::skip_over() {
  const motion::Sample sample = realtime.state().sample;
  const AxisVector standing = realtime.state().base;
  interpreter.skip_ended(sample.skipped ? sample.skip_position : standing, sample.skipped);
  if (!sample.skipped) return;
  // The signal's place is what the program reads; the axes stand where they came to rest.
  kernel.set_position(standing);
  feed.set_position(standing);
  interpreter.set_position(standing);
}

void Controller::Impl::post(Await what, Interlude interlude) {
  interlude.new_block = new_block && (what == Await::function || what == Await::dwell || what == Await::tap ||
                                      what == Await::program_stop || what == Await::end);
  const MacroControl control(interpreter.macro_control());
  interlude.new_block = interlude.new_block && !control.no_single_block;
  interlude.not_held = control.no_hold;
  interlude.not_awaited = control.no_wait;
  feed.finish();
  interlude.after_tag = feed.last_tag();
  await = what;
  realtime.post(interlude);
}

// The M code that counts parts, or clears the count, has been carried out.
void Controller::Impl::count_due_part() {
  const int due = std::exchange(parts_due, 0);
  if (due < 0) retained.parts = 0;
  if (due <= 0) return;
  ++retained.parts;
  ++retained.parts_total;
  emit(PartCounted{retained.parts, retained.parts_total, selection.name, selection.revision_hash,
                   last_cycle_s});
}

void Controller::Impl::interlude_done() {
  done_block = std::max(done_block, last_block.block);
  switch (std::exchange(await, Await::nothing)) {
    case Await::standstill:
      interpreter.carried_out(first_block_left());
      count_due_part();
      return;
    case Await::function:
      count_due_part();
      return;
    case Await::nothing:
    case Await::dwell:
    case Await::commit:
    case Await::park:
    case Await::interruption:
    case Await::search:
      return;
    case Await::tap:
      tap_done();
      return;
    case Await::polygon:
      polygon_let_go = !polygon_on;
      if (polygon_let_go) park();
      return;
    case Await::skip:
      skip_over();
      return;
    case Await::block_stop:
    case Await::program_stop:
      last_block = {};
      phase = Phase::stopped;
      realtime.running = false;
      return;
    case Await::alarm:
      phase = Phase::faulted;
      realtime.running = false;
      raise(pending_alarm.code, pending_alarm.detail, pending_alarm.at, raised_here);
      finish_run("alarm");
      reset_block = 0;  // all that was handed out has been carried out
      return;
    case Await::end:
      end_program();
      return;
  }
}

void Controller::Impl::data_ran_out() {
  if (realtime.hold) return;  // it stands already; said once
  const RealtimeState& now = realtime.state();
  if (wait_since_period == 0) wait_since_period = now.periods + 1;
  const double waited_s = static_cast<double>(now.periods + 1 - wait_since_period) * period_s();
  const motion::Sample& sample = now.sample;
  const bool all_traced =
      planned && !sample.moving &&
      (sample.starved || (sample.queue_empty && (feed.last_tag() == 0 || sample.tag == feed.last_tag())));
  // Two periods: the sample must have been made after the last data were planned.
  const bool ran_out = all_traced && now.periods > wait_since_period + 1;
  if (!ran_out || ((!anything_moved || programs.awaited()) && waited_s < kFirstDataWithin_s)) return;
  if (sample.starved && !brought_to_end) {
    // The look-ahead keeps the last corner open for the block behind it: what came whole is executed to its
    // end.
    brought_to_end = true;
    feed.finish();
    planned = false;
    return;
  }
  realtime.hold = true;
  ++run_record.holds;
  const MachineAlarm text = starved_message();
  raise(std::string(text.code), {}, last_block, text, true);
  wait_since_period = 0;
}

void Controller::Impl::end_program() {
  last_cycle_s = static_cast<double>(realtime.state().run_periods - run_periods_base) * period_s();
  if (!end.counts_part) {
    finish_run("completed");
    phase = Phase::idle;
    realtime.running = false;
    return;
  }
  ++retained.parts;
  ++retained.parts_total;
  emit(PartCounted{retained.parts, retained.parts_total, selection.name, selection.revision_hash,
                   last_cycle_s});
  commit_event = events_made;
  await = Await::commit;
}

void Controller::Impl::finish_run(const char* outcome) {
  if (!std::exchange(run_open, false)) return;
  mark_breakpoint();
  reset_block = std::string_view(outcome) == "completed" ? 0 : first_block_left();
  if (run_mode == Mode::memory && std::string_view(outcome) == "completed") retained.breakpoint = {};
  const RealtimeState& now = realtime.state();
  emit(RunEnded{retained.last_run, outcome,
                static_cast<double>(now.run_periods - run_periods_base) * period_s(),
                static_cast<double>(now.cutting_periods - cutting_periods_base) * period_s(),
                retained.parts_total, run_record});
}

void Controller::Impl::after_abort() {
  const RealtimeState& now = realtime.state();
  // Without power, or after a lock, only the measured position is true.
  const bool measured = emergency || releasing || tripped || unlocked || unlocked_axes != 0;
  if (measured && !now.drives_at_rest) return;
  AxisVector position = measured ? now.actual : now.sample.position;
  if (!emergency && !releasing && !tripped && !unlocked) {
    position = now.sample.position;
    for (std::size_t i = 0; i < machine.axes.size(); ++i)
      if ((unlocked_axes >> i & 1) != 0) position[i] = now.actual[i];
  }
  kernel.set_position(position);
  feed.set_position(position);
  interpreter.reset(position, std::exchange(reset_block, 0));
  realtime.hold = false;
  realtime.running = false;
  set_since = now.periods;
  realtime.abort_over();
  // Only now, when the commanded position is the measured one again, may the drives follow it.
  if (unlocked) realtime.machine_lock = false;
  if (unlocked_axes != 0) realtime.axis_lock &= ~unlocked_axes;
  if (releasing || trip_reset) {
    realtime.emergency_stop = emergency;
    tripped = false;
  }
  releasing = trip_reset = unlocked = false;
  unlocked_axes = 0;
  hand_moving = hand_stopped = 0;
  retracing = false;
  end_retrace();
  await = Await::nothing;
  parts_due = 0;
  has_operation = false;
  realtime.brake = false;
  interruption.forget();
  restarting = {};
  last_block = {};
  phase = Phase::idle;
}

}  // namespace headstock::operation

// What begins a program and what goes on with one: what is selected or offered from afar, what cycle start
// asks first, and everything that is set for a run.
#include <algorithm>
#include <string>
#include <utility>

#include "operation/controller_impl.hpp"
#include "operation/motion_alarm.hpp"

namespace headstock::operation {
namespace {

constexpr double kWholeWay_mm = 1e9;

}  // namespace

CommandResult Controller::Impl::select(Selection chosen, Mode wanted_mode, Origin origin) {
  if (busy()) return refused("running");
  chosen.unseen = origin == Origin::network && !armed;
  selection = std::move(chosen);
  mode = wanted_mode;
  main_window.reset();
  main_offset = 0;
  state_changed();
  return accepted();
}

CommandResult Controller::Impl::cycle_start(Origin origin) {
  if (emergency) return refused("emergency_stop");
  if (alarmed() || phase == Phase::faulted) return refused("alarm");
  if (phase == Phase::aborting) return refused("resetting");
  if (phase == Phase::manual || (phase == Phase::running && !realtime.hold)) return refused("running");
  if (phase != Phase::idle) return resume();
  if (mirror_place_unknown()) return refused("mirror_place");
  if (mode == Mode::mdi) {
    if (!mdi_block.memory) return refused("no_program");
    return start_run(mdi_block);
  }
  if (mode != Mode::memory && mode != Mode::remote) return refused("wrong_mode");
  if (selection.name.empty() || selection.is_stream != (mode == Mode::remote)) return refused("no_program");
  if (origin == Origin::panel && std::exchange(selection.unseen, false)) return refused("selected_remotely");
  return start_run(selection);
}

/// Mirror image by the setting (0i-D No.0012) holds from where the axis stood when it was switched on. Who
/// has not seen that must not guess it: the setting has to be taken off and put on again.
bool Controller::Impl::mirror_place_unknown() {
  bool on = data.bit("0012#0");
  for (const machine::Axis& axis : machine.axes) on = on || data.bit(std::string("0012#0/") + axis.name);
  mirror_unseen = mirror_unseen && on;
  return mirror_unseen;
}

/// From feed hold or a stop: the same run goes on.
CommandResult Controller::Impl::resume() {
  if (mode != run_mode) return refused("wrong_mode");
  if (restarting.found)
    if (const CommandResult may = may_go_to_restart(); !may.accepted) return may;
  if (returning || retracing || !hands_done(~plc_axes)) return refused("running");
  // What the program has left was looked at for where it leads without the hand's displacement.
  if (displaced() && !(manual_absolute ? way_back_is_free() : zones().empty()))
    return refused("travel_limit");
  restarting.found = false;
  restarting.report = {};
  clear_alarms(true);
  anything_moved = false;
  wait_since_period = 0;
  brought_to_end = false;
  message.clear();
  resume_with_go = resume_with_go || phase == Phase::stopped;
  if (retrace.active() && !retrace.at_hold()) {
    phase = Phase::running;
    realtime.hold = true;
    retrace.go(kWholeWay_mm, retrace_feed_mm_s());
    retrace_since = realtime.state().periods;
    retracing = returning = true;
    return accepted();
  }
  end_retrace();
  if (manual_absolute && displaced()) {
    phase = Phase::running;
    realtime.hold = true;
    go_back();
    return accepted();
  }
  go_on();
  return accepted();
}

void Controller::Impl::go_on() {
  if (std::exchange(resume_with_go, false)) ++realtime.go;
  phase = Phase::running;
  realtime.running = true;
  realtime.hold = false;
}

CommandResult Controller::Impl::start_run(Selection& chosen, const interp::RestartPoint* restart_at) {
  if (displaced()) return refused("resetting");  // a displaced program has just ended
  auto source = chosen.is_stream ? std::move(chosen.stream) : chosen.memory->open_name(chosen.name);
  if (!source) return refused(chosen.is_stream ? "no_program" : "not_found");

  main_window = std::make_shared<TextWindow>();
  programs.select(chosen.memory);
  switches.origin = &chosen == &mdi_block ? interp::ProgramOrigin::mdi
                    : chosen.is_stream    ? interp::ProgramOrigin::dnc
                                          : interp::ProgramOrigin::memory;
  interpreter.set_switches(switches);
  // The same bits in every run: lengths along the path are counted from its start.
  const AxisVector standing = feed.position();
  const AccelerationRules accelerations = AccelerationRules::read(machine, data);
  kernel.set_shapes(accelerations.shapes());
  kernel.set_position(standing);
  feed.set_position(standing);
  retrace.forget();
  auto text = windowed(std::move(source), main_window);
  restarting = {};
  if (restart_at == nullptr)
    interpreter.start(std::move(text), feed.position());
  else
    restarting.source = std::move(text);
  realtime.rapid_f0 = rapid_f0();
  feed.set_rules({dry_run, data.parameter("1410", FeedRules{}.dry_run_mm_min),
                  SpeedLimits::read(machine, data), CornerOverrideRules::read(data), accelerations});
  clear_alarms(true);
  if (accelerations.not_done() != shapes_said && !accelerations.not_done().empty())
    raise(std::string(acceleration_message().code), accelerations.not_done(), {}, acceleration_message(),
          true);
  shapes_said = accelerations.not_done();
  message.clear();
  await = Await::nothing;
  has_operation = anything_moved = false;
  last_block = {};
  done_block = reset_block = 0;
  tag_before_run = tags.newest();
  main_offset = wait_since_period = 0;
  brought_to_end = false;
  run_periods_base = realtime.state().run_periods;
  cutting_periods_base = realtime.state().cutting_periods;
  phase = Phase::running;
  run_mode = mode;
  resume_with_go = false;
  realtime.hold = false;
  realtime.running = restart_at == nullptr;
  run_open = true;
  run_record = RunRecord::begin(retained.feed_override, retained.rapid_override, retained.spindle_override);
  emit(RunStarted{++retained.last_run, chosen.name, chosen.revision_hash, retained.parts_total, run_by});
  if (&chosen == &mdi_block) mdi_block.memory.reset();  // once
  return accepted();
}

/// F0 (0i-D No. 1421): the slowest of the axes' rates, as a part of the rapid rate. 0 without the parameter:
/// the axes stand.
double Controller::Impl::rapid_f0() const {
  double least = 1;
  for (const machine::Axis& axis : machine.axes) {
    const double all = data.parameter("1421");
    least = std::min(least, data.parameter(std::string("1421/") + axis.name, all) / axis.rapid_mm_min);
  }
  return std::clamp(least, 0.0, 1.0);
}

}  // namespace headstock::operation

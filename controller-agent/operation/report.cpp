// What comes up: alarms, events that must not be lost, and the picture of one instant for the screens.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "dialects/catalogue.hpp"
#include "operation/controller_impl.hpp"

namespace headstock::operation {
namespace {

std::string g_code_name(std::int16_t tenths) {
  return tenths % 10 == 0 ? fmt::format("G{:02}", tenths / 10)
                          : fmt::format("G{:02}.{}", tenths / 10, tenths % 10);
}

std::string with_detail(std::string_view text, const std::string& detail) {
  return detail.empty() ? std::string(text) : fmt::format("{} ({})", text, detail);
}

}  // namespace

void Controller::Impl::raise(const std::string& code, const std::string& detail,
                             const interp::SourcePosition& at, const MachineAlarm& own_text,
                             bool is_message) {
  dialects::Alarm text = dialects::alarm_text(machine.profile, code);
  if (text.en == code && !own_text.en.empty()) {
    text.en = own_text.en;
    text.zh = own_text.zh;
  }
  ActiveAlarm alarm;
  alarm.id = ++retained.last_alarm;
  alarm.code = code;
  alarm.text_en = with_detail(text.en, detail);
  alarm.text_zh = with_detail(text.zh, detail);
  alarm.at = at;
  alarm.raised_ms = now_ms();
  alarm.message = is_message;
  alarms.push_back(alarm);
  if (!is_message) ++run_record.alarms;
  emit(AlarmRaised{alarm, block_text(at)});
}

void Controller::Impl::clear_alarms(bool messages_only) {
  std::erase_if(alarms, [&](const ActiveAlarm& alarm) {
    if ((messages_only && !alarm.message) || stays_until_switched_off(alarm)) return false;
    emit(AlarmCleared{alarm.id});
    return true;
  });
}

void Controller::Impl::emit(Event event) {
  events.push_back({now_ms(), std::move(event)});
  ++events_made;
  if (wake_storage) wake_storage();
}

void Controller::Impl::state_changed() {
  const State now = state();
  if (now == last_state && mode == last_mode) return;
  last_state = now;
  last_mode = mode;
  emit(StateChanged{now, mode});
}

State Controller::Impl::state() const {
  if (emergency) return State::emergency_stop;
  if (alarmed() || phase == Phase::faulted) return State::alarm;
  switch (phase) {
    case Phase::running:
      return realtime.hold ? State::hold : State::running;
    case Phase::stopped:
      return State::stopped;
    case Phase::aborting:  // braking after reset: not yet idle
      return State::hold;
    case Phase::idle:
    case Phase::manual:
    case Phase::faulted:
      break;
  }
  return State::idle;
}

std::string Controller::Impl::block_text(const interp::SourcePosition& at) const {
  if (at.line == 0) return {};
  if (programs.knows(at.program)) return programs.line_at(at.program, at.byte_offset);
  return main_window ? main_window->line_at(at.byte_offset) : std::string();
}

Live Controller::Impl::live() {
  const RealtimeState& now = realtime.state();
  const SegmentState& segment = tags.find(now.sample.tag);
  const bool in_run = phase == Phase::running || phase == Phase::stopped || phase == Phase::faulted;
  // Between moves (dwell, M code, stop) the block that is being carried out is the one taken up last, and it
  // is exact: nothing is taken up before what was before it is done.
  const bool traced = feed.last_tag() == 0 || (now.sample.tag == feed.last_tag() && now.sample.queue_empty);
  const bool between =
      in_run && await != Await::nothing && await != Await::block_stop && !now.sample.moving && traced;
  const interp::ModalSnapshot& modal = segment.tag != 0 && in_run ? segment.modal : interpreter.modal();

  Live live;
  live.mode = mode;
  live.state = state();
  live.remote_armed = armed;
  live.program_name = selection.name;
  live.program_bytes = selection.bytes;
  if (in_run) live.at = between || segment.tag == 0 ? last_block : segment.at;
  live.block = block_text(live.at);
  for (const std::int16_t code : modal.g)
    if (code >= 0) live.modal.push_back(g_code_name(code));
  live.tool = modal.tool;
  live.offset = modal.offset;
  AxisVector shown = realtime.machine_lock ? now.sample.position : now.actual;
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    if ((realtime.axis_lock.load() >> i & 1) != 0) shown[i] = now.sample.position[i];
  live.machine = shown;
  live.absolute = live.relative = interpreter.to_work(shown, modal);
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const machine::Axis& axis = machine.axes[i];
    live.axes.emplace_back(1, axis.name);
    const double factor = axis.designation == machine::Designation::diameter ? 2 : 1;
    live.distance_to_go[i] = in_run ? now.sample.distance_to_go[i] * factor : 0;
  }
  live.feed_actual_mm_min = now.sample.path_speed_mm_s * 60;
  live.feed_commanded = modal.feed;
  live.spindle_actual_rpm = now.spindle_rpm;
  live.spindle_commanded_rpm = now.spindle_commanded_rpm;
  live.feed_override = realtime.feed_override;
  live.rapid_override = realtime.rapid_override;
  live.spindle_override = realtime.spindle_override;
  live.single_block = single_block;
  live.optional_stop = optional_stop;
  live.block_skip = block_skip;
  live.dry_run = dry_run;
  live.machine_lock = realtime.machine_lock;
  live.parts = retained.parts;
  live.parts_required = retained.parts_required;
  live.parts_total = retained.parts_total;
  live.run_time_s = static_cast<double>(now.run_periods) * period_s();
  live.cutting_time_s = static_cast<double>(now.cutting_periods) * period_s();
  live.cycle_time_s =
      in_run ? static_cast<double>(now.run_periods - run_periods_base) * period_s() : last_cycle_s;
  live.last_cycle_s = last_cycle_s;
  if (selection.bytes > 0) {
    const std::uint64_t reached = between || segment.tag == 0 ? main_offset : segment.main_offset;
    live.progress =
        in_run ? std::min(1.0, static_cast<double>(reached) / static_cast<double>(selection.bytes)) : 0;
  } else {
    live.progress = -1;
  }
  live.alarms = alarms;
  live.periods = now.periods;
  live.overruns = realtime.overruns;
  live.message = message;
  live.axis_lock = realtime.axis_lock;
  live.homed = realtime.homed;
  live.manual_absolute = manual_absolute;
  live.displaced = displaced();
  live.restart = restarting.report;
  live.breakpoint = retained.breakpoint;
  live.tap_in_hole = now.tap_in_hole;
  live.coolant = now.machine.coolant || now.machine.mist;
  return live;
}

}  // namespace headstock::operation

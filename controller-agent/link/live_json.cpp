#include "link/live_json.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

namespace headstock::link {
namespace {

using namespace operation;
using nlohmann::json;

constexpr const char* kModes[] = {"edit", "memory", "mdi", "jog", "handle", "reference", "remote"};
constexpr const char* kStates[] = {"idle", "running", "hold", "stopped", "alarm", "emergency_stop"};
constexpr const char* kActions[] = {"cycle_start",
                                    "feed_hold",
                                    "reset",
                                    "emergency_stop",
                                    "emergency_stop_release",
                                    "arm_remote",
                                    "disarm_remote",
                                    "set_mode",
                                    "set_feed_override",
                                    "set_rapid_override",
                                    "set_spindle_override",
                                    "set_single_block",
                                    "set_optional_stop",
                                    "set_block_skip",
                                    "set_dry_run",
                                    "set_machine_lock",
                                    "set_parts_required",
                                    "reset_parts",
                                    "set_axis_lock",
                                    "set_manual_absolute",
                                    "tap_retract"};
static_assert(std::size(kModes) == static_cast<std::size_t>(Mode::remote) + 1);
static_assert(std::size(kStates) == static_cast<std::size_t>(State::emergency_stop) + 1);
static_assert(std::size(kActions) == static_cast<std::size_t>(Action::tap_retract) + 1);

/// JSON has no infinity: what is not a number is unknown.
json number(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

json text_or_null(const std::string& text) {
  return text.empty() ? json(nullptr) : json(text);
}

/// Most bytes of a block's text that are shown; a "block" can be a line of 10 MB.
constexpr std::size_t kMaxBlockText = 256;

/// Comments come in any code page; what goes out must be UTF-8 or it could not be sent at all.
std::string shown(const std::string& text) {
  std::string cut = text.substr(0, kMaxBlockText);
  for (char& c : cut)
    if (c == '\0') c = ' ';
  try {
    return json::parse(json(cut).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
  } catch (const json::exception&) {
    return {};
  }
}

json positions(const AxisVector& values, std::size_t count) {
  json list = json::array();
  for (std::size_t i = 0; i < std::min(count, values.size()); ++i) list.push_back(number(values[i]));
  return list;
}

json percent(double factor) {
  return number(std::round(factor * 1000) / 10);
}

json alarm_json(const ActiveAlarm& alarm) {
  return {{"id", alarm.id},
          {"code", shown(alarm.code)},
          {"text", {{"en", shown(alarm.text_en)}, {"zh", shown(alarm.text_zh)}}},
          {"since_ms", alarm.raised_ms},
          {"line", alarm.at.line},
          {"column", alarm.at.column},
          {"program", alarm.at.program ? json(std::string("O").append(std::to_string(alarm.at.program)))
                                       : json(nullptr)}};
}

struct ToKindAndBody {
  std::pair<const char*, json> operator()(const PartCounted& e) const {
    return {"part",
            {{"count", e.count},
             {"total", e.total},
             {"program", shown(e.program)},
             {"sha256", text_or_null(e.revision_hash)},
             {"cycle_s", number(e.cycle_s)}}};
  }
  std::pair<const char*, json> operator()(const AlarmRaised& e) const {
    json body = alarm_json(e.alarm);
    body["block"] = shown(e.block);
    return {"alarm", std::move(body)};
  }
  std::pair<const char*, json> operator()(const AlarmCleared& e) const {
    return {"alarm_cleared", {{"id", e.id}}};
  }
  std::pair<const char*, json> operator()(const RunStarted& e) const {
    return {"run_started",
            {{"run", e.run},
             {"program", shown(e.program)},
             {"sha256", text_or_null(e.revision_hash)},
             {"total", e.total},
             {"by", shown(e.by)}}};
  }
  std::pair<const char*, json> operator()(const RunEnded& e) const {
    return {"run_ended",
            {{"run", e.run},
             {"outcome", shown(e.outcome)},
             {"run_s", number(e.run_s)},
             {"cutting_s", number(e.cutting_s)},
             {"total", e.total},
             {"holds", e.record.holds},
             {"alarms", e.record.alarms},
             {"overrides",
              {{"feed", {percent(e.record.feed_least), percent(e.record.feed_most)}},
               {"rapid", {percent(e.record.rapid_least), percent(e.record.rapid_most)}},
               {"spindle", {percent(e.record.spindle_least), percent(e.record.spindle_most)}}}}}};
  }
  std::pair<const char*, json> operator()(const StateChanged& e) const {
    return {"state", {{"state", state_name(e.state)}, {"mode", mode_name(e.mode)}}};
  }
  std::pair<const char*, json> operator()(const OffsetChanged& e) const {
    return {"offset",
            {{"what", shown(e.change.what)},
             {"before", number(e.change.before)},
             {"after", number(e.change.after)},
             {"origin", shown(e.origin)},
             {"by", shown(e.by)},
             {"request", e.request}}};
  }
};

}  // namespace

const char* state_name(State state) {
  return kStates[static_cast<std::size_t>(state)];
}
const char* mode_name(Mode mode) {
  return kModes[static_cast<std::size_t>(mode)];
}
const char* action_name(Action action) {
  return kActions[static_cast<std::size_t>(action)];
}

bool action_from_name(const std::string& name, Action& action) {
  const auto* found = std::ranges::find(kActions, name);
  if (found == std::end(kActions)) return false;
  action = static_cast<Action>(found - std::begin(kActions));
  return true;
}

namespace {

json breakpoint_json(const operation::Breakpoint& at) {
  if (at.program.empty() || at.block == 0) return nullptr;
  return {{"program", shown(at.program)}, {"block", at.block}, {"sequence", at.sequence}, {"line", at.line}};
}

json restart_json(const operation::RestartReport& restart, std::size_t axes) {
  if (!restart.found) return nullptr;
  return {{"block", restart.block},     {"sequence", restart.sequence},
          {"m", restart.m},             {"tool", restart.tool},
          {"offset", restart.offset},   {"spindle", number(restart.spindle)},
          {"turning", restart.turning}, {"machine_position", positions(restart.position, axes)}};
}

}  // namespace

json live_to_json(const Live& live, const std::string& program_sha256) {
  const std::size_t axes = live.axes.size();
  json alarms = json::array();
  for (const ActiveAlarm& alarm : live.alarms) alarms.push_back(alarm_json(alarm));
  json program = nullptr;
  if (!live.program_name.empty())
    program = {{"name", shown(live.program_name)}, {"sha256", text_or_null(program_sha256)}};
  const bool estimable = live.progress > 0.01 && live.progress <= 1 && live.cycle_time_s > 0;
  return {
      {"state", state_name(live.state)},
      {"mode", mode_name(live.mode)},
      {"remote_armed", live.remote_armed},
      {"program", std::move(program)},
      {"line", live.at.line},
      {"sequence", live.at.sequence},
      {"block", shown(live.block)},
      {"progress", live.progress < 0 ? json(nullptr) : number(live.progress)},
      {"cycle_s", number(live.cycle_time_s)},
      {"last_cycle_s", live.last_cycle_s > 0 ? number(live.last_cycle_s) : json(nullptr)},
      {"remaining_s", live.last_cycle_s > 0 && live.state == State::running
                          ? number(std::max(0.0, live.last_cycle_s - live.cycle_time_s))
                          : (estimable && live.state == State::running
                                 ? number(live.cycle_time_s / live.progress - live.cycle_time_s)
                                 : json(nullptr))},
      {"parts", {{"count", live.parts}, {"required", live.parts_required}, {"total", live.parts_total}}},
      {"run_time_s", number(live.run_time_s)},
      {"cutting_time_s", number(live.cutting_time_s)},
      {"axes", live.axes},
      {"absolute", positions(live.absolute, axes)},
      {"relative", positions(live.relative, axes)},
      {"machine_position", positions(live.machine, axes)},
      {"distance_to_go", positions(live.distance_to_go, axes)},
      {"feed",
       {{"actual_mm_min", number(live.feed_actual_mm_min)}, {"commanded", number(live.feed_commanded)}}},
      {"spindle",
       {{"actual_rpm", number(live.spindle_actual_rpm)},
        {"commanded_rpm", number(live.spindle_commanded_rpm)}}},
      {"tool", live.tool},
      {"offset", live.offset},
      {"modal", live.modal},
      {"overrides",
       {{"feed", percent(live.feed_override)},
        {"rapid", percent(live.rapid_override)},
        {"spindle", percent(live.spindle_override)}}},
      {"switches",
       {{"single_block", live.single_block},
        {"optional_stop", live.optional_stop},
        {"block_skip", live.block_skip},
        {"dry_run", live.dry_run},
        {"machine_lock", live.machine_lock}}},
      {"alarms", std::move(alarms)},
      {"breakpoint", breakpoint_json(live.breakpoint)},
      {"restart", restart_json(live.restart, axes)},
      {"periods", live.periods},
      {"overruns", live.overruns},
  };
}

NewEvent to_new_event(const TimedEvent& event) {
  auto [kind, body] = std::visit(ToKindAndBody{}, event.event);
  return {event.at_ms, kind, body.dump()};
}

}  // namespace headstock::link

#include "server/fleet/live_table.hpp"

#include "db/time.hpp"
#include "server/fleet/fleet.hpp"

namespace headstock::fleet {

using nlohmann::json;

namespace {

json time_or_null(const std::optional<std::int64_t>& ms) {
  return ms ? json(db::iso_time(*ms)) : json(nullptr);
}

json text_or_null(const std::string& text) {
  return text.empty() ? json(nullptr) : json(text);
}

}  // namespace

bool is_current(const Entry& entry, std::int64_t now_ms) {
  return entry.connected && entry.received_ms && now_ms - entry.heard_ms < kSilenceMs &&
         now_ms - *entry.received_ms < kSilenceMs;
}

json alarm_json(const db::AlarmRow& alarm) {
  return {{"id", alarm.id},
          {"machine", alarm.machine},
          {"code", alarm.code},
          {"text", {{"en", alarm.text_en}, {"zh", alarm.text_zh}}},
          {"since", db::iso_time(alarm.raised_ms)},
          {"raised", db::iso_time(alarm.raised_ms)},
          {"cleared", time_or_null(alarm.cleared_ms)},
          {"line", alarm.line},
          {"column", alarm.column},
          {"program", text_or_null(alarm.program)},
          {"block", alarm.block}};
}

json part_json(const db::PartRow& part) {
  return {{"id", part.id},
          {"machine", part.machine},
          {"at", db::iso_time(part.at_ms)},
          {"program", part.program},
          {"sha256", text_or_null(part.sha256)},
          {"count", part.machine_count},
          {"total", part.machine_total},
          {"cycle_s", part.cycle_s}};
}

json run_json(const db::RunRow& run) {
  return {{"id", run.id},
          {"machine", run.machine},
          {"run", run.run},
          {"program", text_or_null(run.program)},
          {"sha256", text_or_null(run.sha256)},
          {"started", time_or_null(run.started_ms)},
          {"ended", time_or_null(run.ended_ms)},
          {"outcome", text_or_null(run.outcome)},
          {"run_s", run.run_s ? json(*run.run_s) : json(nullptr)},
          {"cutting_s", run.cutting_s ? json(*run.cutting_s) : json(nullptr)}};
}

json live_json(const Entry& entry, const std::map<std::string, KnownProgram>& programs, std::int64_t now_ms) {
  json live = entry.live.is_object() ? entry.live : json::object();
  live["machine"] = entry.machine.id;
  live["name"] = entry.machine.name;
  live["profile"] = entry.machine.profile;
  live["connected"] = entry.connected;
  live["received"] = time_or_null(entry.received_ms);
  live["age_ms"] =
      entry.received_ms ? json(std::max<std::int64_t>(0, now_ms - *entry.received_ms)) : json(nullptr);
  if (!is_current(entry, now_ms)) {
    // Everything else stays as last seen, with its age; the state and the permission must never look current.
    live["last_state"] = live.value("state", json(nullptr));
    live["state"] = entry.live.is_object() && entry.live.value("state", "") == "off" ? "off" : "unknown";
    live["remote_armed"] = false;
    live["trail"] = json::array();
  }
  if (auto program = live.find("program"); program != live.end() && program->is_object()) {
    const auto known = programs.find(
        program->value("sha256", json(nullptr)).is_string() ? program->value("sha256", "") : "");
    (*program)["id"] = known == programs.end() ? json(nullptr) : json(known->second.id);
    (*program)["revision"] = known == programs.end() ? json(nullptr) : json(known->second.revision);
    (*program)["released"] = known != programs.end() && known->second.released;
  }
  json alarms = json::array();
  for (const db::AlarmRow& alarm : entry.alarms) alarms.push_back(alarm_json(alarm));
  live["alarms"] = std::move(alarms);
  live["drip"] = entry.drip ? json{{"transfer", entry.drip->id},
                                   {"bytes", entry.drip->bytes},
                                   {"total", entry.drip->total},
                                   {"state", entry.drip->state},
                                   {"buffered", live.contains("drip") && live["drip"].is_object()
                                                    ? live["drip"].value("buffered", json(nullptr))
                                                    : json(nullptr)}}
                            : json(nullptr);
  return live;
}

}  // namespace headstock::fleet

#include "server/fleet/events.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "server/fleet/counts.hpp"
#include "server/fleet/event_body.hpp"
#include "server/fleet/event_times.hpp"
#include "server/fleet/states.hpp"
#include "server/fleet/values.hpp"

namespace headstock::fleet {
namespace {

using nlohmann::json;

constexpr std::size_t kLongestBody = 64u << 10;

using body::integer;
using body::maybe_integer;
using body::real;
using body::text;

/// One event on its way into the tables.
struct Context {
  db::Database& db;
  const db::EventRow& event;
  const json& body;
  Intake& intake;
};

void take_part(Context& c) {
  db::PartRow part;
  part.machine = c.event.machine;
  part.spool = c.event.spool;
  part.sequence = c.event.sequence;
  part.at_ms = c.event.at_ms;
  part.program = text(c.body, "program");
  part.sha256 = text(c.body, "sha256");
  part.machine_count = integer(c.body, "count");
  part.machine_total = integer(c.body, "total");
  part.cycle_s = real(c.body, "cycle_s").value_or(0);
  part.id = db::insert_part(c.db, part);
  c.intake.parts.push_back(std::move(part));
}

void take_alarm(Context& c) {
  db::AlarmRow alarm;
  alarm.machine = c.event.machine;
  alarm.spool = c.event.spool;
  alarm.sequence = c.event.sequence;
  alarm.alarm = integer(c.body, "id");
  alarm.code = text(c.body, "code");
  const json& texts = c.body.contains("text") ? c.body["text"] : c.body;
  alarm.text_en = text(texts, "en");
  alarm.text_zh = text(texts, "zh");
  alarm.line = integer(c.body, "line");
  alarm.column = integer(c.body, "column");
  alarm.program = text(c.body, "program");
  alarm.block = text(c.body, "block");
  alarm.raised_ms = c.event.at_ms;
  alarm.id = db::insert_alarm(c.db, alarm);
  c.intake.raised.push_back(std::move(alarm));
}

void take_alarm_cleared(Context& c) {
  if (const auto alarm =
          db::clear_alarm(c.db, c.event.machine, c.event.spool, integer(c.body, "id"), c.event.at_ms))
    c.intake.cleared.push_back(*alarm);
}

db::RunRow run_of(const Context& c) {
  db::RunRow run;
  run.machine = c.event.machine;
  run.spool = c.event.spool;
  run.run = integer(c.body, "run");
  return run;
}

void take_run_started(Context& c) {
  db::RunRow run = run_of(c);
  run.program = text(c.body, "program");
  run.sha256 = text(c.body, "sha256");
  run.started_ms = c.event.at_ms;
  run.total_start = maybe_integer(c.body, "total");
  run.by = text(c.body, "by");
  db::put_run_start(c.db, run);
  c.intake.runs.push_back(std::move(run));
}

void take_run_ended(Context& c) {
  db::RunRow run = run_of(c);
  run.outcome = text(c.body, "outcome");
  run.run_s = real(c.body, "run_s");
  run.cutting_s = real(c.body, "cutting_s");
  run.ended_ms = c.event.at_ms;
  run.total_end = maybe_integer(c.body, "total");
  run.holds = maybe_integer(c.body, "holds");
  run.alarms = maybe_integer(c.body, "alarms");
  if (const auto overrides = c.body.find("overrides"); overrides != c.body.end() && overrides->is_object())
    run.overrides_json = overrides->dump().substr(0, 1'000);
  db::put_run_end(c.db, run);
  c.intake.runs.push_back(std::move(run));
}

void take_state(Context& c) {
  const std::string state = text(c.body, "state");
  if (state.empty()) return;
  record_state(c.db, c.event.machine, state, text(c.body, "mode"), c.event.at_ms, Witness::machine);
  c.intake.states_changed = true;
}

void take_offset(Context& c) {
  record_change(c.db, c.event, c.body);
  c.intake.offsets_changed = true;
}

using Taker = void (*)(Context&);

const std::map<std::string, Taker, std::less<>>& takers() {
  static const std::map<std::string, Taker, std::less<>> table = {
      {"part", take_part},
      {"alarm", take_alarm},
      {"alarm_cleared", take_alarm_cleared},
      {"run_started", take_run_started},
      {"run_ended", take_run_ended},
      {"state", take_state},
      {"offset", take_offset},
  };
  return table;
}

/// Committed but not understood is better than refused for ever: the raw event stays, and can be read by a
/// later version.
void interpret(Context context) {
  const auto taker = takers().find(context.event.kind);
  if (taker == takers().end()) return;
  db::Transaction step(context.db);
  try {
    taker->second(context);
    step.commit();
  } catch (const json::exception& error) {
    context.intake.complaints.push_back(context.event.kind + " " + std::to_string(context.event.sequence) +
                                        ": " + error.what());
  }
}

}  // namespace

Intake take_in(db::Database& db, std::int64_t machine, const std::string& spool, const json& events,
               std::int64_t now_ms) {
  Intake intake;
  std::vector<const json*> in_order;
  if (events.is_array())
    for (const json& event : events)
      if (event.is_object() && integer(event, "seq") > 0) in_order.push_back(&event);
  std::ranges::stable_sort(in_order, {}, [](const json* event) { return integer(*event, "seq"); });

  db::Transaction transaction(db);
  const std::int64_t last = db::spool_sequence(db, machine, spool, now_ms);
  EventTimes times(db, machine, spool, now_ms);
  for (const json* event : in_order) {
    db::EventRow row;
    row.machine = machine;
    row.spool = spool;
    row.sequence = integer(*event, "seq");
    if (row.sequence <= last) continue;
    row.at_ms = times.of(row.sequence, integer(*event, "at_ms"));
    row.received_ms = now_ms;
    row.kind = text(*event, "kind");
    row.body = event->dump(-1, ' ', false, json::error_handler_t::replace).substr(0, kLongestBody);
    if (!db::insert_event(db, row)) continue;
    interpret({db, row, *event, intake});
  }
  intake.sequence = static_cast<std::uint64_t>(db::advance_spool(db, machine, spool));
  hold_against_each_other(db, machine, spool, last, static_cast<std::int64_t>(intake.sequence),
                          intake.raised);
  if (intake.offsets_changed) rebuild_offsets(db, machine, now_ms);
  times.tell(intake.raised, intake.cleared);
  transaction.commit();
  return intake;
}

}  // namespace headstock::fleet

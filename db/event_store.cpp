#include "db/event_store.hpp"

#include <algorithm>

#include "db/filter.hpp"

namespace headstock::db {
namespace {

constexpr const char* kPart =
    "SELECT id, machine_id, spool, sequence, at_ms, program, sha256, machine_count, machine_total, cycle_s "
    "FROM parts";
constexpr const char* kRun =
    "SELECT id, machine_id, spool, run, program, sha256, started_ms, ended_ms, outcome, run_s, cutting_s, "
    "total_start, total_end, holds, alarms, overrides_json, by_user FROM runs";
constexpr const char* kAlarm =
    "SELECT id, machine_id, spool, sequence, alarm, code, text_en, text_zh, line, column_number, program, "
    "block, raised_ms, "
    "cleared_ms FROM alarms";

const std::string kState = "SELECT id, machine_id, state, mode, source, from_ms, to_ms FROM state_intervals";

StateRow state_of(const Row& row) {
  return {row.integer(0), row.integer(1), row.text(2),         row.text(3),
          row.text(4),    row.integer(5), row.maybe_integer(6)};
}

PartRow part_of(const Row& row) {
  return {row.integer(0), row.integer(1), row.text(2),    row.integer(3), row.integer(4),
          row.text(5),    row.text(6),    row.integer(7), row.integer(8), row.real(9)};
}

RunRow run_of(const Row& row) {
  return {row.integer(0), row.integer(1),    row.text(2),          row.integer(3),
          row.text(4),    row.text(5),       row.maybe_integer(6), row.maybe_integer(7),
          row.text(8),    row.maybe_real(9), row.maybe_real(10),   row.maybe_integer(11),
          row.maybe_integer(12), row.maybe_integer(13), row.maybe_integer(14), row.text(15), row.text(16)};
}

AlarmRow alarm_of(const Row& row) {
  return {row.integer(0), row.integer(1), row.text(2),     row.integer(3),       row.integer(4),
          row.text(5),    row.text(6),    row.text(7),     row.integer(8),       row.integer(9),
          row.text(10),   row.text(11),   row.integer(12), row.maybe_integer(13)};
}

void add_history(Where& where, const HistoryFilter& filter, const std::string& time) {
  if (filter.machine != 0) where.add("machine_id = ?", filter.machine);
  if (filter.from_ms) where.add(time + " >= ?", *filter.from_ms);
  if (filter.to_ms) where.add(time + " < ?", *filter.to_ms);
}

constexpr auto id_of = [](const auto& row) { return row.id; };

}  // namespace

bool insert_event(Database& db, const EventRow& event) {
  return db
      .integer(
          "INSERT INTO events (machine_id, spool, sequence, at_ms, received_ms, kind, body) VALUES (?, ?, ?, "
          "?, ?, ?, ?) "
          "ON CONFLICT DO NOTHING RETURNING sequence",
          {event.machine, event.spool, event.sequence, event.at_ms, event.received_ms, event.kind,
           event.body})
      .has_value();
}

std::int64_t spool_sequence(Database& db, std::int64_t machine, const std::string& spool,
                            std::int64_t at_ms) {
  if (const auto last =
          db.integer("SELECT last_sequence FROM spools WHERE machine_id = ? AND spool = ?", {machine, spool}))
    return *last;
  db.execute("INSERT INTO spools (machine_id, spool, last_sequence, first_seen_ms) VALUES (?, ?, 0, ?)",
             {machine, spool, at_ms});
  return 0;
}

std::int64_t advance_spool(Database& db, std::int64_t machine, const std::string& spool) {
  std::int64_t last =
      db.integer("SELECT last_sequence FROM spools WHERE machine_id = ? AND spool = ?", {machine, spool})
          .value_or(0);
  const std::int64_t before = last;
  while (db.integer("SELECT 1 FROM events WHERE machine_id = ? AND spool = ? AND sequence = ?",
                    {machine, spool, last + 1}))
    ++last;
  if (last != before)
    db.execute("UPDATE spools SET last_sequence = ? WHERE machine_id = ? AND spool = ?",
               {last, machine, spool});
  return last;
}

void skip_spool_to(Database& db, std::int64_t machine, const std::string& spool, std::int64_t sequence,
                   std::int64_t at_ms) {
  Transaction transaction(db);
  const std::int64_t last = spool_sequence(db, machine, spool, at_ms);
  if (last < sequence) {
    db.execute(
        "INSERT INTO event_gaps (machine_id, spool, first_sequence, last_sequence, at_ms) VALUES (?, ?, ?, "
        "?, ?) "
        "ON CONFLICT DO NOTHING",
        {machine, spool, last + 1, sequence, at_ms});
    db.execute("UPDATE spools SET last_sequence = ? WHERE machine_id = ? AND spool = ?",
               {sequence, machine, spool});
    advance_spool(db, machine, spool);
  }
  transaction.commit();
}

Listed<PartRow> parts(Database& db, const HistoryFilter& filter, const Page& page) {
  Where where;
  add_history(where, filter, "at_ms");
  where.page("id", page);
  return listed<PartRow>(db, kPart, where, "id", page, part_of, id_of);
}

std::int64_t part_total(Database& db, const HistoryFilter& filter) {
  Where where;
  add_history(where, filter, "at_ms");
  return db.integer("SELECT COUNT(*) FROM parts" + where.text(), where.values()).value_or(0);
}

Listed<RunRow> runs(Database& db, const HistoryFilter& filter, const Page& page) {
  Where where;
  add_history(where, filter, "COALESCE(started_ms, ended_ms)");
  where.page("id", page);
  return listed<RunRow>(db, kRun, where, "id", page, run_of, id_of);
}

Listed<AlarmRow> alarms(Database& db, const AlarmFilter& filter, const Page& page) {
  Where where;
  add_history(where, filter, "raised_ms");
  if (!filter.code.empty()) where.add("code = ?", filter.code);
  if (filter.active_only) where.add("cleared_ms IS NULL");
  if (!filter.text.empty())
    where.add_repeated(
        "(code LIKE ? ESCAPE '\\' OR text_en LIKE ? ESCAPE '\\' OR text_zh LIKE ? ESCAPE '\\' "
        "OR program LIKE ? ESCAPE '\\' OR block LIKE ? ESCAPE '\\')",
        like_part(filter.text), 5);
  where.page("id", page);
  return listed<AlarmRow>(db, kAlarm, where, "id", page, alarm_of, id_of);
}

std::vector<StateRow> states(Database& db, const HistoryFilter& filter) {
  Where where;
  if (filter.machine != 0) where.add("machine_id = ?", filter.machine);
  if (filter.from_ms) where.add("(to_ms IS NULL OR to_ms > ?)", *filter.from_ms);
  if (filter.to_ms) where.add("from_ms < ?", *filter.to_ms);
  std::vector<StateRow> found;
  db.each(kState + where.text() + " ORDER BY machine_id, from_ms, id LIMIT 10000", where.values(),
          [&](const Row& row) { found.push_back(state_of(row)); });
  return found;
}

void each_state(Database& db, const HistoryFilter& filter, const std::function<void(const StateRow&)>& row) {
  Where where;
  where.add("machine_id = ?", filter.machine);
  if (filter.from_ms) {
    // The intervals are a chain: only the last that begins before the time can reach into it.
    const auto first =
        db.integer("SELECT MAX(from_ms) FROM state_intervals WHERE machine_id = ? AND from_ms <= ?",
                   {filter.machine, *filter.from_ms});
    where.add("from_ms >= ?", first.value_or(*filter.from_ms));
  }
  if (filter.to_ms) where.add("from_ms < ?", *filter.to_ms);
  db.each(kState + where.text() + " ORDER BY from_ms, id", where.values(),
          [&](const Row& found) { row(state_of(found)); });
}

std::int64_t insert_part(Database& db, const PartRow& part) {
  return *db.integer(
      "INSERT INTO parts (machine_id, spool, sequence, at_ms, program, sha256, machine_count, machine_total, "
      "cycle_s) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING id",
      {part.machine, part.spool, part.sequence, part.at_ms, part.program, part.sha256, part.machine_count,
       part.machine_total, part.cycle_s});
}

void put_run_start(Database& db, const RunRow& run) {
  const auto ended_first = db.integer(
      "SELECT id FROM runs WHERE machine_id = ? AND spool = ? AND run = ? AND started_ms IS NULL ORDER BY id "
      "LIMIT 1",
      {run.machine, run.spool, run.run});
  if (ended_first)
    db.execute(
        "UPDATE runs SET program = ?, sha256 = ?, started_ms = ?, total_start = ?, by_user = ? WHERE id = ?",
        {run.program, run.sha256, run.started_ms, run.total_start, run.by, *ended_first});
  else
    db.execute(
        "INSERT INTO runs (machine_id, spool, run, program, sha256, started_ms, total_start, by_user) VALUES (?, ?, "
        "?, ?, ?, ?, ?, ?)",
        {run.machine, run.spool, run.run, run.program, run.sha256, run.started_ms, run.total_start, run.by});
}

void put_run_end(Database& db, const RunRow& run) {
  const auto started = db.integer(
      "SELECT id FROM runs WHERE machine_id = ? AND spool = ? AND run = ? AND ended_ms IS NULL ORDER BY id "
      "DESC LIMIT 1",
      {run.machine, run.spool, run.run});
  if (started)
    db.execute(
        "UPDATE runs SET ended_ms = ?, outcome = ?, run_s = ?, cutting_s = ?, total_end = ?, holds = ?, alarms = ?, "
        "overrides_json = ? WHERE id = ?",
        {run.ended_ms, run.outcome, run.run_s, run.cutting_s, run.total_end, run.holds, run.alarms,
         run.overrides_json, *started});
  else
    db.execute(
        "INSERT INTO runs (machine_id, spool, run, program, sha256, ended_ms, outcome, run_s, cutting_s, total_end, "
        "holds, alarms, overrides_json) VALUES (?, ?, ?, '', '', ?, ?, ?, ?, ?, ?, ?, ?)",
        {run.machine, run.spool, run.run, run.ended_ms, run.outcome, run.run_s, run.cutting_s, run.total_end,
         run.holds, run.alarms, run.overrides_json});
}

std::int64_t insert_alarm(Database& db, const AlarmRow& alarm) {
  return *db.integer(
      "INSERT INTO alarms (machine_id, spool, sequence, alarm, code, text_en, text_zh, line, column_number, "
      "program, "
      "block, raised_ms) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING id",
      {alarm.machine, alarm.spool, alarm.sequence, alarm.alarm, alarm.code, alarm.text_en, alarm.text_zh,
       alarm.line, alarm.column, alarm.program, alarm.block, alarm.raised_ms});
}

std::optional<AlarmRow> clear_alarm(Database& db, std::int64_t machine, const std::string& spool,
                                    std::int64_t alarm, std::int64_t at_ms) {
  std::optional<AlarmRow> found;
  db.each(std::string(kAlarm) +
              " WHERE machine_id = ? AND spool = ? AND alarm = ? AND cleared_ms IS NULL ORDER BY id LIMIT 1",
          {machine, spool, alarm}, [&](const Row& row) { found = alarm_of(row); });
  if (!found) return found;
  found->cleared_ms = std::max(at_ms, found->raised_ms);
  db.execute("UPDATE alarms SET cleared_ms = ? WHERE id = ?", {*found->cleared_ms, found->id});
  return found;
}

std::vector<AlarmRow> clear_all_alarms(Database& db, std::int64_t machine, std::int64_t at_ms) {
  std::vector<AlarmRow> found;
  db.each(std::string(kAlarm) + " WHERE machine_id = ? AND cleared_ms IS NULL ORDER BY id", {machine},
          [&](const Row& row) { found.push_back(alarm_of(row)); });
  for (AlarmRow& alarm : found) {
    alarm.cleared_ms = std::max(at_ms, alarm.raised_ms);
    db.execute("UPDATE alarms SET cleared_ms = ? WHERE id = ?", {*alarm.cleared_ms, alarm.id});
  }
  return found;
}

}  // namespace headstock::db

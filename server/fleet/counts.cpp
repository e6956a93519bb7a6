#include "server/fleet/counts.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "db/filter.hpp"
#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "server/access/audit.hpp"
#include "server/fleet/event_body.hpp"

namespace headstock::fleet {
namespace {

using nlohmann::json;

constexpr std::size_t kMostDifferences = 100;

using body::integer;
using body::text;

/// Inside the transaction of the intake.
void disagree(db::Database& db, Disagreement d, std::vector<db::AlarmRow>& raised) {
  const auto id = db.integer(
      "INSERT INTO count_disagreements (machine_id, spool, sequence, at_ms, kind, counted, witness, run) "
      "VALUES (?, ?, "
      "?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING RETURNING id",
      {d.machine, d.spool, d.sequence, d.at_ms, d.kind, d.counted, d.witness, d.run});
  if (!id) return;
  db::AlarmRow alarm;
  alarm.machine = d.machine;
  alarm.spool = d.spool;
  alarm.sequence = d.sequence;
  alarm.alarm = -d.sequence;  // the controller's own numbers are positive
  alarm.code = kCountAlarm;
  const std::string counted = std::to_string(d.counted), witness = std::to_string(d.witness);
  if (d.kind == "counter_step") {
    alarm.text_en = "Part count: the counter went from " + counted + " to " + witness + " with one part";
    alarm.text_zh = "工件计数不一致：加工一件后计数器由 " + counted + " 变为 " + witness;
  } else {
    alarm.text_en = "Part count: " + counted + " parts told in the run, the counter grew by " + witness;
    alarm.text_zh = "工件计数不一致：本次运行上报 " + counted + " 件，计数器增加 " + witness + " 件";
  }
  alarm.raised_ms = d.at_ms;
  alarm.id = db::insert_alarm(db, alarm);
  raised.push_back(std::move(alarm));
}

struct Ended {
  std::int64_t sequence, at_ms;
  json body;
};

}  // namespace

void hold_against_each_other(db::Database& db, std::int64_t machine, const std::string& spool,
                             std::int64_t after, std::int64_t up_to, std::vector<db::AlarmRow>& raised) {
  if (up_to <= after) return;
  struct Counted {
    std::int64_t sequence, at_ms, total;
  };
  std::vector<Counted> parts;
  db.each(
      "SELECT sequence, at_ms, machine_total FROM parts WHERE machine_id = ? AND spool = ? AND sequence > ? "
      "AND "
      "sequence <= ? ORDER BY sequence",
      {machine, spool, after, up_to}, [&](const db::Row& row) {
        parts.push_back({row.integer(0), row.integer(1), row.integer(2)});
      });
  if (!parts.empty()) {
    auto before = db.integer(
        "SELECT machine_total FROM parts WHERE machine_id = ? AND spool = ? AND sequence <= ? ORDER BY "
        "sequence DESC "
        "LIMIT 1",
        {machine, spool, after});
    for (const Counted& part : parts) {
      if (before && part.total != *before + 1) {
        Disagreement d;
        d.machine = machine;
        d.spool = spool;
        d.sequence = part.sequence;
        d.at_ms = part.at_ms;
        d.kind = "counter_step";
        d.counted = *before;
        d.witness = part.total;
        disagree(db, std::move(d), raised);
      }
      before = part.total;
    }
  }
  std::vector<Ended> ended;
  db.each(
      "SELECT sequence, at_ms, body FROM events WHERE machine_id = ? AND spool = ? AND sequence > ? AND "
      "sequence <= ? "
      "AND kind = 'run_ended' ORDER BY sequence",
      {machine, spool, after, up_to}, [&](const db::Row& row) {
        ended.push_back({row.integer(0), row.integer(1), json::parse(row.text(2), nullptr, false)});
      });
  for (const Ended& end : ended) {
    if (!end.body.is_object() || !end.body.contains("total")) continue;  // an older agent
    std::int64_t began = 0;
    json start;
    db.each(
        "SELECT sequence, body FROM events WHERE machine_id = ? AND spool = ? AND sequence < ? AND kind = "
        "'run_started' ORDER BY sequence DESC LIMIT 1",
        {machine, spool, end.sequence}, [&](const db::Row& row) {
          began = row.integer(0);
          start = json::parse(row.text(1), nullptr, false);
        });
    if (!start.is_object() || !start.contains("total") || integer(start, "run") != integer(end.body, "run"))
      continue;
    const std::int64_t told =
        db.integer(
              "SELECT COUNT(*) FROM parts WHERE machine_id = ? AND spool = ? AND sequence > ? "
              "AND sequence < ?",
              {machine, spool, began, end.sequence})
            .value_or(0);
    const std::int64_t grown = integer(end.body, "total") - integer(start, "total");
    if (told == grown) continue;
    Disagreement d;
    d.machine = machine;
    d.spool = spool;
    d.sequence = end.sequence;
    d.at_ms = end.at_ms;
    d.kind = "run_parts";
    d.counted = told;
    d.witness = grown;
    d.run = integer(end.body, "run");
    disagree(db, std::move(d), raised);
  }
}

db::Listed<Disagreement> disagreements(db::Database& db, std::int64_t machine, const db::Page& page) {
  db::Where where;
  if (machine != 0) where.add("machine_id = ?", machine);
  where.page("id", page);
  return db::listed<Disagreement>(
      db,
      "SELECT id, machine_id, spool, sequence, at_ms, kind, counted, witness, run, seen_by, seen_ms FROM "
      "count_disagreements",
      where, "id", page,
      [](const db::Row& row) {
        Disagreement d;
        d.id = row.integer(0);
        d.machine = row.integer(1);
        d.spool = row.text(2);
        d.sequence = row.integer(3);
        d.at_ms = row.integer(4);
        d.kind = row.text(5);
        d.counted = row.integer(6);
        d.witness = row.integer(7);
        d.run = row.integer(8);
        d.seen_by = row.text(9);
        d.seen_ms = row.maybe_integer(10);
        return d;
      },
      [](const Disagreement& d) { return d.id; });
}

void acknowledge(db::Database& db, const access::Actor& actor, std::int64_t id, std::int64_t now_ms) {
  demand(actor, access::Action::note_downtime);
  db::Transaction transaction(db);
  std::int64_t machine = 0, sequence = 0;
  std::string spool;
  db.each("SELECT machine_id, spool, sequence FROM count_disagreements WHERE id = ?", {id},
          [&](const db::Row& row) {
            machine = row.integer(0);
            spool = row.text(1);
            sequence = row.integer(2);
          });
  if (machine == 0) throw db::Refusal("not_found", access::subject("disagreement", id));
  db.execute("UPDATE count_disagreements SET seen_by = ?, seen_ms = ? WHERE id = ? AND seen_ms IS NULL",
             {actor.user, now_ms, id});
  db::clear_alarm(db, machine, spool, -sequence, now_ms);
  access::record(db, actor, "counts.seen", access::subject("machine", machine),
                 {{"disagreement", std::to_string(id)}});
  transaction.commit();
}

namespace {

/// What one row of a table says, as a text two of which can be compared.
std::string part_text(std::int64_t at_ms, const std::string& program, const std::string& sha256,
                      std::int64_t count, std::int64_t total) {
  return std::to_string(at_ms) + " " + program + " " + sha256 + " " + std::to_string(count) + "/" +
         std::to_string(total);
}
std::string run_text(const std::string& program, std::optional<std::int64_t> started,
                     std::optional<std::int64_t> ended, const std::string& outcome) {
  const auto shown = [](const std::optional<std::int64_t>& time) {
    return time ? std::to_string(*time) : "-";
  };
  return program + " " + shown(started) + " " + shown(ended) + " " + outcome;
}

using PartKey = std::pair<std::string, std::int64_t>;  // spool, sequence
using Texts = std::map<PartKey, std::string>;

struct OpenRun {
  std::string program;
  std::optional<std::int64_t> started, ended;
  std::string outcome;
};

void compare(const char* name, const Texts& counted, const Texts& stored, Recount& result) {
  const auto differ = [&](const PartKey& key, const std::string& text_) {
    if (result.differences.size() < kMostDifferences)
      result.differences.push_back(std::string(name) + " " + key.first + "/" + std::to_string(key.second) +
                                   ": " + text_);
  };
  for (const auto& [key, value] : counted) {
    const auto found = stored.find(key);
    if (found == stored.end())
      differ(key, "not in the table");
    else if (found->second != value)
      differ(key, "table: " + found->second + "; events: " + value);
  }
  for (const auto& [key, value] : stored)
    if (!counted.contains(key)) differ(key, "no event");
}

Recount recount_one(db::Database& db, std::int64_t machine, std::string name) {
  Recount result;
  result.machine = machine;
  result.name = std::move(name);
  Texts parts, runs;
  std::map<PartKey, OpenRun> open;
  db.each(
      "SELECT spool, sequence, at_ms, kind, body FROM events WHERE machine_id = ? AND kind IN ('part', "
      "'run_started', "
      "'run_ended') ORDER BY spool, sequence",
      {machine}, [&](const db::Row& row) {
        const json body = json::parse(row.text(4), nullptr, false);
        if (!body.is_object()) return;
        const std::string kind = row.text(3);
        if (kind == "part") {
          parts[{row.text(0), row.integer(1)}] =
              part_text(row.integer(2), text(body, "program"), text(body, "sha256"), integer(body, "count"),
                        integer(body, "total"));
          return;
        }
        OpenRun& run = open[{row.text(0), integer(body, "run")}];
        if (kind == "run_started") {
          run.program = text(body, "program");
          run.started = row.integer(2);
        } else {
          run.ended = row.integer(2);
          run.outcome = text(body, "outcome");
        }
      });
  for (const auto& [key, run] : open) {
    runs[key] = run_text(run.program, run.started, run.ended, run.outcome);
    if (!run.ended) ++result.runs_open;
  }
  Texts stored_parts, stored_runs;
  db.each(
      "SELECT spool, sequence, at_ms, program, sha256, machine_count, machine_total FROM parts WHERE "
      "machine_id = ?",
      {machine}, [&](const db::Row& row) {
        stored_parts[{row.text(0), row.integer(1)}] =
            part_text(row.integer(2), row.text(3), row.text(4), row.integer(5), row.integer(6));
      });
  db.each("SELECT spool, run, program, started_ms, ended_ms, outcome FROM runs WHERE machine_id = ?",
          {machine}, [&](const db::Row& row) {
            stored_runs[{row.text(0), row.integer(1)}] =
                run_text(row.text(2), row.maybe_integer(3), row.maybe_integer(4), row.text(5));
          });
  result.events = db.integer("SELECT COUNT(*) FROM events WHERE machine_id = ?", {machine}).value_or(0);
  result.missing =
      db.integer("SELECT SUM(last_sequence - first_sequence + 1) FROM event_gaps WHERE machine_id = ?",
                 {machine})
          .value_or(0);
  result.parts = static_cast<std::int64_t>(parts.size());
  result.parts_stored = static_cast<std::int64_t>(stored_parts.size());
  result.runs = static_cast<std::int64_t>(runs.size());
  result.runs_stored = static_cast<std::int64_t>(stored_runs.size());
  compare("part", parts, stored_parts, result);
  compare("run", runs, stored_runs, result);
  return result;
}

}  // namespace

std::vector<Recount> recount(db::Database& db, std::int64_t machine) {
  std::vector<Recount> results;
  for (const db::MachineRow& row : db::machines(db))
    if (machine == 0 || row.id == machine) results.push_back(recount_one(db, row.id, row.name));
  if (machine != 0 && results.empty()) throw db::Refusal("not_found", access::subject("machine", machine));
  return results;
}

}  // namespace headstock::fleet

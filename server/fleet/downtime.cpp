#include "server/fleet/downtime.hpp"

#include <algorithm>
#include <map>

#include "db/event_store.hpp"
#include "db/refusal.hpp"
#include "server/access/audit.hpp"
#include "server/fleet/machines.hpp"

namespace headstock::fleet {
namespace {

constexpr std::int64_t kLongestNoteMs = 31LL * 86'400'000;
constexpr std::size_t kLongestText = 500;
/// Between a browser's clock and ours.
constexpr std::int64_t kClockSlackMs = 60'000;

constexpr const char* kNote =
    "SELECT n.id, n.machine_id, n.from_ms, n.to_ms, n.reason_id, COALESCE(r.planned, 0), n.note, n.by_user, "
    "n.at_ms "
    "FROM downtime_notes n LEFT JOIN downtime_reasons r ON r.id = n.reason_id ";

DowntimeNote note_of(const db::Row& row) {
  DowntimeNote note;
  note.id = row.integer(0);
  note.machine = row.integer(1);
  note.from_ms = row.integer(2);
  note.to_ms = row.integer(3);
  note.reason = row.maybe_integer(4);
  note.planned = row.flag(5);
  note.note = row.text(6);
  note.by_user = row.text(7);
  note.at_ms = row.integer(8);
  return note;
}

void demand_reason(db::Database& db, std::int64_t id) {
  if (!db.integer("SELECT 1 FROM downtime_reasons WHERE id = ? AND removed_ms IS NULL", {id}))
    throw db::Refusal("not_found", "reason");
}

bool is_silence(const std::string& state) {
  return state == "unknown" || state == "off";
}

}  // namespace

std::vector<DowntimeReason> downtime_reasons(db::Database& db) {
  std::vector<DowntimeReason> reasons;
  db.each(
      "SELECT id, name_en, name_zh, planned FROM downtime_reasons WHERE removed_ms IS NULL ORDER BY "
      "position, id",
      {}, [&](const db::Row& row) {
        reasons.push_back({row.integer(0), row.text(1), row.text(2), row.flag(3)});
      });
  return reasons;
}

DowntimeReason put_downtime_reason(db::Database& db, const access::Actor& actor,
                                   const DowntimeReason& reason) {
  access::demand(actor, access::Action::edit_calendar);
  for (const std::string* name : {&reason.name_en, &reason.name_zh})
    if (name->empty() || name->size() > 100) throw db::Refusal("bad_value", "name");
  db::Transaction transaction(db);
  DowntimeReason kept = reason;
  if (reason.id == 0) {
    kept.id = *db.integer(
        "INSERT INTO downtime_reasons (name_en, name_zh, planned, position) VALUES (?, ?, ?, "
        "(SELECT COALESCE(MAX(position), 0) + 1 FROM downtime_reasons)) RETURNING id",
        {reason.name_en, reason.name_zh, reason.planned ? 1 : 0});
  } else {
    demand_reason(db, reason.id);
    db.execute("UPDATE downtime_reasons SET name_en = ?, name_zh = ?, planned = ? WHERE id = ?",
               {reason.name_en, reason.name_zh, reason.planned ? 1 : 0, reason.id});
  }
  access::record(db, actor, "downtime_reason.put", "downtime_reason:" + std::to_string(kept.id),
                 {{"name", kept.name_en}, {"planned", kept.planned ? "yes" : "no"}});
  transaction.commit();
  return kept;
}

void remove_downtime_reason(db::Database& db, const access::Actor& actor, std::int64_t id,
                            std::int64_t now_ms) {
  access::demand(actor, access::Action::edit_calendar);
  db::Transaction transaction(db);
  demand_reason(db, id);
  db.execute("UPDATE downtime_reasons SET removed_ms = ? WHERE id = ?", {now_ms, id});
  access::record(db, actor, "downtime_reason.remove", "downtime_reason:" + std::to_string(id));
  transaction.commit();
}

DowntimeNote note_downtime(db::Database& db, const access::Actor& actor, const DowntimeNote& note,
                           std::int64_t now_ms) {
  access::demand(actor, access::Action::note_downtime);
  if (note.from_ms <= 0 || note.to_ms <= note.from_ms || note.length_ms() > kLongestNoteMs)
    throw db::Refusal("bad_value", "to");
  if (note.to_ms > now_ms + kClockSlackMs) throw db::Refusal("in_the_future", "to");
  if (note.note.size() > kLongestText) throw db::Refusal("bad_value", "note");
  db::Transaction transaction(db);
  require_machine(db, note.machine);
  if (note.reason) demand_reason(db, *note.reason);
  const auto id = *db.integer(
      "INSERT INTO downtime_notes (machine_id, from_ms, to_ms, reason_id, note, by_user, at_ms) "
      "VALUES (?, ?, ?, ?, ?, ?, ?) RETURNING id",
      {note.machine, note.from_ms, note.to_ms, note.reason, note.note, actor.user, now_ms});
  access::record(db, actor, "downtime.note", access::subject("machine", note.machine),
                 {{"reason", note.reason ? std::to_string(*note.reason) : "none"}, {"note", note.note}});
  DowntimeNote kept;
  db.each(std::string(kNote) + "WHERE n.id = ?", {id}, [&](const db::Row& row) { kept = note_of(row); });
  transaction.commit();
  return kept;
}

std::vector<DowntimeNote> downtime_notes(db::Database& db, std::int64_t machine, const Span& within) {
  std::vector<DowntimeNote> notes;
  // No note is longer than kLongestNoteMs: what began before that cannot reach in.
  db.each(std::string(kNote) +
              "WHERE n.machine_id = ? AND n.from_ms > ? AND n.from_ms < ? AND n.to_ms > ? ORDER BY n.id",
          {machine, within.from_ms - kLongestNoteMs - 1, within.to_ms, within.from_ms},
          [&](const db::Row& row) { notes.push_back(note_of(row)); });
  return notes;
}

std::vector<DowntimeNote> settled(std::vector<DowntimeNote> notes) {
  std::map<std::int64_t, DowntimeNote> by_start;
  for (const DowntimeNote& newer : notes) {
    // Cut away what the newer one covers, keeping what stands out on either side.
    auto at = by_start.lower_bound(newer.from_ms);
    if (at != by_start.begin() && std::prev(at)->second.to_ms > newer.from_ms) --at;
    while (at != by_start.end() && at->second.from_ms < newer.to_ms) {
      const DowntimeNote older = at->second;
      at = by_start.erase(at);
      if (older.from_ms < newer.from_ms) {
        DowntimeNote left = older;
        left.to_ms = newer.from_ms;
        by_start[left.from_ms] = left;
      }
      if (older.to_ms > newer.to_ms) {
        DowntimeNote right = older;
        right.from_ms = newer.to_ms;
        at = by_start.insert_or_assign(right.from_ms, right).first;
      }
    }
    if (newer.reason) by_start[newer.from_ms] = newer;
  }
  notes.clear();
  for (auto& [start, note] : by_start) notes.push_back(std::move(note));
  return notes;
}

std::vector<Stop> stops(db::Database& db, std::int64_t machine, const Span& within, std::int64_t shortest_ms,
                        std::int64_t now_ms) {
  std::vector<Stop> found;
  std::int64_t longest_ms = 0;
  db::HistoryFilter filter;
  filter.machine = machine;
  filter.from_ms = within.from_ms;
  filter.to_ms = within.to_ms;
  const auto keep_last = [&] {
    if (!found.empty() && found.back().length_ms() < shortest_ms) found.pop_back();
  };
  bool joined = false;
  db::each_state(db, filter, [&](const db::StateRow& state) {
    if (state.state == "running") {
      if (joined) keep_last();
      joined = false;
      return;
    }
    const Span span = {std::max(state.from_ms, within.from_ms),
                       std::min(state.to_ms.value_or(now_ms), within.to_ms)};
    if (span.length_ms() == 0) return;
    if (!joined || is_silence(state.state) != is_silence(found.back().state)) {
      if (joined) keep_last();
      found.push_back({span, state.state, false, std::nullopt});
      longest_ms = span.length_ms();
      joined = true;
    } else {
      found.back().to_ms = span.to_ms;
      if (span.length_ms() > longest_ms) {
        longest_ms = span.length_ms();
        found.back().state = state.state;
      }
    }
    found.back().open = !state.to_ms;
  });
  if (joined) keep_last();
  const auto notes = settled(downtime_notes(db, machine, within));
  for (Stop& stop : found) {
    const auto covering = std::ranges::find_if(notes, [&](const DowntimeNote& note) {
      return note.from_ms <= stop.from_ms && stop.from_ms < note.to_ms;
    });
    if (covering != notes.end()) stop.note = *covering;
  }
  return found;
}

Reject note_reject(db::Database& db, const access::Actor& actor, const Reject& reject, std::int64_t now_ms) {
  access::demand(actor, access::Action::note_downtime);
  constexpr std::int64_t kMost = 1'000'000;
  if (reject.quantity == 0 || reject.quantity > kMost || reject.quantity < -kMost)
    throw db::Refusal("bad_value", "quantity");
  if (reject.why.empty()) throw db::Refusal("reason_missing");
  if (reject.why.size() > kLongestText || reject.program.size() > kLongestText)
    throw db::Refusal("bad_value", "why");
  if (reject.at_ms <= 0) throw db::Refusal("bad_value", "at");
  if (reject.at_ms > now_ms + kClockSlackMs) throw db::Refusal("in_the_future", "at");
  db::Transaction transaction(db);
  require_machine(db, reject.machine);
  Reject kept = reject;
  kept.by_user = actor.user;
  kept.entered_ms = now_ms;
  kept.id = *db.integer(
      "INSERT INTO rejects (machine_id, at_ms, program, quantity, why, by_user, entered_ms) "
      "VALUES (?, ?, ?, ?, ?, ?, ?) RETURNING id",
      {kept.machine, kept.at_ms, kept.program, kept.quantity, kept.why, kept.by_user, kept.entered_ms});
  access::record(db, actor, "reject.note", access::subject("machine", kept.machine),
                 {{"quantity", std::to_string(kept.quantity)}, {"why", kept.why}});
  transaction.commit();
  return kept;
}

std::vector<Reject> rejects(db::Database& db, std::int64_t machine, const Span& within) {
  std::vector<Reject> found;
  db.each(
      "SELECT id, machine_id, at_ms, program, quantity, why, by_user, entered_ms FROM rejects "
      "WHERE machine_id = ? AND at_ms >= ? AND at_ms < ? ORDER BY at_ms, id",
      {machine, within.from_ms, within.to_ms}, [&](const db::Row& row) {
        found.push_back({row.integer(0), row.integer(1), row.integer(2), row.text(3), row.integer(4),
                         row.text(5), row.text(6), row.integer(7)});
      });
  return found;
}

}  // namespace headstock::fleet

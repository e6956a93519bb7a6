// The intervals of a machine are a chain: each begins where the one before it ends, the last one is open.
// Every operation below keeps it so.
#include "server/fleet/states.hpp"

#include <algorithm>
#include <optional>

#include "db/event_store.hpp"
#include "db/machine_store.hpp"

namespace headstock::fleet {
namespace {

struct Interval {
  std::int64_t id = 0;
  std::string state, mode, source;
  std::int64_t from_ms = 0;
  std::optional<std::int64_t> to_ms;
};

/// Not a state of the machine, but that nobody knew.
bool is_silence(const Interval& interval) {
  return interval.source == "server" && (interval.state == "unknown" || interval.state == "off");
}

constexpr const char* kInterval =
    "SELECT id, state, mode, source, from_ms, to_ms FROM state_intervals WHERE machine_id = ? ";

std::optional<Interval> find(db::Database& db, const std::string& condition, const db::Values& values) {
  std::optional<Interval> found;
  db.each(kInterval + condition, values, [&](const db::Row& row) {
    found =
        Interval{row.integer(0), row.text(1), row.text(2), row.text(3), row.integer(4), row.maybe_integer(5)};
  });
  return found;
}

std::optional<Interval> open_interval(db::Database& db, std::int64_t machine) {
  return find(db, "AND to_ms IS NULL", {machine});
}

std::optional<Interval> interval_at(db::Database& db, std::int64_t machine, std::int64_t at_ms) {
  return find(db, "AND from_ms <= ? AND (to_ms IS NULL OR to_ms > ?) ORDER BY from_ms DESC, id DESC LIMIT 1",
              {machine, at_ms, at_ms});
}

void end_at(db::Database& db, std::int64_t id, const db::Value& to_ms) {
  db.execute("UPDATE state_intervals SET to_ms = ? WHERE id = ?", {to_ms, id});
}

void insert(db::Database& db, std::int64_t machine, const std::string& state, const std::string& mode,
            Witness witness, std::int64_t from_ms, const std::optional<std::int64_t>& to_ms) {
  db.execute(
      "INSERT INTO state_intervals (machine_id, state, mode, source, from_ms, to_ms) VALUES (?, ?, ?, ?, ?, "
      "?)",
      {machine, state, mode, witness == Witness::machine ? "machine" : "server", from_ms, to_ms});
}

void replace(db::Database& db, std::int64_t id, const std::string& state, const std::string& mode,
             Witness witness) {
  db.execute("UPDATE state_intervals SET state = ?, mode = ?, source = ? WHERE id = ?",
             {state, mode, witness == Witness::machine ? "machine" : "server", id});
}

}  // namespace

void record_state(db::Database& db, std::int64_t machine, const std::string& state, const std::string& mode,
                  std::int64_t at_ms, Witness witness) {
  db::Transaction transaction(db);
  const auto there = interval_at(db, machine, at_ms);
  if (!there) {
    // Nothing is known of that instant: it lies before everything that is.
    const auto first = find(db, "ORDER BY from_ms, id LIMIT 1", {machine});
    insert(db, machine, state, mode, witness, at_ms, first ? std::optional(first->from_ms) : std::nullopt);
  } else if (witness == Witness::server && there->source == "machine" && there->state == state) {
    // It already says so itself.
  } else if (there->state == state && there->mode == mode && there->source == "machine") {
    // Said twice.
  } else if (there->from_ms == at_ms ||
             (there->state == state && there->source == "server" && !is_silence(*there))) {
    replace(db, there->id, state, mode, witness);
  } else {
    end_at(db, there->id, at_ms);
    insert(db, machine, state, mode, witness, at_ms, there->to_ms);
  }
  transaction.commit();
}

void record_silence(db::Database& db, std::int64_t machine, const std::string& state,
                    std::int64_t last_heard_ms) {
  db::Transaction transaction(db);
  const auto open = open_interval(db, machine);
  if (open && is_silence(*open)) {
    if (open->state != state) replace(db, open->id, state, "", Witness::server);
  } else {
    // Its last word counts, if only for an instant, even when its clock is ahead of ours.
    const std::int64_t from_ms = open ? std::max(last_heard_ms, open->from_ms + 1) : last_heard_ms;
    if (open) end_at(db, open->id, from_ms);
    insert(db, machine, state, "", Witness::server, from_ms, std::nullopt);
  }
  transaction.commit();
}

void record_return(db::Database& db, std::int64_t machine, bool same_boot, std::int64_t /*at_ms*/) {
  if (!same_boot) return;
  db::Transaction transaction(db);
  const auto silence = open_interval(db, machine);
  if (silence && is_silence(*silence)) {
    const auto before = find(db, "AND to_ms = ?", {machine, silence->from_ms});
    if (before) {
      db.execute("DELETE FROM state_intervals WHERE id = ?", {silence->id});
      end_at(db, before->id, nullptr);
    }
  }
  transaction.commit();
}

void close_after_restart(db::Database& db) {
  db::Transaction transaction(db);
  for (const db::MachineRow& machine : db::machines(db)) {
    const auto open = open_interval(db, machine.id);
    if (!open || is_silence(*open)) continue;
    record_silence(db, machine.id, "unknown",
                   std::max(machine.last_seen_ms.value_or(open->from_ms), open->from_ms));
  }
  transaction.commit();
}

}  // namespace headstock::fleet

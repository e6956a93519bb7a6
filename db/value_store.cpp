#include "db/value_store.hpp"

#include "db/filter.hpp"

namespace headstock::db {
namespace {

constexpr const char* kChange =
    "SELECT id, machine_id, spool, sequence, at_ms, received_ms, what, before_value, after_value, origin, "
    "by_user, "
    "request_id FROM value_changes";
constexpr const char* kRequest =
    "SELECT id, machine_id, by_user, at_ms, origin, why, state, needs_second, second_user, second_ms, "
    "reason, "
    "where_value, ended_ms FROM value_requests";

ValueChangeRow change_of(const Row& row) {
  return {row.integer(0),    row.integer(1), row.text(2),  row.maybe_integer(3),
          row.integer(4),    row.integer(5), row.text(6),  row.maybe_real(7),
          row.maybe_real(8), row.text(9),    row.text(10), row.integer(11)};
}

ValueRequestRow request_of(const Row& row) {
  return {row.integer(0),        row.integer(1),
          row.text(2),           row.integer(3),
          row.text(4),           row.text(5),
          row.text(6),           row.text(7),
          row.text(8),           row.maybe_integer(9),
          row.text(10),          row.text(11),
          row.maybe_integer(12), {}};
}

void read_items(Database& db, ValueRequestRow& request) {
  db.each(
      "SELECT what, before_value, after_value, read_back, was_read FROM value_request_items WHERE request_id "
      "= ? "
      "ORDER BY position",
      {request.id}, [&](const Row& row) {
        request.items.push_back(
            {row.text(0), row.maybe_real(1), row.maybe_real(2), row.maybe_real(3), row.flag(4)});
      });
}

constexpr auto row_id = [](const auto& row) { return row.id; };

}  // namespace

void put_value(Database& db, std::int64_t machine, const std::string& what, std::optional<double> value,
               const std::string& spool, std::int64_t sequence, std::int64_t at_ms) {
  // By the machine's own order, not by its clock: a late event does not undo a newer value.
  db.execute(
      "INSERT INTO machine_values (machine_id, what, value, spool, sequence, at_ms) VALUES (?, ?, ?, ?, ?, "
      "?) "
      "ON CONFLICT (machine_id, what) DO UPDATE SET value = excluded.value, spool = excluded.spool, "
      "sequence = excluded.sequence, at_ms = excluded.at_ms "
      "WHERE machine_values.spool <> excluded.spool OR machine_values.sequence <= excluded.sequence",
      {machine, what, value, spool, sequence, at_ms});
}

void insert_value_change(Database& db, const ValueChangeRow& c) {
  db.execute(
      "INSERT INTO value_changes (machine_id, spool, sequence, at_ms, received_ms, what, before_value, "
      "after_value, "
      "origin, by_user, request_id) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
      {c.machine, c.spool, c.sequence, c.at_ms, c.received_ms, c.what, c.before, c.after, c.origin, c.by,
       c.request});
}

Listed<ValueChangeRow> value_changes(Database& db, const ValueChangeFilter& filter, const Page& page) {
  Where where;
  if (filter.machine != 0) where.add("machine_id = ?", filter.machine);
  if (!filter.what.empty() && filter.what.back() == '/') {
    where.add("what LIKE ? ESCAPE '\\'", like_part(filter.what).substr(1));  // begins so
  } else if (!filter.what.empty()) {
    where.add("what = ?", filter.what);
  }
  if (filter.from_ms) where.add("at_ms >= ?", *filter.from_ms);
  if (filter.to_ms) where.add("at_ms < ?", *filter.to_ms);
  where.page("id", page);
  return listed<ValueChangeRow>(db, kChange, where, "id", page, change_of, row_id);
}

bool request_was_carried_out(Database& db, std::int64_t request) {
  return db.integer("SELECT 1 FROM value_changes WHERE request_id = ? LIMIT 1", {request}).has_value();
}

MachineValues machine_values(Database& db, std::int64_t machine, std::optional<std::int64_t> at_ms) {
  MachineValues values;
  db.each("SELECT what, value FROM machine_values WHERE machine_id = ? AND value IS NOT NULL", {machine},
          [&](const Row& row) { values[row.text(0)] = row.real(1); });
  if (!at_ms) return values;
  // Back from now: every change after that moment is undone, the newest first.
  db.each("SELECT what, before_value FROM value_changes WHERE machine_id = ? AND at_ms > ? ORDER BY id DESC",
          {machine, *at_ms}, [&](const Row& row) {
            if (const auto before = row.maybe_real(1))
              values[row.text(0)] = *before;
            else
              values.erase(row.text(0));
          });
  return values;
}

std::int64_t insert_value_request(Database& db, const ValueRequestRow& r) {
  const std::int64_t id = *db.integer(
      "INSERT INTO value_requests (machine_id, by_user, at_ms, origin, why, state, needs_second, reason, "
      "where_value, "
      "ended_ms) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING id",
      {r.machine, r.by, r.at_ms, r.origin, r.why, r.state, r.needs_second, r.reason, r.where, r.ended_ms});
  std::int64_t position = 0;
  for (const ValueItem& item : r.items)
    db.execute(
        "INSERT INTO value_request_items (request_id, position, what, before_value, after_value) VALUES (?, "
        "?, ?, ?, "
        "?)",
        {id, position++, item.what, item.before, item.after});
  return id;
}

void update_value_request(Database& db, const ValueRequestRow& r) {
  db.execute(
      "UPDATE value_requests SET state = ?, second_user = ?, second_ms = ?, reason = ?, where_value = ?, "
      "ended_ms = ? "
      "WHERE id = ?",
      {r.state, r.second, r.second_ms, r.reason, r.where, r.ended_ms, r.id});
  std::int64_t position = 0;
  for (const ValueItem& item : r.items) {
    if (item.was_read)
      db.execute(
          "UPDATE value_request_items SET read_back = ?, was_read = 1 WHERE request_id = ? AND position = ?",
          {item.read_back, r.id, position});
    ++position;
  }
}

std::optional<ValueRequestRow> value_request(Database& db, std::int64_t id) {
  std::optional<ValueRequestRow> found;
  db.each(std::string(kRequest) + " WHERE id = ?", {id}, [&](const Row& row) { found = request_of(row); });
  if (found) read_items(db, *found);
  return found;
}

Listed<ValueRequestRow> value_requests(Database& db, const ValueRequestFilter& filter, const Page& page) {
  Where where;
  if (filter.machine != 0) where.add("machine_id = ?", filter.machine);
  if (!filter.state.empty()) where.add("state = ?", filter.state);
  if (filter.open_only) where.add("ended_ms IS NULL");
  where.page("id", page);
  auto list = listed<ValueRequestRow>(db, kRequest, where, "id", page, request_of, row_id);
  for (ValueRequestRow& request : list.items) read_items(db, request);
  return list;
}

std::map<std::string, double> value_limits(Database& db, std::int64_t machine) {
  std::map<std::string, double> limits;
  db.each("SELECT kind, step FROM value_limits WHERE machine_id IN (0, ?) ORDER BY machine_id", {machine},
          [&](const Row& row) { limits[row.text(0)] = row.real(1); });
  return limits;
}

void put_value_limit(Database& db, std::int64_t machine, const std::string& kind,
                     std::optional<double> step) {
  if (step)
    db.execute(
        "INSERT INTO value_limits (machine_id, kind, step) VALUES (?, ?, ?) ON CONFLICT (machine_id, kind) "
        "DO UPDATE "
        "SET step = excluded.step",
        {machine, kind, *step});
  else
    db.execute("DELETE FROM value_limits WHERE machine_id = ? AND kind = ?", {machine, kind});
}

std::int64_t insert_snapshot(Database& db, const SnapshotRow& s, const MachineValues& values) {
  const std::int64_t id = *db.integer(
      "INSERT INTO value_snapshots (machine_id, profile, name, by_user, at_ms) VALUES (?, ?, ?, ?, ?) "
      "RETURNING id",
      {s.machine, s.profile, s.name, s.by, s.at_ms});
  for (const auto& [what, value] : values)
    db.execute("INSERT INTO value_snapshot_rows (snapshot_id, what, value) VALUES (?, ?, ?)",
               {id, what, value});
  return id;
}

namespace {
constexpr const char* kSnapshot =
    "SELECT s.id, s.machine_id, s.profile, s.name, s.by_user, s.at_ms, (SELECT COUNT(*) FROM "
    "value_snapshot_rows r "
    "WHERE r.snapshot_id = s.id) FROM value_snapshots s";
SnapshotRow snapshot_of(const Row& row) {
  return {row.integer(0), row.integer(1), row.text(2),   row.text(3),
          row.text(4),    row.integer(5), row.integer(6)};
}
}  // namespace

std::vector<SnapshotRow> snapshots(Database& db, std::int64_t machine) {
  std::vector<SnapshotRow> found;
  db.each(std::string(kSnapshot) + " WHERE s.machine_id = ? ORDER BY s.id DESC", {machine},
          [&](const Row& row) { found.push_back(snapshot_of(row)); });
  return found;
}

std::optional<SnapshotRow> snapshot(Database& db, std::int64_t id) {
  std::optional<SnapshotRow> found;
  db.each(std::string(kSnapshot) + " WHERE s.id = ?", {id},
          [&](const Row& row) { found = snapshot_of(row); });
  return found;
}

MachineValues snapshot_values(Database& db, std::int64_t id) {
  MachineValues values;
  db.each("SELECT what, value FROM value_snapshot_rows WHERE snapshot_id = ?", {id},
          [&](const Row& row) { values[row.text(0)] = row.real(1); });
  return values;
}

}  // namespace headstock::db

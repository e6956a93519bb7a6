#include "db/port_store.hpp"

#include "db/filter.hpp"

namespace headstock::db {
namespace {

Value maybe(std::int64_t id) {
  return id == 0 ? Value(nullptr) : Value(id);
}

constexpr const char* kPort =
    "SELECT id, name, machine_id, address, settings_json, listens, folder, name_rule, rules_json, "
    "created_ms, "
    "changed_ms FROM ports WHERE removed_ms IS NULL";

PortRow port_of(const Row& row) {
  return {row.integer(0), row.text(1), row.integer(2), row.text(3),    row.text(4),    row.flag(5),
          row.text(6),    row.text(7), row.text(8),    row.integer(9), row.integer(10)};
}

std::optional<PortRow> one_port(Database& db, const std::string& condition, const Value& value) {
  std::optional<PortRow> found;
  db.each(std::string(kPort) + condition, {value}, [&](const Row& row) { found = port_of(row); });
  return found;
}

constexpr const char* kTransfer =
    "SELECT id, port_id, kind, state, program_id, revision, name, sha256, from_line, header, bytes, total, "
    "wire_sha256, "
    "reason, detail, figures_json, by_user, created_ms, started_ms, ended_ms, settings_json FROM "
    "port_transfers";

PortTransferRow transfer_of(const Row& row) {
  return {row.integer(0),  row.integer(1),  row.text(2),     row.text(3),           row.integer(4),
          row.integer(5),  row.text(6),     row.text(7),     row.integer(8),        row.text(9),
          row.integer(10), row.integer(11), row.text(12),    row.text(13),          row.text(14),
          row.text(15),    row.text(16),    row.integer(17), row.maybe_integer(18), row.maybe_integer(19),
          row.text(20)};
}

constexpr const char* kReceived =
    "SELECT id, port_id, transfer_id, machine_id, kind, name, comment, sha256, closed, folder, program_id, "
    "against_revision, classes, state, decided_by, decided_why, decided_ms, at_ms FROM received";

ReceivedRow received_of(const Row& row) {
  return {row.integer(0),  row.integer(1),        row.integer(2), row.integer(3), row.text(4),
          row.text(5),     row.text(6),           row.text(7),    row.flag(8),    row.text(9),
          row.integer(10), row.integer(11),       row.text(12),   row.text(13),   row.text(14),
          row.text(15),    row.maybe_integer(16), row.integer(17)};
}

}  // namespace

std::vector<PortRow> ports(Database& db) {
  std::vector<PortRow> found;
  db.each(std::string(kPort) + " ORDER BY name", {}, [&](const Row& row) { found.push_back(port_of(row)); });
  return found;
}

std::optional<PortRow> port(Database& db, std::int64_t id) {
  return one_port(db, " AND id = ?", id);
}
std::optional<PortRow> port_named(Database& db, const std::string& name) {
  return one_port(db, " AND name = ?", name);
}

std::int64_t insert_port(Database& db, const PortRow& port) {
  return *db.integer(
      "INSERT INTO ports (name, machine_id, address, settings_json, listens, folder, name_rule, rules_json, "
      "created_ms, "
      "changed_ms) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING id",
      {port.name, maybe(port.machine), port.address, port.settings_json, std::int64_t{port.listens},
       port.folder, port.name_rule, port.rules_json, port.created_ms, port.changed_ms});
}

void update_port(Database& db, const PortRow& port) {
  db.execute(
      "UPDATE ports SET name = ?, machine_id = ?, address = ?, settings_json = ?, listens = ?, folder = ?, "
      "name_rule = ?, "
      "rules_json = ?, changed_ms = ? WHERE id = ?",
      {port.name, maybe(port.machine), port.address, port.settings_json, std::int64_t{port.listens},
       port.folder, port.name_rule, port.rules_json, port.changed_ms, port.id});
}

void remove_port(Database& db, std::int64_t id, std::int64_t at_ms) {
  db.execute("UPDATE ports SET removed_ms = ? WHERE id = ?", {at_ms, id});
}

std::int64_t insert_port_transfer(Database& db, const PortTransferRow& row) {
  return *db.integer(
      "INSERT INTO port_transfers (port_id, kind, state, program_id, revision, name, sha256, from_line, "
      "header, bytes, "
      "total, by_user, created_ms, started_ms, settings_json) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, "
      "?, ?) "
      "RETURNING "
      "id",
      {row.port, row.kind, row.state, maybe(row.program), maybe(row.revision), row.name, row.sha256,
       row.from_line, row.header, row.bytes, row.total, row.by, row.created_ms, row.started_ms,
       row.settings_json});
}

void update_port_transfer(Database& db, const PortTransferRow& row) {
  db.execute(
      "UPDATE port_transfers SET state = ?, bytes = ?, total = ?, wire_sha256 = ?, reason = ?, detail = ?, "
      "figures_json = ?, started_ms = ?, ended_ms = ? WHERE id = ?",
      {row.state, row.bytes, row.total, row.wire_sha256, row.reason, row.detail, row.figures_json,
       row.started_ms, row.ended_ms, row.id});
}

std::optional<PortTransferRow> port_transfer(Database& db, std::int64_t id) {
  std::optional<PortTransferRow> found;
  db.each(std::string(kTransfer) + " WHERE id = ?", {id}, [&](const Row& row) { found = transfer_of(row); });
  return found;
}

Listed<PortTransferRow> port_transfers(Database& db, const PortTransferFilter& filter, const Page& page) {
  Where where;
  if (filter.port != 0) where.add("port_id = ?", filter.port);
  if (filter.open_only) where.add("ended_ms IS NULL");
  if (filter.from_ms != 0) where.add("created_ms >= ?", filter.from_ms);
  if (filter.to_ms != 0) where.add("created_ms < ?", filter.to_ms);
  where.page("id", page);
  return listed<PortTransferRow>(db, kTransfer, where, "id", page, transfer_of,
                                 [](const PortTransferRow& row) { return row.id; });
}

std::int64_t end_open_port_transfers(Database& db, const std::string& reason, std::int64_t at_ms) {
  return db.execute(
      "UPDATE port_transfers SET state = 'failed', reason = ?, ended_ms = ? WHERE ended_ms IS NULL",
      {reason, at_ms});
}

std::vector<PortResidentRow> port_residents(Database& db, std::int64_t port) {
  std::vector<PortResidentRow> found;
  // A start in the middle and a drip-feed leave nothing in the control's memory that could be called the
  // program.
  db.each(
      "SELECT name, sha256, program_id, revision, ended_ms, id FROM port_transfers WHERE id IN (SELECT "
      "MAX(id) FROM "
      "port_transfers WHERE port_id = ? AND state = 'done' AND kind IN ('send', 'answer') AND from_line = 1 "
      "AND "
      "program_id IS NOT NULL GROUP BY name)",
      {port}, [&](const Row& row) {
        found.push_back({row.text(0), row.text(1), row.integer(2), row.integer(3), "", false, row.integer(4),
                         row.integer(5)});
      });
  db.each(
      "SELECT name, sha256, program_id, against_revision, classes, at_ms, id FROM received WHERE id IN "
      "(SELECT MAX(id) "
      "FROM received WHERE port_id = ? AND kind = 'program' GROUP BY name)",
      {port}, [&](const Row& row) {
        found.push_back({row.text(0), row.text(1), row.integer(2), row.integer(3), row.text(4), true,
                         row.integer(5), row.integer(6)});
      });
  return found;
}

std::optional<PortMeasuresRow> port_measures(Database& db, std::int64_t port) {
  std::optional<PortMeasuresRow> found;
  db.each(
      "SELECT port_id, transfers, stops, most_after_stop, longest_stop_us, longest_hold_ms, starved_ms, "
      "sending_ms, "
      "round_trip_us, at_ms FROM port_measures WHERE port_id = ?",
      {port}, [&](const Row& row) {
        found =
            PortMeasuresRow{row.integer(0), row.integer(1), row.integer(2), row.integer(3), row.integer(4),
                            row.integer(5), row.integer(6), row.integer(7), row.integer(8), row.integer(9)};
      });
  return found;
}

void put_port_measures(Database& db, const PortMeasuresRow& row) {
  db.execute(
      "INSERT INTO port_measures (port_id, transfers, stops, most_after_stop, longest_stop_us, "
      "longest_hold_ms, "
      "starved_ms, sending_ms, round_trip_us, at_ms) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT "
      "(port_id) DO "
      "UPDATE SET transfers = excluded.transfers, stops = excluded.stops, most_after_stop = "
      "excluded.most_after_stop, "
      "longest_stop_us = excluded.longest_stop_us, longest_hold_ms = excluded.longest_hold_ms, starved_ms = "
      "excluded.starved_ms, sending_ms = excluded.sending_ms, round_trip_us = excluded.round_trip_us, at_ms "
      "= "
      "excluded.at_ms",
      {row.port, row.transfers, row.stops, row.most_after_stop, row.longest_stop_us, row.longest_hold_ms,
       row.starved_ms, row.sending_ms, row.round_trip_us, row.at_ms});
}

std::int64_t insert_received(Database& db, const ReceivedRow& row) {
  return *db.integer(
      "INSERT INTO received (port_id, transfer_id, machine_id, kind, name, comment, sha256, closed, folder, "
      "program_id, "
      "against_revision, classes, state, at_ms) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING "
      "id",
      {row.port, row.transfer, maybe(row.machine), row.kind, row.name, row.comment, row.sha256,
       std::int64_t{row.closed}, row.folder, maybe(row.program), maybe(row.against_revision), row.classes,
       row.state, row.at_ms});
}

void update_received(Database& db, const ReceivedRow& row) {
  db.execute("UPDATE received SET state = ?, decided_by = ?, decided_why = ?, decided_ms = ? WHERE id = ?",
             {row.state, row.decided_by, row.decided_why, row.decided_ms, row.id});
}

std::optional<ReceivedRow> received(Database& db, std::int64_t id) {
  std::optional<ReceivedRow> found;
  db.each(std::string(kReceived) + " WHERE id = ?", {id}, [&](const Row& row) { found = received_of(row); });
  return found;
}

Listed<ReceivedRow> received_rows(Database& db, const std::string& state, std::int64_t port,
                                  const Page& page) {
  Where where;
  if (!state.empty()) where.add("state = ?", state);
  if (port != 0) where.add("port_id = ?", port);
  where.page("id", page);
  return listed<ReceivedRow>(db, kReceived, where, "id", page, received_of,
                             [](const ReceivedRow& row) { return row.id; });
}

}  // namespace headstock::db

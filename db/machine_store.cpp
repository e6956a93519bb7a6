#include "db/machine_store.hpp"

#include "db/program_store.hpp"

namespace headstock::db {
namespace {

constexpr const char* kColumns =
    "SELECT id, name, profile, toml, config_hash, offsets_json, offsets_version, offsets_at_ms, "
    "parts_required, software, "
    "boot_id, last_seen_ms, live_json, created_ms FROM machines WHERE removed_ms IS NULL";

MachineRow machine_of(const Row& row) {
  return {row.integer(0), row.text(1),           row.text(2),          row.text(3),    row.text(4),
          row.text(5),    row.integer(6),        row.maybe_integer(7), row.integer(8), row.text(9),
          row.text(10),   row.maybe_integer(11), row.text(12),         row.integer(13)};
}

}  // namespace

std::vector<MachineRow> machines(Database& db) {
  std::vector<MachineRow> found;
  db.each(std::string(kColumns) + " ORDER BY id", {},
          [&](const Row& row) { found.push_back(machine_of(row)); });
  return found;
}

std::optional<MachineRow> machine(Database& db, std::int64_t id) {
  std::optional<MachineRow> found;
  db.each(std::string(kColumns) + " AND id = ?", {id}, [&](const Row& row) { found = machine_of(row); });
  return found;
}

std::int64_t insert_machine(Database& db, const MachineRow& machine) {
  return *db.integer(
      "INSERT INTO machines (name, profile, toml, config_hash, parts_required, created_ms) VALUES (?, ?, ?, "
      "?, ?, ?) RETURNING id",
      {machine.name, machine.profile, machine.toml, machine.config_hash, machine.parts_required,
       machine.created_ms});
}

void update_machine(Database& db, const MachineRow& machine) {
  db.execute(
      "UPDATE machines SET name = ?, profile = ?, toml = ?, config_hash = ?, parts_required = ? WHERE id = ?",
      {machine.name, machine.profile, machine.toml, machine.config_hash, machine.parts_required, machine.id});
}

void remove_machine(Database& db, std::int64_t id, std::int64_t at_ms) {
  Transaction transaction(db);
  db.execute("UPDATE machines SET removed_ms = ? WHERE id = ?", {at_ms, id});
  db.execute("UPDATE certificates SET revoked_ms = ? WHERE machine_id = ? AND revoked_ms IS NULL",
             {at_ms, id});
  db.execute("UPDATE enrolment_tokens SET used_ms = ? WHERE machine_id = ? AND used_ms IS NULL", {at_ms, id});
  db.execute("UPDATE state_intervals SET to_ms = MAX(from_ms, ?) WHERE machine_id = ? AND to_ms IS NULL",
             {at_ms, id});
  transaction.commit();
}

void insert_token(Database& db, std::int64_t machine, const std::string& secret_sha256, const std::string& by,
                  std::int64_t created_ms, std::int64_t expires_ms) {
  Transaction transaction(db);
  db.execute("UPDATE enrolment_tokens SET used_ms = ? WHERE machine_id = ? AND used_ms IS NULL",
             {created_ms, machine});
  db.execute(
      "INSERT INTO enrolment_tokens (secret_sha256, machine_id, created_by, created_ms, expires_ms) VALUES "
      "(?, ?, ?, ?, ?)",
      {secret_sha256, machine, by, created_ms, expires_ms});
  transaction.commit();
}

std::int64_t use_token(Database& db, const std::string& secret_sha256, std::int64_t at_ms) {
  return db
      .integer(
          "UPDATE enrolment_tokens SET used_ms = ? WHERE secret_sha256 = ? AND used_ms IS NULL AND "
          "expires_ms > ? "
          "AND machine_id IN (SELECT id FROM machines WHERE removed_ms IS NULL) RETURNING machine_id",
          {at_ms, secret_sha256, at_ms})
      .value_or(0);
}

void insert_certificate(Database& db, std::int64_t machine, const std::string& serial, std::int64_t at_ms) {
  Transaction transaction(db);
  db.execute(
      "UPDATE certificates SET revoked_ms = ? WHERE machine_id = ? AND revoked_ms IS NULL AND serial <> ?",
      {at_ms, machine, serial});
  db.execute(
      "INSERT INTO certificates (serial, machine_id, issued_ms) VALUES (?, ?, ?) ON CONFLICT DO NOTHING",
      {serial, machine, at_ms});
  transaction.commit();
}

bool certificate_valid(Database& db, std::int64_t machine, const std::string& serial) {
  return db
      .integer(
          "SELECT 1 FROM certificates c JOIN machines m ON m.id = c.machine_id WHERE c.machine_id = ? AND "
          "c.serial = ? "
          "AND c.revoked_ms IS NULL AND m.removed_ms IS NULL",
          {machine, serial})
      .has_value();
}

void replace_residents(Database& db, std::int64_t machine, const std::vector<ResidentRow>& programs,
                       std::int64_t at_ms) {
  Transaction transaction(db);
  db.execute("DELETE FROM residents WHERE machine_id = ?", {machine});
  for (const ResidentRow& row : programs)
    db.execute(
        "INSERT INTO residents (machine_id, name, sha256, bytes, since_ms, selected, reported_ms) "
        "VALUES (?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING",
        {machine, row.name, row.sha256, row.bytes, row.since_ms, row.selected, at_ms});
  transaction.commit();
}

std::vector<ResidentRow> residents(Database& db, std::int64_t machine) {
  std::vector<ResidentRow> found;
  db.each(
      "SELECT name, sha256, bytes, since_ms, selected, reported_ms FROM residents WHERE machine_id = ? ORDER "
      "BY name",
      {machine}, [&](const Row& row) {
        found.push_back({row.text(0), row.text(1), row.integer(2), row.maybe_integer(3), row.flag(4),
                         row.integer(5), 0, 0, false});
      });
  for (ResidentRow& row : found) {
    const auto known = revision_of_content(db, row.sha256);
    if (!known) continue;
    row.program_id = known->program;
    row.revision = known->number;
    row.stale = !known->released;
  }
  return found;
}

std::vector<OffsetRow> offsets(Database& db, std::int64_t machine) {
  std::vector<OffsetRow> found;
  db.each("SELECT what, value, at_ms FROM machine_values WHERE machine_id = ? AND value IS NOT NULL ORDER BY what", {machine},
          [&](const Row& row) {
            found.push_back({row.text(0), row.real(1), row.integer(2)});
          });
  return found;
}

}  // namespace headstock::db

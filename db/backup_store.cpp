#include "db/backup_store.hpp"

namespace headstock::db {
namespace {

constexpr const char* kBackup =
    "SELECT id, file, kind, machine_id, sha256, bytes, by_user, at_ms FROM backups WHERE removed_ms IS NULL";

BackupRow backup_of(const Row& row) {
  return {row.integer(0), row.text(1), row.text(2), row.integer(3), row.text(4), row.integer(5), row.text(6), row.integer(7)};
}

}  // namespace

std::vector<BackupRow> backups(Database& db) {
  std::vector<BackupRow> found;
  db.each(std::string(kBackup) + " ORDER BY id DESC", {}, [&](const Row& row) { found.push_back(backup_of(row)); });
  return found;
}

std::optional<BackupRow> backup(Database& db, std::int64_t id) {
  std::optional<BackupRow> found;
  db.each(std::string(kBackup) + " AND id = ?", {id}, [&](const Row& row) { found = backup_of(row); });
  return found;
}

std::int64_t insert_backup(Database& db, const BackupRow& row) {
  return *db.integer(
      "INSERT INTO backups (file, kind, machine_id, sha256, bytes, by_user, at_ms) VALUES (?, ?, ?, ?, ?, ?, ?) RETURNING id",
      {row.file, row.kind, row.machine != 0 ? Value(row.machine) : Value(), row.sha256, row.bytes, row.by, row.at_ms});
}

bool remove_backup(Database& db, std::int64_t id, std::int64_t at_ms) {
  return db.execute("UPDATE backups SET removed_ms = ? WHERE id = ? AND removed_ms IS NULL", {at_ms, id}) > 0;
}

void insert_event_archive(Database& db, const EventArchiveRow& row) {
  db.execute("INSERT INTO event_archives (file, sha256, events, from_ms, to_ms, at_ms) VALUES (?, ?, ?, ?, ?, ?)",
             {row.file, row.sha256, row.events, row.from_ms, row.to_ms, row.at_ms});
}

std::vector<EventArchiveRow> event_archives(Database& db) {
  std::vector<EventArchiveRow> found;
  db.each("SELECT file, sha256, events, from_ms, to_ms, at_ms FROM event_archives ORDER BY id", {}, [&](const Row& row) {
    found.push_back({row.text(0), row.text(1), row.integer(2), row.integer(3), row.integer(4), row.integer(5)});
  });
  return found;
}

}  // namespace headstock::db

// Which backups were made, and which event archives the retention has written. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"

namespace headstock::db {

struct BackupRow {
  std::int64_t id = 0;
  std::string file;  ///< name in DATA/backups
  std::string kind;  ///< server machine
  std::int64_t machine = 0;
  std::string sha256;
  std::int64_t bytes = 0;
  std::string by;
  std::int64_t at_ms = 0;
};
std::vector<BackupRow> backups(Database& db);
std::optional<BackupRow> backup(Database& db, std::int64_t id);
std::int64_t insert_backup(Database& db, const BackupRow& row);
bool remove_backup(Database& db, std::int64_t id, std::int64_t at_ms);

struct EventArchiveRow {
  std::string file, sha256;
  std::int64_t events = 0, from_ms = 0, to_ms = 0, at_ms = 0;
};
void insert_event_archive(Database& db, const EventArchiveRow& row);
std::vector<EventArchiveRow> event_archives(Database& db);

}  // namespace headstock::db

// The whole server in one archive: every table, every program text, the certificates that the machines trust. What is
// left out: who is signed in, other backups. Restored into an empty data folder, of SQLite or of PostgreSQL alike.
#pragma once

#include <filesystem>
#include <string>

#include "db/blobs.hpp"
#include "db/database.hpp"
#include "server/backup/archive.hpp"

namespace headstock::backup {

/// Worker thread. @param snapshot as Database::snapshot() gave it. @return manifest facts: rows of tables, programs.
nlohmann::json write_server(ArchiveWriter& archive, db::Database& snapshot, const db::Blobs& blobs,
                            const std::filesystem::path& data_folder);

struct Restored {
  std::int64_t rows = 0, programs = 0;
  nlohmann::json manifest;
};
/// Before a server runs. Verifies first, then writes; what it has begun it removes when it fails.
/// @param connection PostgreSQL; empty: SQLite in the folder.
/// Throws Refusal{damaged_backup, newer_backup, not_a_backup, not_empty}, db::Error.
Restored restore_server(const std::filesystem::path& archive, const std::filesystem::path& data_folder,
                        const std::string& connection);

}  // namespace headstock::backup

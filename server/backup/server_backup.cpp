#include "server/backup/server_backup.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <fstream>
#include <vector>

#include "db/migrations.hpp"
#include "db/refusal.hpp"
#include "server/backup/dump.hpp"

namespace headstock::backup {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Beside the tables and the programs: keys and certificates, and the events that the retention has put aside.
constexpr const char* kFolders[] = {"pki", "archive"};

int newest_migration() {
  int newest = 0;
  for (const db::Migration& migration : db::builtin_migrations()) newest = std::max(newest, migration.number);
  return newest;
}

void write_folder(ArchiveWriter& archive, const fs::path& data, const std::string& name) {
  std::error_code error;
  if (!fs::exists(data / name, error)) return;
  for (const auto& entry : fs::recursive_directory_iterator(data / name))
    if (entry.is_regular_file()) archive.add_file("files/" + fs::relative(entry.path(), data).string(), entry.path());
}

void extract(Entry& entry, const fs::path& target) {
  fs::create_directories(target.parent_path());
  const int file = ::open(target.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) throw db::Error(db::Problem::unreadable, target.string() + ": cannot be written");
  std::vector<char> piece(1u << 18);
  bool written = true;
  while (const std::size_t got = entry.read(piece.data(), piece.size()))
    written = written && ::write(file, piece.data(), got) == static_cast<ssize_t>(got);
  written = ::fsync(file) == 0 && written;
  ::close(file);
  if (!written) throw db::Error(db::Problem::disk_full, target.string() + ": no room on the disk");
}

bool nothing_in(const fs::path& folder) {
  std::error_code error;
  return !fs::exists(folder, error) || fs::is_empty(folder, error);
}

void fill(db::Database& db, const fs::path& archive, const fs::path& data, Restored& restored) {
  const db::Blobs blobs(data);
  db::Transaction transaction(db);
  Loader loader(db);
  each_entry(archive, [&](Entry& entry) {
    const std::string& name = entry.name();
    if (name.starts_with("tables/")) {
      loader.piece(name, entry.all());
    } else if (name.starts_with("blobs/")) {
      auto writer = blobs.begin();
      std::vector<char> piece(1u << 18);
      while (const std::size_t got = entry.read(piece.data(), piece.size())) writer.append({piece.data(), got});
      if (writer.finish() != name.substr(6)) throw db::Refusal("damaged_backup", name);
      ++restored.programs;
    } else if (name.starts_with("files/")) {
      extract(entry, data / name.substr(6));
    } else {
      throw db::Refusal("newer_backup", name);
    }
  });
  loader.finish();
  restored.rows = loader.rows();
  transaction.commit();
}

}  // namespace

json write_server(ArchiveWriter& archive, db::Database& snapshot, const db::Blobs& blobs, const fs::path& data_folder) {
  json rows = json::object();
  dump(snapshot, [&](const std::string& name, const std::string& text) {
    archive.add(name, text);
    const std::string table = name.substr(7, name.find('/', 7) - 7);
    rows[table] = rows.value(table, std::int64_t{0}) + std::count(text.begin(), text.end(), '\n') - 1;
  });
  std::vector<std::string> programs;
  snapshot.each("SELECT sha256 FROM blobs ORDER BY sha256", {}, [&](const db::Row& row) { programs.push_back(row.text(0)); });
  // A blob is on the disk before its row is: every row of the snapshot has its file.
  for (const std::string& sha256 : programs) archive.add_file("blobs/" + sha256, blobs.path(sha256), sha256);
  for (const char* folder : kFolders) write_folder(archive, data_folder, folder);
  return {{"rows", std::move(rows)}, {"programs", programs.size()}, {"migration", newest_migration()}};
}

Restored restore_server(const fs::path& archive, const fs::path& data_folder, const std::string& connection) {
  Restored restored;
  restored.manifest = verify(archive);
  if (restored.manifest.value("kind", "") != "server") throw db::Refusal("not_a_backup", restored.manifest.value("kind", ""));
  if (restored.manifest.value("migration", 0) > newest_migration()) throw db::Refusal("newer_backup", archive.filename().string());
  if (!nothing_in(data_folder)) throw db::Refusal("not_empty", data_folder.string());
  fs::create_directories(data_folder);
  fs::permissions(data_folder, fs::perms::owner_all);
  try {
    const auto db = connection.empty() ? db::open_sqlite(data_folder / "headstock.db") : db::open_postgres(connection);
    if (db->has_table("schema_migrations")) throw db::Refusal("not_empty", db->place());
    db::migrate(*db);
    fill(*db, archive, data_folder, restored);
  } catch (...) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(data_folder, ignored)) fs::remove_all(entry.path(), ignored);
    throw;
  }
  return restored;
}

}  // namespace headstock::backup

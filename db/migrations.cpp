#include "db/migrations.hpp"

#include <algorithm>
#include <map>

#include "db/hash.hpp"
#include "db/time.hpp"

namespace headstock::db {
namespace {

struct Applied {
  std::string name, sha256;
};

std::map<int, Applied> applied_migrations(Database& database) {
  std::map<int, Applied> applied;
  if (!database.has_table("schema_migrations")) return applied;
  database.each("SELECT number, name, sha256 FROM schema_migrations", {}, [&](const Row& row) {
    applied[static_cast<int>(row.integer(0))] = {row.text(1), row.text(2)};
  });
  return applied;
}

/// Nothing is written before the whole history has been found to be ours.
void demand_known_history(const std::map<int, Applied>& applied, std::span<const Migration> migrations) {
  for (const auto& [number, row] : applied) {
    const auto ours = std::ranges::find(migrations, number, &Migration::number);
    if (ours == migrations.end())
      throw Error(Problem::newer,
                  "the database was made by a newer Headstock (migration " + row.name +
                      " is not known here). Start that version, or restore a backup from before it. "
                      "Nothing was changed.");
    if (sha256_hex(ours->sql) != row.sha256)
      throw Error(Problem::tampered,
                  "migration " + std::string(ours->name) +
                      " differs from the one this database was made with. Install the Headstock "
                      "that belongs to it. Nothing was changed.");
  }
}

}  // namespace

int migrate(Database& database, std::span<const Migration> migrations) {
  const auto applied = applied_migrations(database);
  demand_known_history(applied, migrations);
  int count = 0;
  for (const Migration& migration : migrations) {
    if (applied.contains(migration.number)) continue;
    Transaction transaction(database);
    database.script(
        "CREATE TABLE IF NOT EXISTS schema_migrations (number INTEGER PRIMARY KEY, name TEXT NOT NULL, "
        "sha256 TEXT NOT NULL, applied_ms INTEGER NOT NULL)");
    database.script(std::string(migration.sql));
    database.execute("INSERT INTO schema_migrations (number, name, sha256, applied_ms) VALUES (?, ?, ?, ?)",
                     {migration.number, migration.name, sha256_hex(migration.sql), now_ms()});
    transaction.commit();
    ++count;
  }
  return count;
}

}  // namespace headstock::db

// All tables of the shop as text, one line a row, the same from SQLite and from PostgreSQL: a backup of one can be
// restored into the other.
#pragma once

#include <functional>
#include <string>

#include "db/database.hpp"

namespace headstock::backup {

/// Not in a backup: who is signed in, and what belongs to the schema itself.
bool is_kept(const std::string& table);

/// Hands over `tables/NAME/0001.jsonl` …: first line the columns, then a row a line, at most about 4 MiB a piece.
void dump(db::Database& db, const std::function<void(const std::string& name, const std::string& text)>& piece);

/// Puts rows into a fresh, migrated database, inside the caller's transaction. Pieces in the order of dump().
class Loader {
 public:
  /// Empties what the migrations have put in.
  explicit Loader(db::Database& db);
  /// Throws Refusal{damaged_backup}, Refusal{newer_backup} for a table or column this version does not have.
  void piece(const std::string& name, const std::string& text);
  std::int64_t rows() const { return rows_; }
  void finish() { db_.follow_ids(); }

 private:
  db::Database& db_;
  std::vector<db::TableShape> tables_;
  std::int64_t rows_ = 0;
};

}  // namespace headstock::backup

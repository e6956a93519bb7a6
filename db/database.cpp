#include "db/database.hpp"

namespace headstock::db {

std::optional<std::int64_t> Database::integer(std::string_view sql, const Values& values) {
  std::optional<std::int64_t> found;
  each(sql, values, [&](const Row& row) {
    if (!found && !row.is_null(0)) found = row.integer(0);
  });
  return found;
}

std::optional<std::string> Database::text(std::string_view sql, const Values& values) {
  std::optional<std::string> found;
  each(sql, values, [&](const Row& row) {
    if (!found && !row.is_null(0)) found = row.text(0);
  });
  return found;
}

Transaction::Transaction(Database& database) : database_(database), depth_(database.depth_) {
  // IMMEDIATE: a writer waits here, not in the middle of its work.
  database_.execute(depth_ == 0 ? std::string("BEGIN IMMEDIATE")
                                : std::string("SAVEPOINT s").append(std::to_string(depth_)));
  ++database_.depth_;
}

void Transaction::commit() {
  database_.execute(depth_ == 0 ? std::string("COMMIT")
                                : std::string("RELEASE s").append(std::to_string(depth_)));
  database_.depth_ = depth_;
  open_ = false;
}

Transaction::~Transaction() {
  if (!open_) return;
  database_.depth_ = depth_;
  try {
    if (depth_ == 0) {
      database_.execute("ROLLBACK");
    } else {
      const std::string name = std::string("s").append(std::to_string(depth_));
      database_.execute("ROLLBACK TO " + name);
      database_.execute("RELEASE " + name);
    }
  } catch (const Error&) {
    // The database has undone it by itself already (disk full): that is what was wanted.
  }
}

}  // namespace headstock::db

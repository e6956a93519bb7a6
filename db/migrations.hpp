// Numbered SQL migrations (db/migrations/*.sql), built into the program and applied one transaction each.
// What has been applied is remembered with its SHA-256: a changed old migration or a newer database is
// refused, nothing touched.
#pragma once

#include <span>
#include <string_view>

#include "db/database.hpp"

namespace headstock::db {

struct Migration {
  int number;             ///< rising; a gap is one that is not written yet
  std::string_view name;  ///< file name
  std::string_view sql;
};

/// The migrations built into this program, in order.
std::span<const Migration> builtin_migrations();

/// Brings the schema up to date. Throws Error{newer, tampered}, or what a statement threw (its migration
/// undone).
/// @return how many were applied.
int migrate(Database& database, std::span<const Migration> migrations = builtin_migrations());

}  // namespace headstock::db

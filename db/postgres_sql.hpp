// The one SQL of the stores and migrations as PostgreSQL wants it. Text to text, no connection.
#pragma once

#include <string>
#include <string_view>

namespace headstock::db {

/// A statement of a store: `?` becomes `$1`, `$2` …; LIKE finds without regard to case as SQLite's does; `user` is a
/// column (to PostgreSQL it is the name of who is connected); MAX and MIN of two values are GREATEST and LEAST.
/// Quoted texts and comments stay as they are.
std::string postgres_statement(std::string_view sql);

/// A migration: the above without parameters, 64-bit integers, identity columns, and triggers that refuse a change
/// (`BEGIN SELECT RAISE(ABORT, 'why'); END`) through the function `headstock_refuse`.
/// Throws Error{internal} for a trigger that does anything else.
std::string postgres_script(std::string_view sql);

}  // namespace headstock::db

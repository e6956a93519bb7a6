// Which program a machine means when it asks for one by name.
#pragma once

#include <cstdint>
#include <string>

namespace headstock::db {
class Database;
}

namespace headstock::library {

struct RequestedProgram {
  std::string reason;  ///< empty: found. not_found, not_released, ambiguous
  std::int64_t program = 0, revision = 0;
};

/// The released program of exactly this name, or of this O number ("O1234" is also "O01234.nc"). When several
/// folders have one that is released, nobody guesses.
RequestedProgram find_requested(db::Database& db, const std::string& name);

}  // namespace headstock::library

// What the shop has set about passwords and sessions. Store thread.
#pragma once

#include <cstdint>

#include "db/database.hpp"
#include "server/access/role.hpp"

namespace headstock::access {

struct SignInPolicy {
  int failures_before_lock = 5;              ///< wrong passwords in a row for one user
  int address_failures_before_lock = 20;     ///< from one address, whatever the user; a whole shop may share an address
  std::int64_t lock_ms = 60'000;             ///< doubles with each further failure, up to an hour
  std::int64_t session_ms = 12 * 3'600'000;  ///< since sign-in
  std::int64_t idle_ms = 0;                  ///< since the last request; 0: no such end
  std::int64_t least_password = 8;           ///< characters
};
/// Of the settings; what is not set is as above.
SignInPolicy policy_of(db::Database& db);

struct PolicyChange {
  std::int64_t session_hours = 12;   ///< 1…168
  std::int64_t idle_minutes = 0;     ///< 0, 5…1440
  std::int64_t least_password = 8;   ///< 8…64
};
PolicyChange policy_settings(db::Database& db);
/// Refusals: forbidden, bad_value (where: the setting).
void set_policy(db::Database& db, const Actor& actor, const PolicyChange& change);

}  // namespace headstock::access

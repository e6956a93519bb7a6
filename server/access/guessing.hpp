// Addresses from which passwords are guessed: counted over all users, so that one password tried on many users is
// noticed as well. Store thread, inside the caller's transaction.
#pragma once

#include <cstdint>
#include <string>

#include "server/access/policy.hpp"

namespace headstock::access {

/// Refusals: locked_out (where: seconds left).
void demand_patient_address(db::Database& db, const std::string& address, std::int64_t now_ms);
/// One more wrong sign-in. Quarter of an hour without one forgets them.
void count_address_failure(db::Database& db, const std::string& address, const SignInPolicy& policy, std::int64_t now_ms);

/// Is it locked at `now_ms`? A lock longer than any that is made comes from a clock that was set back, and is none.
bool is_locked(std::int64_t locked_until_ms, std::int64_t now_ms);

/// The lock of the n-th failure beyond the limit: doubling, up to an hour.
std::int64_t lock_time_ms(std::int64_t failures, int limit, const SignInPolicy& policy);

}  // namespace headstock::access

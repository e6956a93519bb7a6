// Secrets for wall screens and other programs that only look: like a session of a viewer that can change nothing,
// without a person, until it is revoked or expires. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "db/access_store.hpp"
#include "server/access/role.hpp"

namespace headstock::access {

struct NewViewToken {
  std::int64_t id = 0;
  std::string token;  ///< 64 hex digits, shown once; only its hash is kept
};
/// Refusals: forbidden, bad_name.
NewViewToken create_view_token(db::Database& db, const Actor& actor, const std::string& name,
                               std::optional<std::int64_t> expires_ms, std::int64_t now_ms);
/// Refusals: forbidden, not_found.
void revoke_view_token(db::Database& db, const Actor& actor, std::int64_t id, std::int64_t now_ms);
/// Whose secret this is. Nothing when unknown, revoked or expired.
std::optional<db::ViewTokenRow> find_view_token(db::Database& db, const std::string& token, std::int64_t now_ms);

}  // namespace headstock::access

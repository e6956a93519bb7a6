// Users, sessions and the audit trail. Plain rows; the rules are in server/access. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "db/page.hpp"

namespace headstock::db {

struct UserRow {
  std::int64_t id = 0;
  std::string user, name, role, language;
  std::string password;  ///< `scrypt$N$r$p$salt$hash`; never leaves the server
  bool must_change_password = false, disabled = false;
  std::int64_t failures = 0, locked_until_ms = 0, created_ms = 0;
  std::optional<std::int64_t> last_sign_in_ms;
  std::string external;  ///< `issuer#subject` at the sign-in provider; empty: none
};

std::vector<UserRow> users(Database& db);
std::optional<UserRow> user(Database& db, std::int64_t id);
std::optional<UserRow> user_named(Database& db, const std::string& user);
std::optional<UserRow> user_external(Database& db, const std::string& external);
std::int64_t insert_user(Database& db, const UserRow& user);
void update_user(Database& db, const UserRow& user);
/// The row stays for the history; its name gets the id appended so that it is free again.
void remove_user(Database& db, std::int64_t id, std::int64_t at_ms);

struct SessionRow {
  std::string token_sha256;
  std::int64_t user = 0, created_ms = 0, expires_ms = 0;
  std::string address;
  std::int64_t last_used_ms = 0;
};
void insert_session(Database& db, const SessionRow& session);
std::optional<SessionRow> session(Database& db, const std::string& token_sha256);
void touch_session(Database& db, const std::string& token_sha256, std::int64_t at_ms);
void remove_session(Database& db, const std::string& token_sha256);
void remove_sessions_of(Database& db, std::int64_t user);
void remove_expired_sessions(Database& db, std::int64_t now_ms);

struct AuditRow {
  std::int64_t id = 0, at_ms = 0;
  std::string user, address, action, subject, detail;
  std::string previous_hash, hash;
};
/// Chains the row to the one before it: hash = SHA-256 over previous hash and every field.
void append_audit(Database& db, AuditRow row);
struct AuditFilter {
  std::string user, action, subject;  ///< exactly; empty: all
  std::optional<std::int64_t> from_ms, to_ms;
};
Listed<AuditRow> audit(Database& db, const AuditFilter& filter, const Page& page);
/// @return id of the first row that was changed, removed or slipped in; 0 when the chain is whole.
std::int64_t first_broken_audit(Database& db);
struct AuditHead {
  std::int64_t id = 0;  ///< 0: the trail is empty
  std::string hash;
};
/// The newest row. Kept elsewhere it also shows when the end of the trail was cut off.
AuditHead audit_head(Database& db);
/// Hash of one row; empty when there is none.
std::string audit_hash(Database& db, std::int64_t id);

}  // namespace headstock::db

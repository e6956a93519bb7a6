#include "db/user_store.hpp"

#include "db/filter.hpp"
#include "db/hash.hpp"

namespace headstock::db {
namespace {

constexpr const char* kUser =
    "SELECT id, user, name, role, language, password, must_change_password, disabled, failures, "
    "locked_until_ms, created_ms, "
    "last_sign_in_ms, external FROM users WHERE removed_ms IS NULL";

UserRow user_of(const Row& row) {
  return {row.integer(0), row.text(1),    row.text(2),     row.text(3),
          row.text(4),    row.text(5),    row.flag(6),     row.flag(7),
          row.integer(8), row.integer(9), row.integer(10), row.maybe_integer(11), row.text(12)};
}

constexpr const char* kAudit =
    "SELECT id, at_ms, user, address, action, subject, detail, previous_hash, hash FROM audit";

AuditRow audit_of(const Row& row) {
  return {row.integer(0), row.integer(1), row.text(2), row.text(3), row.text(4),
          row.text(5),    row.text(6),    row.text(7), row.text(8)};
}

/// Every field with its length, so that no two different rows read the same.
std::string chained(const AuditRow& row) {
  Sha256 hash;
  for (const std::string& field : {row.previous_hash, std::to_string(row.id), std::to_string(row.at_ms),
                                   row.user, row.address, row.action, row.subject, row.detail})
    hash.add(std::to_string(field.size()) + ":" + field + ";");
  return hash.hex();
}

}  // namespace

std::vector<UserRow> users(Database& db) {
  std::vector<UserRow> found;
  db.each(std::string(kUser) + " ORDER BY id", {}, [&](const Row& row) { found.push_back(user_of(row)); });
  return found;
}

std::optional<UserRow> user(Database& db, std::int64_t id) {
  std::optional<UserRow> found;
  db.each(std::string(kUser) + " AND id = ?", {id}, [&](const Row& row) { found = user_of(row); });
  return found;
}

std::optional<UserRow> user_named(Database& db, const std::string& user) {
  std::optional<UserRow> found;
  db.each(std::string(kUser) + " AND user = ?", {user}, [&](const Row& row) { found = user_of(row); });
  return found;
}

std::optional<UserRow> user_external(Database& db, const std::string& external) {
  std::optional<UserRow> found;
  db.each(std::string(kUser) + " AND external = ?", {external}, [&](const Row& row) { found = user_of(row); });
  return found;
}

std::int64_t insert_user(Database& db, const UserRow& user) {
  return *db.integer(
      "INSERT INTO users (user, name, role, language, password, must_change_password, disabled, created_ms, "
      "external) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING id",
      {user.user, user.name, user.role, user.language, user.password, user.must_change_password,
       user.disabled, user.created_ms, user.external});
}

void update_user(Database& db, const UserRow& user) {
  db.execute(
      "UPDATE users SET name = ?, role = ?, language = ?, password = ?, must_change_password = ?, disabled = "
      "?, failures = ?, "
      "locked_until_ms = ?, last_sign_in_ms = ? WHERE id = ?",
      {user.name, user.role, user.language, user.password, user.must_change_password, user.disabled,
       user.failures, user.locked_until_ms, user.last_sign_in_ms, user.id});
}

void remove_user(Database& db, std::int64_t id, std::int64_t at_ms) {
  Transaction transaction(db);
  remove_sessions_of(db, id);
  db.execute("UPDATE users SET removed_ms = ?, user = user || '#' || id, password = '', external = '' WHERE id = ?",
             {at_ms, id});
  transaction.commit();
}

void insert_session(Database& db, const SessionRow& session) {
  db.execute(
      "INSERT INTO sessions (token_sha256, user_id, created_ms, expires_ms, address, last_used_ms) VALUES (?, ?, ?, "
      "?, ?, ?)",
      {session.token_sha256, session.user, session.created_ms, session.expires_ms, session.address,
       session.last_used_ms});
}

std::optional<SessionRow> session(Database& db, const std::string& token_sha256) {
  std::optional<SessionRow> found;
  db.each(
      "SELECT token_sha256, user_id, created_ms, expires_ms, address, last_used_ms FROM sessions WHERE token_sha256 = ?",
      {token_sha256}, [&](const Row& row) {
        found = SessionRow{row.text(0), row.integer(1), row.integer(2), row.integer(3), row.text(4),
                           row.integer(5)};
      });
  return found;
}

void touch_session(Database& db, const std::string& token_sha256, std::int64_t at_ms) {
  db.execute("UPDATE sessions SET last_used_ms = ? WHERE token_sha256 = ?", {at_ms, token_sha256});
}

void remove_session(Database& db, const std::string& token_sha256) {
  db.execute("DELETE FROM sessions WHERE token_sha256 = ?", {token_sha256});
}

void remove_sessions_of(Database& db, std::int64_t user) {
  db.execute("DELETE FROM sessions WHERE user_id = ?", {user});
}

void remove_expired_sessions(Database& db, std::int64_t now_ms) {
  db.execute("DELETE FROM sessions WHERE expires_ms <= ?", {now_ms});
}

void append_audit(Database& db, AuditRow row) {
  Transaction transaction(db);
  row.id = 1;
  db.each("SELECT id, hash FROM audit ORDER BY id DESC LIMIT 1", {}, [&](const Row& last) {
    row.id = last.integer(0) + 1;
    row.previous_hash = last.text(1);
  });
  row.hash = chained(row);
  db.execute(
      "INSERT INTO audit (id, at_ms, user, address, action, subject, detail, previous_hash, hash) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
      {row.id, row.at_ms, row.user, row.address, row.action, row.subject, row.detail, row.previous_hash,
       row.hash});
  transaction.commit();
}

Listed<AuditRow> audit(Database& db, const AuditFilter& filter, const Page& page) {
  Where where;
  if (!filter.user.empty()) where.add("user = ?", filter.user);
  if (!filter.action.empty()) where.add("action = ?", filter.action);
  if (!filter.subject.empty()) where.add("subject = ?", filter.subject);
  if (filter.from_ms) where.add("at_ms >= ?", *filter.from_ms);
  if (filter.to_ms) where.add("at_ms < ?", *filter.to_ms);
  where.page("id", page);
  return listed<AuditRow>(db, kAudit, where, "id", page, audit_of,
                          [](const AuditRow& row) { return row.id; });
}

std::int64_t first_broken_audit(Database& db) {
  std::int64_t expected = 1, broken = 0;
  std::string previous;
  db.each(std::string(kAudit) + " ORDER BY id", {}, [&](const Row& row) {
    if (broken != 0) return;
    const AuditRow entry = audit_of(row);
    if (entry.id != expected || entry.previous_hash != previous || entry.hash != chained(entry))
      broken = expected;
    ++expected;
    previous = entry.hash;
  });
  return broken;
}

AuditHead audit_head(Database& db) {
  AuditHead head;
  db.each("SELECT id, hash FROM audit ORDER BY id DESC LIMIT 1", {},
          [&](const Row& row) { head = {row.integer(0), row.text(1)}; });
  return head;
}

std::string audit_hash(Database& db, std::int64_t id) {
  return db.text("SELECT hash FROM audit WHERE id = ?", {id}).value_or("");
}

}  // namespace headstock::db

// The account functions that run on the store thread.
#include <algorithm>
#include <cctype>

#include "db/hash.hpp"
#include "db/refusal.hpp"
#include "server/access/accounts.hpp"
#include "server/access/audit.hpp"
#include "server/access/password.hpp"

namespace headstock::access {
namespace {

constexpr std::int64_t kTouchMs = 60'000;

void demand_user_name(const std::string& name) {
  const bool good = !name.empty() && name.size() <= 64 && std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_' || c == '@';
  });
  if (!good) throw db::Refusal("bad_name", "user");
}

void demand_language(const std::string& language) {
  if (language != "en" && language != "zh") throw db::Refusal("bad_language", language);
}

db::UserRow require_user(db::Database& db, std::int64_t id) {
  auto row = db::user(db, id);
  if (!row) throw db::Refusal("not_found", subject("user", id));
  return *row;
}

/// Without an administrator nobody could ever make one again.
void demand_other_administrator(db::Database& db, std::int64_t id) {
  const auto others = db::users(db);
  if (std::ranges::none_of(others, [&](const db::UserRow& row) {
        return row.id != id && !row.disabled && row.role == "administrator";
      }))
    throw db::Refusal("last_administrator");
}

}  // namespace

User public_part(const db::UserRow& row) {
  return {row.id,
          row.user,
          row.name,
          role_from(row.role).value_or(Role::viewer),
          row.language,
          row.disabled,
          row.must_change_password,
          row.last_sign_in_ms};
}

std::vector<User> list_users(db::Database& db) {
  std::vector<User> found;
  for (const db::UserRow& row : db::users(db)) found.push_back(public_part(row));
  return found;
}

User create_user(db::Database& db, const Actor& actor, const NewUser& user, std::int64_t now_ms) {
  demand(actor, Action::manage_users);
  demand_user_name(user.user);
  demand_language(user.language);
  db::Transaction transaction(db);
  if (db::user_named(db, user.user)) throw db::Refusal("name_taken", user.user);
  db::UserRow row;
  row.user = user.user;
  row.name = user.name.empty() ? user.user : user.name;
  row.role = to_string(user.role);
  row.language = user.language;
  row.password = user.password_hash;
  row.must_change_password = user.must_change_password;
  row.created_ms = now_ms;
  row.id = db::insert_user(db, row);
  record(db, actor, "user.create", subject("user", row.id), {{"user", row.user}, {"role", row.role}});
  transaction.commit();
  return public_part(row);
}

User change_user(db::Database& db, const Actor& actor, std::int64_t id, const UserChange& change,
                 std::int64_t /*now_ms*/) {
  const bool own = actor.user_id == id && !change.role && !change.disabled && !change.password_hash;
  if (!own) demand(actor, Action::manage_users);
  db::Transaction transaction(db);
  db::UserRow row = require_user(db, id);
  const bool was_administrator = row.role == "administrator" && !row.disabled;
  if (change.name) row.name = *change.name;
  if (change.language) {
    demand_language(*change.language);
    row.language = *change.language;
  }
  if (change.role) row.role = to_string(*change.role);
  if (change.disabled) row.disabled = *change.disabled;
  if (change.password_hash) {
    row.password = *change.password_hash;
    row.must_change_password = actor.user_id != id;
    row.failures = 0;
    row.locked_until_ms = 0;
  }
  if (was_administrator && (row.role != "administrator" || row.disabled)) demand_other_administrator(db, id);
  db::update_user(db, row);
  if (!own) db::remove_sessions_of(db, id);
  record(db, actor, "user.change", subject("user", id),
         {{"user", row.user},
          {"role", row.role},
          {"disabled", row.disabled ? "yes" : "no"},
          {"password", change.password_hash ? "new" : "kept"}});
  transaction.commit();
  return public_part(row);
}

void delete_user(db::Database& db, const Actor& actor, std::int64_t id, std::int64_t now_ms) {
  demand(actor, Action::manage_users);
  db::Transaction transaction(db);
  const db::UserRow row = require_user(db, id);
  if (row.role == "administrator" && !row.disabled) demand_other_administrator(db, id);
  db::remove_user(db, id, now_ms);
  record(db, actor, "user.delete", subject("user", id), {{"user", row.user}});
  transaction.commit();
}

std::optional<Session> find_session(db::Database& db, const std::string& token, std::int64_t now_ms) {
  if (token.size() != 64) return std::nullopt;
  const auto session = db::session(db, db::sha256_hex(token));
  if (!session || session->expires_ms <= now_ms) return std::nullopt;
  const auto row = db::user(db, session->user);
  if (!row || row->disabled) return std::nullopt;
  const SignInPolicy policy = policy_of(db);
  const std::int64_t used = std::max(session->last_used_ms, session->created_ms);
  if (policy.idle_ms > 0 && used + policy.idle_ms <= now_ms) return std::nullopt;
  // Not with every request: a minute is fine enough for an end after five.
  if (used + kTouchMs <= now_ms) db::touch_session(db, session->token_sha256, now_ms);
  return Session{public_part(*row), {}, session->expires_ms,
                 rights_of(db, row->id, role_from(row->role).value_or(Role::viewer))};
}

void sign_out(db::Database& db, const Actor& actor, const std::string& token, std::int64_t /*now_ms*/) {
  db::Transaction transaction(db);
  db::remove_session(db, db::sha256_hex(token));
  record(db, actor, "session.end", subject("user", actor.user_id));
  transaction.commit();
}

std::optional<std::string> ensure_first_administrator(db::Database& db, std::int64_t now_ms) {
  if (db.integer("SELECT 1 FROM users LIMIT 1")) return std::nullopt;
  std::string password = random_password();
  NewUser first;
  first.user = "admin";
  first.name = "Administrator";
  first.role = Role::administrator;
  first.password_hash = hash_password(password);
  create_user(db, Actor{}, first, now_ms);
  return password;
}

}  // namespace headstock::access

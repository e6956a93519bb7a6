// Users and their sessions. Functions that take a Database run on the store thread, in their own transaction
// with the audit row; `Accounts` adds the flows that must hash passwords on a worker.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/user_store.hpp"
#include "server/access/policy.hpp"
#include "server/access/rights.hpp"
#include "server/access/role.hpp"

namespace headstock::db {
class Store;
class Pool;
}  // namespace headstock::db

namespace headstock::access {

/// A user as others may see one: no password hash.
struct User {
  std::int64_t id = 0;
  std::string user, name;
  Role role = Role::viewer;
  std::string language = "en";
  bool disabled = false, must_change_password = false;
  std::optional<std::int64_t> last_sign_in_ms;
};
User public_part(const db::UserRow& row);

struct Session {
  User user;
  std::string token;  ///< 64 hex digits, known to the client only; empty when looked up
  std::int64_t expires_ms = 0;
  std::shared_ptr<const Rights> rights{};
  Actor actor(std::string address) const { return {user.id, user.user, user.role, std::move(address)}; }
};

// ---- store thread. `now_ms` is a parameter so that time can be tested.
std::vector<User> list_users(db::Database& db);
struct NewUser {
  std::string user, name;
  Role role = Role::viewer;
  std::string language = "en";
  std::string password_hash;
  bool must_change_password = true;
};
/// Refusals: forbidden, bad_name (1…64 characters of letters, digits, `.-_@`), name_taken.
User create_user(db::Database& db, const Actor& actor, const NewUser& user, std::int64_t now_ms);
struct UserChange {
  std::optional<std::string> name, language, password_hash;
  std::optional<Role> role;
  std::optional<bool> disabled;
};
/// Refusals: forbidden, not_found, last_administrator. A new password, a new role and disabling end the
/// user's sessions. Everybody may change the own name and language.
User change_user(db::Database& db, const Actor& actor, std::int64_t id, const UserChange& change,
                 std::int64_t now_ms);
/// Refusals: forbidden, not_found, last_administrator.
void delete_user(db::Database& db, const Actor& actor, std::int64_t id, std::int64_t now_ms);
/// Whose token this is, with the rights. Nothing when unknown, expired, unused for too long, or the user is disabled.
std::optional<Session> find_session(db::Database& db, const std::string& token, std::int64_t now_ms);
void sign_out(db::Database& db, const Actor& actor, const std::string& token, std::int64_t now_ms);
/// Makes user `admin` when there is no user at all. @return its password, to be shown once; nothing
/// otherwise.
std::optional<std::string> ensure_first_administrator(db::Database& db, std::int64_t now_ms);

/// A session for a person whose identity is certain (a password checked, a sign-in provider's word). In the caller's
/// transaction. @param how for the audit trail.
Session start_session(db::Database& db, const db::UserRow& user, const std::string& address, const std::string& how,
                      std::int64_t now_ms);

class Accounts {
 public:
  Accounts(db::Store& store, db::Pool& workers);
  /// Refusals: wrong_sign_in (unknown user, wrong password, disabled: all the same), locked_out (where:
  /// seconds).
  boost::asio::awaitable<Session> sign_in(std::string user, std::string password, std::string address);
  /// Refusals: wrong_sign_in (the old one), locked_out, weak_password. Ends the user's other sessions, keeps
  /// `token`.
  boost::asio::awaitable<void> change_password(Actor actor, std::string token, std::string old_password,
                                               std::string new_password);
  /// As create_user, with the password in clear. Refusals also: weak_password.
  boost::asio::awaitable<User> create(Actor actor, NewUser user, std::string password);
  /// As change_user, with a new password in clear (an administrator resets it; it must be changed at the next
  /// sign-in).
  boost::asio::awaitable<User> change(Actor actor, std::int64_t id, UserChange change,
                                      std::optional<std::string> password);

 private:
  boost::asio::awaitable<db::UserRow> checked(std::string user, std::string password, std::string address);

  db::Store& store_;
  db::Pool& workers_;
};

}  // namespace headstock::access

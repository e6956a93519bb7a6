// Sign-in and passwords: read on the store thread, hash on a worker, write on the store thread.
#include "server/access/accounts.hpp"

#include <algorithm>

#include "db/hash.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/access/audit.hpp"
#include "server/access/password.hpp"

namespace headstock::access {
namespace {

namespace asio = boost::asio;

constexpr std::int64_t kLongestLockMs = 3'600'000;

std::string seconds_left(std::int64_t until_ms, std::int64_t now_ms) {
  return std::to_string((until_ms - now_ms + 999) / 1000);
}

/// Counts a wrong password; from the policy's limit on, each further one locks for twice as long.
void count_failure(db::Database& db, const db::UserRow& user, const std::string& address,
                   const SignInPolicy& policy, std::int64_t now_ms) {
  db::Transaction transaction(db);
  const auto row = db::user(db, user.id);
  if (!row) return;
  db::UserRow changed = *row;
  ++changed.failures;
  if (changed.failures >= policy.failures_before_lock) {
    const auto doublings = std::min<std::int64_t>(changed.failures - policy.failures_before_lock, 20);
    changed.locked_until_ms = now_ms + std::min(policy.lock_ms << doublings, kLongestLockMs);
  }
  db::update_user(db, changed);
  record(db, Actor{user.id, user.user, Role::viewer, address}, "session.refused",
         std::string("user:").append(std::to_string(user.id)),
         {{"failures", std::to_string(changed.failures)}});
  transaction.commit();
}

}  // namespace

Accounts::Accounts(db::Store& store, db::Pool& workers, SignInPolicy policy)
    : store_(store), workers_(workers), policy_(policy) {}

asio::awaitable<db::UserRow> Accounts::checked(std::string user, std::string password, std::string address) {
  const auto find = [user](db::Database& db) { return db::user_named(db, user); };
  const auto row = co_await store_.run(find);
  const std::int64_t now = db::now_ms();
  // Before the hash: somebody who guesses must not keep the workers busy.
  if (row && row->locked_until_ms > now)
    throw db::Refusal("locked_out", seconds_left(row->locked_until_ms, now));
  if (password.size() > 1000) throw db::Refusal("wrong_sign_in");
  const std::string hash = row ? row->password : std::string();
  const auto on_worker = [password, hash] { return verify_password(password, hash); };
  const bool right = co_await workers_.run(on_worker);
  if (!row) throw db::Refusal("wrong_sign_in");
  if (!right || row->disabled) {
    const auto count = [row, address, policy = policy_, now](db::Database& db) {
      count_failure(db, *row, address, policy, now);
    };
    co_await store_.run(count);
    throw db::Refusal("wrong_sign_in");
  }
  co_return *row;
}

asio::awaitable<Session> Accounts::sign_in(std::string user, std::string password, std::string address) {
  const db::UserRow row = co_await checked(std::move(user), std::move(password), address);
  const auto start = [row, address, policy = policy_](db::Database& db) {
    const std::int64_t now = db::now_ms();
    db::Transaction transaction(db);
    // Read again: the account may have been changed, or locked by somebody else's guesses, while we were
    // hashing.
    auto current = db::user(db, row.id);
    if (!current || current->disabled || current->password != row.password)
      throw db::Refusal("wrong_sign_in");
    if (current->locked_until_ms > now)
      throw db::Refusal("locked_out", seconds_left(current->locked_until_ms, now));
    current->failures = 0;
    current->locked_until_ms = 0;
    current->last_sign_in_ms = now;
    db::update_user(db, *current);
    Session session{public_part(*current), db::random_hex(32), now + policy.session_ms};
    db::remove_expired_sessions(db, now);
    db::insert_session(db, {db::sha256_hex(session.token), row.id, now, session.expires_ms, address});
    record(db, session.actor(address), "session.start", std::string("user:").append(std::to_string(row.id)));
    transaction.commit();
    return session;
  };
  co_return co_await store_.run(start);
}

asio::awaitable<void> Accounts::change_password(Actor actor, std::string token, std::string old_password,
                                                std::string new_password) {
  demand_good_password(new_password, actor.user);
  const db::UserRow row = co_await checked(actor.user, std::move(old_password), actor.address);
  const auto on_worker = [new_password] { return hash_password(new_password); };
  const std::string hash = co_await workers_.run(on_worker);
  const auto change = [actor, row, token, hash](db::Database& db) {
    db::Transaction transaction(db);
    auto current = db::user(db, row.id);
    if (!current || current->password != row.password) throw db::Refusal("wrong_sign_in");
    current->password = hash;
    current->must_change_password = false;
    current->failures = 0;
    db::update_user(db, *current);
    const auto kept = db::session(db, db::sha256_hex(token));
    db::remove_sessions_of(db, row.id);
    if (kept && kept->user == row.id) db::insert_session(db, *kept);
    record(db, actor, "user.password", std::string("user:").append(std::to_string(row.id)));
    transaction.commit();
  };
  co_await store_.run(change);
}

asio::awaitable<User> Accounts::create(Actor actor, NewUser user, std::string password) {
  demand(actor, Action::manage_users);
  demand_good_password(password, user.user);
  const auto on_worker = [password] { return hash_password(password); };
  user.password_hash = co_await workers_.run(on_worker);
  const auto create = [actor, user](db::Database& db) { return create_user(db, actor, user, db::now_ms()); };
  co_return co_await store_.run(create);
}

asio::awaitable<User> Accounts::change(Actor actor, std::int64_t id, UserChange change,
                                       std::optional<std::string> password) {
  if (password) {
    demand(actor, Action::manage_users);
    demand_good_password(*password, {});
    const auto on_worker = [text = *password] { return hash_password(text); };
    change.password_hash = co_await workers_.run(on_worker);
  }
  const auto in_store = [actor, id, change](db::Database& db) {
    return change_user(db, actor, id, change, db::now_ms());
  };
  co_return co_await store_.run(in_store);
}

}  // namespace headstock::access

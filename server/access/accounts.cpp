// Sign-in and passwords: read on the store thread, hash on a worker, write on the store thread.
#include "server/access/accounts.hpp"

#include <algorithm>

#include "db/hash.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/access/audit.hpp"
#include "server/access/guessing.hpp"
#include "server/access/password.hpp"

namespace headstock::access {
namespace {

namespace asio = boost::asio;

std::string seconds_left(std::int64_t until_ms, std::int64_t now_ms) {
  return std::to_string((until_ms - now_ms + 999) / 1000);
}

/// Counts a wrong password; from the policy's limit on, each further one locks for twice as long.
void count_failure(db::Database& db, const std::optional<db::UserRow>& user, const std::string& address,
                   std::int64_t now_ms) {
  const SignInPolicy policy = policy_of(db);
  db::Transaction transaction(db);
  count_address_failure(db, address, policy, now_ms);
  const auto row = user ? db::user(db, user->id) : std::nullopt;
  if (!row) {
    transaction.commit();
    return;
  }
  db::UserRow changed = *row;
  ++changed.failures;
  if (const auto lock = lock_time_ms(changed.failures, policy.failures_before_lock, policy); lock > 0)
    changed.locked_until_ms = now_ms + lock;
  db::update_user(db, changed);
  record(db, Actor{row->id, row->user, Role::viewer, address}, "session.refused",
         std::string("user:").append(std::to_string(row->id)),
         {{"failures", std::to_string(changed.failures)}});
  transaction.commit();
}

}  // namespace

Session start_session(db::Database& db, const db::UserRow& user, const std::string& address, const std::string& how,
                      std::int64_t now_ms) {
  const SignInPolicy policy = policy_of(db);
  Session session{public_part(user), db::random_hex(32), now_ms + policy.session_ms,
                  rights_of(db, user.id, role_from(user.role).value_or(Role::viewer))};
  db::remove_expired_sessions(db, now_ms);
  db::insert_session(db, {db::sha256_hex(session.token), user.id, now_ms, session.expires_ms, address, now_ms});
  record(db, session.actor(address), "session.start", std::string("user:").append(std::to_string(user.id)), {{"how", how}});
  return session;
}

Accounts::Accounts(db::Store& store, db::Pool& workers) : store_(store), workers_(workers) {}

asio::awaitable<db::UserRow> Accounts::checked(std::string user, std::string password, std::string address) {
  const std::int64_t now = db::now_ms();
  const auto find = [user, address, now](db::Database& db) {
    demand_patient_address(db, address, now);
    return db::user_named(db, user);
  };
  const auto row = co_await store_.run(find);
  // Before the hash: somebody who guesses must not keep the workers busy.
  if (row && is_locked(row->locked_until_ms, now))
    throw db::Refusal("locked_out", seconds_left(row->locked_until_ms, now));
  if (password.size() > 1000) throw db::Refusal("wrong_sign_in");
  const std::string hash = row ? row->password : std::string();
  const auto on_worker = [password, hash] { return verify_password(password, hash); };
  const bool right = co_await workers_.run(on_worker);
  if (!row || !right || row->disabled) {
    const auto count = [row, address, now](db::Database& db) { count_failure(db, row, address, now); };
    co_await store_.run(count);
    throw db::Refusal("wrong_sign_in");
  }
  co_return *row;
}

asio::awaitable<Session> Accounts::sign_in(std::string user, std::string password, std::string address) {
  const db::UserRow row = co_await checked(std::move(user), std::move(password), address);
  const auto start = [row, address](db::Database& db) {
    const std::int64_t now = db::now_ms();
    db::Transaction transaction(db);
    // Read again: the account may have been changed, or locked by somebody else's guesses, while we were
    // hashing.
    auto current = db::user(db, row.id);
    if (!current || current->disabled || current->password != row.password)
      throw db::Refusal("wrong_sign_in");
    if (is_locked(current->locked_until_ms, now))
      throw db::Refusal("locked_out", seconds_left(current->locked_until_ms, now));
    current->failures = 0;
    current->locked_until_ms = 0;
    current->last_sign_in_ms = now;
    db::update_user(db, *current);
    Session session = start_session(db, *current, address, "password", now);
    transaction.commit();
    return session;
  };
  co_return co_await store_.run(start);
}

asio::awaitable<void> Accounts::change_password(Actor actor, std::string token, std::string old_password,
                                                std::string new_password) {
  const auto least = co_await store_.run([](db::Database& db) { return policy_of(db).least_password; });
  demand_good_password(new_password, actor.user, least);
  if (new_password == old_password) throw db::Refusal("weak_password");
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
  const auto least = co_await store_.run([](db::Database& db) { return policy_of(db).least_password; });
  demand_good_password(password, user.user, least);
  const auto on_worker = [password] { return hash_password(password); };
  user.password_hash = co_await workers_.run(on_worker);
  const auto create = [actor, user](db::Database& db) { return create_user(db, actor, user, db::now_ms()); };
  co_return co_await store_.run(create);
}

asio::awaitable<User> Accounts::change(Actor actor, std::int64_t id, UserChange change,
                                       std::optional<std::string> password) {
  if (password) {
    demand(actor, Action::manage_users);
    const auto find = [id](db::Database& db) {
      const auto row = db::user(db, id);
      return std::pair(row ? row->user : std::string(), policy_of(db).least_password);
    };
    const auto [name, least] = co_await store_.run(find);
    demand_good_password(*password, name, least);
    const auto on_worker = [text = *password] { return hash_password(text); };
    change.password_hash = co_await workers_.run(on_worker);
  }
  const auto in_store = [actor, id, change](db::Database& db) {
    return change_user(db, actor, id, change, db::now_ms());
  };
  co_return co_await store_.run(in_store);
}

}  // namespace headstock::access

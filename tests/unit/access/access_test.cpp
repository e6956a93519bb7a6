#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>

#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/access/accounts.hpp"
#include "server/access/audit.hpp"
#include "server/access/password.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::access {
namespace {

constexpr ScryptCost kCheap{4, 1, 1};

std::string refusal_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const db::Refusal& refusal) {
    EXPECT_NE(db::refusal_text(refusal.code()), nullptr) << refusal.code();
    return refusal.code();
  }
  return "";
}

/// Runs a coroutine to its end.
template <class T>
T wait_for(boost::asio::awaitable<T> work) {
  boost::asio::io_context io;
  std::exception_ptr error;
  if constexpr (std::is_void_v<T>) {
    boost::asio::co_spawn(io, std::move(work), [&](std::exception_ptr thrown) { error = thrown; });
    io.run();
    if (error) std::rethrow_exception(error);
  } else {
    std::optional<T> result;
    boost::asio::co_spawn(io, std::move(work), [&](std::exception_ptr thrown, T value) {
      error = thrown;
      if (!thrown) result = std::move(value);
    });
    io.run();
    if (error) std::rethrow_exception(error);
    return std::move(*result);
  }
}

NewUser somebody(const std::string& user, Role role) {
  return {user, user, role, "en", hash_password("correct horse", kCheap), false};
}

TEST(Password, IsVerifiedAndNeverEqualTwice) {
  const std::string hash = hash_password("secret 1", kCheap);
  EXPECT_TRUE(verify_password("secret 1", hash));
  EXPECT_FALSE(verify_password("secret 2", hash));
  EXPECT_NE(hash, hash_password("secret 1", kCheap));
  EXPECT_FALSE(verify_password("", ""));
  EXPECT_FALSE(verify_password("x", "scrypt$99$8$1$aa$bb"));
  EXPECT_EQ(random_password().size(), 16u);
  EXPECT_EQ(refusal_of([] { demand_good_password("1234567", "u"); }), "weak_password");
  EXPECT_EQ(refusal_of([] { demand_good_password("operator1", "operator1"); }), "weak_password");
  EXPECT_EQ(refusal_of([] { demand_good_password("八个汉字的密码吧", "u"); }), "");
}

TEST(Roles, EachIncludesTheOnesBefore) {
  for (const Permission& permission : permissions())
    for (const Role role :
         {Role::viewer, Role::operator_, Role::programmer, Role::setter, Role::administrator}) {
      Actor actor;
      actor.role = role;
      EXPECT_EQ(refusal_of([&] { demand(actor, permission.action); }),
                role >= permission.role ? "" : "forbidden");
      EXPECT_EQ(role_from(to_string(role)), role);
    }
  EXPECT_FALSE(role_from("root"));
}

TEST(Users, TheLastAdministratorStays) {
  test::TemporaryFolder folder;
  const auto db = test::open_shop(folder / "s.db");
  const auto password = ensure_first_administrator(*db, 1);
  ASSERT_TRUE(password);
  EXPECT_FALSE(ensure_first_administrator(*db, 2));
  const User admin = list_users(*db).at(0);
  EXPECT_TRUE(admin.must_change_password);
  EXPECT_TRUE(verify_password(*password, db::user(*db, admin.id)->password));
  EXPECT_EQ(refusal_of([&] { delete_user(*db, {}, admin.id, 3); }), "last_administrator");
  UserChange demotion;
  demotion.role = Role::setter;
  EXPECT_EQ(refusal_of([&] { change_user(*db, {}, admin.id, demotion, 3); }), "last_administrator");
  create_user(*db, {}, somebody("second", Role::administrator), 4);
  change_user(*db, {}, admin.id, demotion, 5);
  EXPECT_EQ(refusal_of([&] { create_user(*db, {}, somebody("second", Role::viewer), 6); }), "name_taken");
  EXPECT_EQ(refusal_of([&] { create_user(*db, {}, somebody("no spaces", Role::viewer), 6); }), "bad_name");
}

TEST(Users, MayChangeTheirOwnNameOnly) {
  test::TemporaryFolder folder;
  const auto db = test::open_shop(folder / "s.db");
  const User user = create_user(*db, {}, somebody("op", Role::operator_), 1);
  const Actor actor{user.id, "op", Role::operator_, ""};
  UserChange name;
  name.name = "Li";
  name.language = "zh";
  EXPECT_EQ(change_user(*db, actor, user.id, name, 2).name, "Li");
  UserChange promotion;
  promotion.role = Role::administrator;
  EXPECT_EQ(refusal_of([&] { change_user(*db, actor, user.id, promotion, 3); }), "forbidden");
  EXPECT_EQ(refusal_of([&] { delete_user(*db, actor, user.id, 3); }), "forbidden");
}

struct AccountsTest : testing::Test {
  test::TemporaryFolder folder;
  db::Store store{folder.path(), test::test_database()};
  db::Pool workers{1};
  Accounts accounts{store, workers};
  User user;

  AccountsTest() {
    store.now([&](db::Database& db) { user = create_user(db, {}, somebody("op", Role::operator_), 1); });
  }
  std::optional<Session> find(const std::string& token, std::int64_t at_ms = db::now_ms()) {
    std::optional<Session> session;
    store.now([&](db::Database& db) { session = find_session(db, token, at_ms); });
    return session;
  }
};

TEST_F(AccountsTest, SignInGivesATokenThatExpires) {
  const Session session = wait_for(accounts.sign_in("op", "correct horse", "127.0.0.1"));
  EXPECT_EQ(session.token.size(), 64u);
  ASSERT_TRUE(find(session.token));
  EXPECT_EQ(find(session.token)->user.user, "op");
  EXPECT_FALSE(find(session.token, session.expires_ms));
  EXPECT_FALSE(find(std::string(64, '0')));
  store.now([&](db::Database& db) {
    EXPECT_FALSE(db.integer("SELECT 1 FROM sessions WHERE token_sha256 = ?", {session.token}))
        << "the token itself is stored";
    sign_out(db, session.actor(""), session.token, 1);
  });
  EXPECT_FALSE(find(session.token));
}

TEST_F(AccountsTest, GuessingIsLockedOut) {
  for (int i = 0; i < SignInPolicy{}.failures_before_lock; ++i)
    EXPECT_EQ(refusal_of([&] { wait_for(accounts.sign_in("op", "wrong", "")); }), "wrong_sign_in");
  EXPECT_EQ(refusal_of([&] { wait_for(accounts.sign_in("op", "correct horse", "")); }), "locked_out");
  EXPECT_EQ(refusal_of([&] { wait_for(accounts.sign_in("nobody", "correct horse", "")); }), "wrong_sign_in");
}

TEST_F(AccountsTest, DisablingEndsSessions) {
  const Session session = wait_for(accounts.sign_in("op", "correct horse", ""));
  store.now([&](db::Database& db) {
    UserChange change;
    change.disabled = true;
    change_user(db, {}, user.id, change, 2);
  });
  EXPECT_FALSE(find(session.token));
  EXPECT_EQ(refusal_of([&] { wait_for(accounts.sign_in("op", "correct horse", "")); }), "wrong_sign_in");
}

TEST_F(AccountsTest, ANewPasswordEndsTheOtherSessions) {
  const Session mine = wait_for(accounts.sign_in("op", "correct horse", ""));
  const Session other = wait_for(accounts.sign_in("op", "correct horse", ""));
  EXPECT_EQ(refusal_of([&] {
              wait_for(accounts.change_password(mine.actor(""), mine.token, "wrong", "new password"));
            }),
            "wrong_sign_in");
  wait_for(accounts.change_password(mine.actor(""), mine.token, "correct horse", "new password"));
  EXPECT_TRUE(find(mine.token));
  EXPECT_FALSE(find(other.token));
  wait_for(accounts.sign_in("op", "new password", ""));
}

TEST(Audit, ChainShowsTampering) {
  test::TemporaryFolder folder;
  const auto db = test::open_shop(folder / "s.db");
  for (int i = 0; i < 5; ++i) record(*db, Actor{}, "test", std::to_string(i), {{"k", "v"}});
  EXPECT_EQ(db::first_broken_audit(*db), 0);
  EXPECT_THROW(db->execute("UPDATE audit SET user = 'x'"), db::Error);
  db->script(
      "DROP TRIGGER audit_kept_update; DROP TRIGGER audit_kept_delete");  // somebody with the file in hand
  db->execute("UPDATE audit SET detail = '{}' WHERE id = 3");
  EXPECT_EQ(db::first_broken_audit(*db), 3);
  db->execute("DELETE FROM audit WHERE id = 2");
  EXPECT_EQ(db::first_broken_audit(*db), 2);
}

TEST(Audit, GoesWithTheChange) {
  test::TemporaryFolder folder;
  const auto db = test::open_shop(folder / "s.db");
  create_user(*db, {}, somebody("op", Role::operator_), 1);
  const auto before = db->integer("SELECT COUNT(*) FROM audit");
  EXPECT_THROW(create_user(*db, {}, somebody("op", Role::operator_), 1), db::Refusal);
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM audit"), before);
}

}  // namespace
}  // namespace headstock::access

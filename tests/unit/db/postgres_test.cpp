// What is PostgreSQL's own: a broken connection, one server a database, what its texts cannot hold. The
// stores' tests run on it too (CMakeLists.txt, with-postgresql). Without a server (HEADSTOCK_TEST_DATABASE)
// these are skipped.
#include <gtest/gtest.h>

#include "db/database.hpp"
#include "db/migrations.hpp"
#include "db/user_store.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::db {
namespace {

class Postgres : public testing::Test {
 protected:
  void SetUp() override {
    connection = test::test_database();
    if (connection.empty()) GTEST_SKIP() << "run by tests/with-postgresql";
    db = open_postgres(connection);
    migrate(*db);
  }
  std::optional<Problem> problem_of(const std::function<void()>& action) {
    try {
      action();
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()), "");
      return error.problem();
    }
    return std::nullopt;
  }
  /// As an administrator of the database server would, or a restart of it.
  void break_connection() {
    const std::string command = "psql -qAtX '" + connection +
                                "' -c \"SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE "
                                "application_name = 'headstock'\" >/dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  void put(const char* key, const char* value) {
    db->execute("INSERT INTO settings (key, value) VALUES (?, ?)", {key, value});
  }
  std::string connection;
  std::unique_ptr<Database> db;
};

TEST_F(Postgres, MigratesOnce) {
  EXPECT_EQ(migrate(*db), 0);
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM schema_migrations"),
            static_cast<std::int64_t>(builtin_migrations().size()));
}

TEST_F(Postgres, ASecondServerIsToldSo) {
  EXPECT_EQ(problem_of([&] { open_postgres(connection); }), Problem::locked);
  db.reset();
  EXPECT_EQ(problem_of([&] { open_postgres(connection); }), std::nullopt);
}

TEST_F(Postgres, NoServerSaysWhere) {
  try {
    open_postgres("postgresql://nobody@127.0.0.1:1/shop");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.problem(), Problem::unreadable);
    EXPECT_NE(std::string(error.what()).find("127.0.0.1"), std::string::npos) << error.what();
  }
}

TEST_F(Postgres, APasswordIsNeverInAMessage) {
  try {
    open_postgres("postgresql://nobody:sesame@127.0.0.1:1/shop");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("sesame"), std::string::npos) << error.what();
  }
}

TEST_F(Postgres, ABrokenConnectionLosesTheTransactionAndNothingElse) {
  put("kept", "1");
  {
    Transaction transaction(*db);
    put("half", "1");
    break_connection();
    EXPECT_EQ(problem_of([&] { put("more", "1"); }), Problem::lost);
    // Still inside: nothing of it may slip into a new connection.
    EXPECT_EQ(problem_of([&] { put("even more", "1"); }), Problem::lost);
  }
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM settings WHERE key IN ('kept', 'half', 'more', 'even more')"),
            1);
  put("after", "1");
  EXPECT_EQ(db->text("SELECT value FROM settings WHERE key = ?", {"after"}), "1");
}

TEST_F(Postgres, ABreakBetweenStatementsIsNoticedOnceAndHeals) {
  break_connection();
  problem_of([&] { db->integer("SELECT 1"); });
  EXPECT_EQ(db->integer("SELECT 1"), 1);
  EXPECT_EQ(problem_of([&] { open_postgres(connection); }), Problem::locked) << "it holds the database again";
}

TEST_F(Postgres, AThrowingHandlerLeavesTheConnectionUsable) {
  for (int i = 0; i < 100; ++i) put(std::to_string(i).c_str(), "x");
  int seen = 0;
  EXPECT_THROW(db->each("SELECT key FROM settings ORDER BY key", {},
                        [&](const Row&) {
                          if (++seen == 3) throw std::runtime_error("enough");
                        }),
               std::runtime_error);
  EXPECT_EQ(seen, 3);
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM settings"), 100);
}

TEST_F(Postgres, TextsThatItCannotHoldAreKeptReadable) {
  const std::string wild = std::string("a\0b", 3) + "\xFF" + "\xED\xA0\x80" + "\xC3\xA9" + "\xE5\x8D\x97";
  db->execute("INSERT INTO settings (key, value) VALUES (?, ?)", {"wild", wild});
  EXPECT_EQ(db->text("SELECT value FROM settings WHERE key = 'wild'"),
            "a\xEF\xBF\xBD"
            "b\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xC3\xA9\xE5\x8D\x97");
}

TEST_F(Postgres, NumbersComeBackBitForBit) {
  db->execute("CREATE TABLE numbers (i BIGINT, r DOUBLE PRECISION)");
  for (const double real : {0.1, 1e-300, -1.0 / 3.0, 123456789.123456789}) {
    db->execute("INSERT INTO numbers (i, r) VALUES (?, ?)", {std::int64_t{1} << 62, real});
    db->each("SELECT i, r FROM numbers", {}, [&](const Row& row) {
      EXPECT_EQ(row.integer(0), std::int64_t{1} << 62);
      EXPECT_EQ(row.real(1), real);
    });
    db->execute("DELETE FROM numbers");
  }
}

TEST_F(Postgres, ARefusedRowIsAConstraint) {
  put("a", "1");
  EXPECT_EQ(problem_of([&] { put("a", "2"); }), Problem::constraint);
  append_audit(*db, {0, 1, "u", "", "a", "s", "{}", "", ""});
  EXPECT_EQ(problem_of([&] { db->execute("DELETE FROM audit"); }), Problem::constraint);
  EXPECT_EQ(problem_of([&] { db->execute("UPDATE audit SET user = 'x'"); }), Problem::constraint);
}

}  // namespace
}  // namespace headstock::db

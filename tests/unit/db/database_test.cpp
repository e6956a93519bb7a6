#include "db/database.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "db/migrations.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::db {
namespace {

using test::TemporaryFolder;

std::optional<Problem> problem_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()), "");
    return error.problem();
  }
  return std::nullopt;
}

constexpr Migration kTwo[] = {{1, "0001_a.sql", "CREATE TABLE a (x INTEGER)"},
                              {2, "0002_b.sql", "CREATE TABLE b (x INTEGER)"}};

TEST(Migrations, FromEmptyThenNothingMore) {
  TemporaryFolder folder;
  auto db = open_sqlite(folder / "s.db");
  EXPECT_EQ(migrate(*db), static_cast<int>(builtin_migrations().size()));
  EXPECT_EQ(migrate(*db), 0);
  db.reset();
  db = open_sqlite(folder / "s.db");
  EXPECT_EQ(migrate(*db), 0);
  EXPECT_EQ(db->text("PRAGMA journal_mode"), "wal");
  EXPECT_EQ(db->integer("PRAGMA synchronous"), 2);
  EXPECT_EQ(db->integer("PRAGMA foreign_keys"), 1);
}

TEST(Migrations, AreInOrderOfTheirNumbers) {
  int last = 0;
  for (const Migration& migration : builtin_migrations()) {
    EXPECT_GT(migration.number, last);
    last = migration.number;
  }
}

TEST(Migrations, OneWithALowerNumberMayComeLater) {
  TemporaryFolder folder;
  auto db = open_sqlite(folder / "s.db");
  const Migration gap[] = {kTwo[0], {3, "0003_c.sql", "CREATE TABLE c (x INTEGER)"}};
  EXPECT_EQ(migrate(*db, gap), 2);
  const Migration filled[] = {kTwo[0], kTwo[1], gap[1]};
  EXPECT_EQ(migrate(*db, filled), 1);
  EXPECT_TRUE(db->has_table("b"));
}

TEST(Migrations, AppliesOnlyWhatIsNew) {
  TemporaryFolder folder;
  auto db = open_sqlite(folder / "s.db");
  EXPECT_EQ(migrate(*db, std::span(kTwo).first(1)), 1);
  EXPECT_EQ(migrate(*db, kTwo), 1);
}

TEST(Migrations, RefusesANewerDatabaseAndTouchesNothing) {
  TemporaryFolder folder;
  {
    auto db = open_sqlite(folder / "s.db");
    migrate(*db, kTwo);
  }
  auto db = open_sqlite(folder / "s.db");
  const auto version = db->integer("PRAGMA data_version");
  EXPECT_EQ(problem_of([&] { migrate(*db, std::span(kTwo).first(1)); }), Problem::newer);
  EXPECT_EQ(db->integer("PRAGMA data_version"), version);
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM schema_migrations"), 2);
}

TEST(Migrations, RefusesAChangedOldOne) {
  TemporaryFolder folder;
  auto db = open_sqlite(folder / "s.db");
  migrate(*db, std::span(kTwo).first(1));
  const Migration changed[] = {{1, "0001_a.sql", "CREATE TABLE a (x TEXT)"}, kTwo[1]};
  EXPECT_EQ(problem_of([&] { migrate(*db, changed); }), Problem::tampered);
  EXPECT_FALSE(db->integer("SELECT 1 FROM sqlite_master WHERE name = 'b'"));
}

TEST(Migrations, AFailingOneLeavesNothingOfItself) {
  TemporaryFolder folder;
  auto db = open_sqlite(folder / "s.db");
  const Migration broken[] = {kTwo[0],
                              {2, "0002_b.sql", "CREATE TABLE b (x INTEGER); CREATE TABLE b (y INTEGER)"}};
  EXPECT_TRUE(problem_of([&] { migrate(*db, broken); }));
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM schema_migrations"), 1);
  EXPECT_FALSE(db->integer("SELECT 1 FROM sqlite_master WHERE name = 'b'"));
  EXPECT_EQ(migrate(*db, kTwo), 1);
}

TEST(Opening, ASecondServerIsToldSo) {
  TemporaryFolder folder;
  const auto db = test::open_shop(folder / "s.db");
  const pid_t child = ::fork();
  if (child == 0) {
    const bool locked = problem_of([&] { test::open_shop(folder / "s.db"); }) == Problem::locked;
    ::_exit(locked ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

TEST(Opening, ADamagedFileIsRefusedAndKept) {
  TemporaryFolder folder;
  {
    auto db = test::open_shop(folder / "s.db");
    db->execute("INSERT INTO settings (key, value) VALUES ('k', ?)", {std::string(50'000, 'x')});
  }
  std::string bytes = test::read_file(folder / "s.db");
  ASSERT_GT(bytes.size(), 40'000u);
  for (std::size_t i = 4096; i < 12'288; ++i) bytes[i] = static_cast<char>(i * 7);
  std::ofstream(folder / "s.db", std::ios::binary) << bytes;
  EXPECT_EQ(problem_of([&] { open_sqlite(folder / "s.db"); }), Problem::corrupt);
  EXPECT_EQ(test::read_file(folder / "s.db"), bytes);
}

TEST(Opening, SomethingElseIsNotADatabase) {
  TemporaryFolder folder;
  const std::string text(10'000, 'G');
  std::ofstream(folder / "s.db") << text;
  EXPECT_EQ(problem_of([&] { open_sqlite(folder / "s.db"); }), Problem::corrupt);
  EXPECT_EQ(test::read_file(folder / "s.db"), text);
  EXPECT_EQ(problem_of([&] { open_sqlite(folder.path()); }), Problem::unreadable);
}

TEST(Transactions, NestAndUndo) {
  TemporaryFolder folder;
  const auto db = test::open_shop(folder / "s.db");
  const auto put = [&](const char* key) {
    db->execute("INSERT INTO settings (key, value) VALUES (?, '')", {key});
  };
  {
    Transaction outer(*db);
    put("kept");
    {
      Transaction inner(*db);
      put("undone");
    }
    {
      Transaction inner(*db);
      put("kept too");
      inner.commit();
    }
    outer.commit();
  }
  {
    Transaction outer(*db);
    {
      Transaction inner(*db);
      put("undone with the outer one");
      inner.commit();
    }
  }
  std::vector<std::string> keys;
  db->each("SELECT key FROM settings ORDER BY key", {}, [&](const Row& row) { keys.push_back(row.text(0)); });
  EXPECT_EQ(keys, (std::vector<std::string>{"kept", "kept too"}));
}

TEST(History, CannotBeRewritten) {
  TemporaryFolder folder;
  const auto db = test::open_shop(folder / "s.db");
  db->execute(
      "INSERT INTO blobs (sha256, bytes, lines, longest_line, encoding, line_ends, nul_bytes, has_percent, "
      "created_ms) "
      "VALUES ('a', 1, 1, 1, 'ascii', 'lf', 0, 0, 1)");
  EXPECT_EQ(problem_of([&] { db->execute("UPDATE blobs SET bytes = 2"); }), Problem::constraint);
  EXPECT_EQ(problem_of([&] { db->execute("DELETE FROM blobs"); }), Problem::constraint);
}

}  // namespace
}  // namespace headstock::db

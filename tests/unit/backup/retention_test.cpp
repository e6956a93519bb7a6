#include "server/backup/retention.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "db/access_store.hpp"
#include "db/backup_store.hpp"
#include "db/event_store.hpp"
#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "server/backup/archive.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::backup {
namespace {

constexpr std::int64_t kHour = 3'600'000, kDay = 24 * kHour;

struct RetentionTest : testing::Test {
  RetentionTest() {
    db::MachineRow row;
    row.name = "Lathe 1";
    row.profile = "fanuc-0i-t";
    machine = db::insert_machine(*db, row);
  }
  void state(const char* name, std::int64_t from, std::optional<std::int64_t> to,
             const char* source = "machine") {
    db->execute(
        "INSERT INTO state_intervals (machine_id, state, mode, source, from_ms, to_ms) VALUES (?, ?, "
        "'memory', ?, ?, ?)",
        {machine, name, source, from, to});
  }
  std::vector<db::StateRow> states() {
    std::vector<db::StateRow> found;
    db::each_state(*db, {machine, std::nullopt, std::nullopt},
                   [&](const db::StateRow& row) { found.push_back(row); });
    return found;
  }
  /// Milliseconds of each state in each hour.
  std::map<std::pair<std::int64_t, std::string>, std::int64_t> by_hour() {
    std::map<std::pair<std::int64_t, std::string>, std::int64_t> sums;
    for (const auto& row : states())
      for (std::int64_t at = row.from_ms; at < row.to_ms.value_or(100 * kDay);) {
        const auto until = std::min(row.to_ms.value_or(100 * kDay), (at / kHour + 1) * kHour);
        sums[{at / kHour, row.state + row.source}] += until - at;
        at = until;
      }
    return sums;
  }
  void coarsen(std::int64_t before) {
    while (coarsen_states(*db, machine, before)) {
    }
  }

  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> db = test::open_shop(folder / "s.db");
  std::int64_t machine = 0;
};

TEST_F(RetentionTest, EveryHourKeepsItsSecondsOfEveryState) {
  std::mt19937 random(7);
  const char* const names[] = {"running", "idle", "alarm", "hold"};
  std::int64_t at = 12'345;
  while (at < 20 * kDay) {
    const std::int64_t length = 1'000 + static_cast<std::int64_t>(random() % 400'000);
    state(names[random() % 4], at, at + length, random() % 10 == 0 ? "server" : "machine");
    at += length;
  }
  state("running", at, std::nullopt);
  const auto before = by_hour();
  const auto rows = states().size();
  coarsen(10 * kDay);
  EXPECT_EQ(by_hour(), before);
  EXPECT_LT(states().size(), rows * 7 / 10);
  const auto after = states();
  for (std::size_t i = 1; i < after.size(); ++i)
    EXPECT_EQ(after[i].from_ms, after[i - 1].to_ms) << "no hole, no overlap";
  EXPECT_FALSE(after.back().to_ms);
  const auto fine = states().size();
  coarsen(10 * kDay);
  EXPECT_EQ(states().size(), fine) << "once is enough";
  coarsen(15 * kDay);
  EXPECT_EQ(by_hour(), before);
  EXPECT_LT(states().size(), fine);
}

TEST_F(RetentionTest, LongStatesAndHolesStayAsTheyAre) {
  state("off", 0, 5 * kDay);
  state("running", 6 * kDay, 6 * kDay + 10);
  state("idle", 6 * kDay + 10, std::nullopt);
  const auto before = by_hour();
  coarsen(9 * kDay);
  EXPECT_EQ(by_hour(), before);
  EXPECT_LE(states().size(), 3u + 5u);
}

TEST_F(RetentionTest, OldEventsGoIntoAFileAndPartsStay) {
  db::spool_sequence(*db, machine, "s", 1);
  for (int i = 1; i <= 100; ++i)
    db::insert_event(*db, {machine, "s", i, i, i * kDay, i % 10 == 0 ? "part" : "state", R"({"n":"车"})"});
  EXPECT_EQ(archive_events(*db, folder.path(), 51 * kDay, 200 * kDay), 45);
  EXPECT_EQ(archive_events(*db, folder.path(), 51 * kDay, 200 * kDay), 0);
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM events"), 55);
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM events WHERE kind = 'part'"), 10);
  const auto archives = db::event_archives(*db);
  ASSERT_EQ(archives.size(), 1u);
  std::string text;
  each_entry(folder.path() / "archive" / archives[0].file, [&](Entry& entry) { text += entry.all(); });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 45);
  EXPECT_NE(text.find("车"), std::string::npos);
  // The guard is closed again.
  EXPECT_THROW(db->execute("DELETE FROM events"), db::Error);
}

TEST_F(RetentionTest, TheGuardIsClosedEvenWhenTheWorkFails) {
  db::spool_sequence(*db, machine, "s", 1);
  db::insert_event(*db, {machine, "s", 1, 1, 1, "state", "{}"});
  {
    db::Transaction transaction(*db);
    db->set_guard("events", "events_kept_delete", db::Guard::open);
    db->execute("DELETE FROM events");
  }  // undone
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM events"), 1);
  EXPECT_THROW(db->execute("DELETE FROM events"), db::Error);
}

TEST_F(RetentionTest, SettingsAreRefusedOutsideTheirRange) {
  const auto refused = [&](const RetentionSettings& settings) {
    try {
      set_retention(*db, access::Actor{}, settings);
    } catch (const db::Refusal& refusal) {
      return refusal.where();
    }
    return std::string();
  };
  EXPECT_EQ(refused({6, 0, 0, 24, 7}), "events_days");
  EXPECT_EQ(refused({0, 7, 0, 24, 0}), "backups_kept");
  EXPECT_EQ(refused({0, -1, 0, 24, 7}), "states_days");
  EXPECT_EQ(refused({365, 90, 30, 0, 3}), "");
  EXPECT_EQ(retention_settings(*db).states_days, 90);
}

}  // namespace
}  // namespace headstock::backup

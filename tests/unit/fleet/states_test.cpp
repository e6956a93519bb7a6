#include "server/fleet/states.hpp"

#include <gtest/gtest.h>

#include <random>

#include "db/event_store.hpp"
#include "db/machine_store.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::fleet {
namespace {

struct States : testing::Test {
  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> db = test::open_shop(folder / "s.db");
  std::int64_t machine = 0;

  States() {
    db::MachineRow row;
    row.name = "m";
    row.profile = "fanuc-0i-t";
    machine = db::insert_machine(*db, row);
  }
  void said(const char* state, std::int64_t at) {
    record_state(*db, machine, state, "memory", at, Witness::machine);
  }

  /// "idle 0-10, running 10-" — and the chain must have neither holes nor overlaps.
  std::string record() {
    std::string text;
    std::optional<std::int64_t> end;
    bool first = true;
    for (const db::StateRow& row : db::states(*db, {machine, {}, {}})) {
      if (!first) {
        EXPECT_EQ(end, row.from_ms) << "a hole or an overlap";
      }
      first = false;
      end = row.to_ms;
      if (!text.empty()) text += ", ";
      text +=
          row.state + " " + std::to_string(row.from_ms) + "-" + (row.to_ms ? std::to_string(*row.to_ms) : "");
    }
    EXPECT_FALSE(end) << "the last one is open";
    return text;
  }
};

TEST_F(States, FollowEachOther) {
  said("idle", 0);
  said("running", 10);
  said("running", 12);
  said("alarm", 20);
  EXPECT_EQ(record(), "idle 0-10, running 10-20, alarm 20-");
}

TEST_F(States, MayArriveLate) {
  said("alarm", 20);
  said("idle", 0);
  said("running", 10);
  EXPECT_EQ(record(), "idle 0-10, running 10-20, alarm 20-");
}

TEST_F(States, SilenceIsUnknown) {
  said("running", 10);
  record_silence(*db, machine, "unknown", 30);
  record_silence(*db, machine, "unknown", 30);
  EXPECT_EQ(record(), "running 10-30, unknown 30-");
}

TEST_F(States, ALostLinkWasNoSilenceOfTheMachine) {
  said("running", 10);
  record_silence(*db, machine, "unknown", 30);
  record_return(*db, machine, true, 60);
  said("idle", 45);  // what the spool kept
  EXPECT_EQ(record(), "running 10-45, idle 45-");
}

TEST_F(States, ARestartOfTheMachineLeavesTheSilence) {
  said("running", 10);
  record_silence(*db, machine, "unknown", 30);
  record_return(*db, machine, false, 60);
  said("idle", 58);
  EXPECT_EQ(record(), "running 10-30, unknown 30-58, idle 58-");
}

TEST_F(States, AServerRestartClosesWhereItLastHeard) {
  said("running", 10);
  db->execute("UPDATE machines SET last_seen_ms = 25 WHERE id = ?", {machine});
  close_after_restart(*db);
  close_after_restart(*db);
  EXPECT_EQ(record(), "running 10-25, unknown 25-");
  record_return(*db, machine, true, 90);
  EXPECT_EQ(record(), "running 10-");
}

TEST_F(States, AnyOrderIsAWholeRecord) {
  std::mt19937 random(3);
  const char* const names[] = {"idle", "running", "hold", "alarm"};
  for (int i = 0; i < 400; ++i) {
    const auto at = static_cast<std::int64_t>(random() % 1'000);
    switch (random() % 6) {
      case 0:
        record_silence(*db, machine, "unknown", at);
        break;
      case 1:
        record_return(*db, machine, random() % 2 == 0, at);
        break;
      default:
        said(names[random() % 4], at);
    }
    record();
    ASSERT_FALSE(HasFailure()) << "after step " << i;
  }
}

}  // namespace
}  // namespace headstock::fleet

// Two witnesses of every part, the recount, and orders.
#include "server/fleet/counts.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "db/refusal.hpp"
#include "server/fleet/events.hpp"
#include "server/fleet/machines.hpp"
#include "server/fleet/orders.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::fleet {
namespace {

using nlohmann::json;

struct Counts : testing::Test {
  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> db = test::open_shop(folder / "s.db");
  std::int64_t machine = create_machine(*db, {}, "Lathe 1", "fanuc-0i-t", "", 1).id;
  access::Actor li{7, "li", access::Role::operator_, ""};

  static json part(std::int64_t sequence, std::int64_t total, const char* program = "O1") {
    return {{"seq", sequence}, {"at_ms", 1'000 * sequence}, {"kind", "part"}, {"count", total},
            {"total", total},  {"program", program},        {"sha256", "aa"}, {"cycle_s", 10}};
  }
  static json started(std::int64_t sequence, std::int64_t run, std::int64_t total) {
    return {{"seq", sequence},       {"at_ms", 1'000 * sequence},
            {"kind", "run_started"}, {"run", run},
            {"program", "O1"},       {"sha256", "aa"},
            {"total", total},        {"by", "li"}};
  }
  static json ended(std::int64_t sequence, std::int64_t run, std::int64_t total,
                    const char* outcome = "completed") {
    return {{"seq", sequence},
            {"at_ms", 1'000 * sequence},
            {"kind", "run_ended"},
            {"run", run},
            {"outcome", outcome},
            {"run_s", 9},
            {"cutting_s", 5},
            {"total", total},
            {"holds", 2},
            {"alarms", 0},
            {"overrides", {{"feed", {80, 100}}}}};
  }
  Intake take(json events) { return take_in(*db, machine, "spool", events, 5'000); }
};

TEST_F(Counts, WitnessesThatAgreeSayNothing) {
  const Intake intake =
      take({started(1, 1, 0), part(2, 1), ended(3, 1, 1), started(4, 2, 1), ended(5, 2, 1, "reset"),
            started(6, 3, 1), part(7, 2), part(8, 3), ended(9, 3, 3)});
  EXPECT_TRUE(intake.raised.empty());
  EXPECT_TRUE(disagreements(*db, 0, {}).items.empty());
  const auto runs = db::runs(*db, {machine, {}, {}}, {}).items;
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_EQ(runs[2].by, "li");
  EXPECT_EQ(runs[2].holds, 2);
  EXPECT_EQ(json::parse(runs[2].overrides_json)["feed"][0], 80);
}

TEST_F(Counts, ACounterThatJumpsIsANamedAlarmUntilSomebodyHasLooked) {
  take({part(1, 1), part(2, 2)});
  const Intake intake = take(json::array({part(3, 4)}));
  ASSERT_EQ(intake.raised.size(), 1u);
  EXPECT_EQ(intake.raised[0].code, kCountAlarm);
  EXPECT_NE(intake.raised[0].text_en.find("from 2 to 4"), std::string::npos);
  const auto found = disagreements(*db, machine, {}).items;
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, "counter_step");
  db::AlarmFilter active;
  active.active_only = true;
  EXPECT_EQ(db::alarms(*db, active, {}).items.size(), 1u);
  acknowledge(*db, li, found[0].id, 9'000);
  EXPECT_TRUE(db::alarms(*db, active, {}).items.empty());
  EXPECT_EQ(disagreements(*db, machine, {}).items[0].seen_by, "li");
}

TEST_F(Counts, ARunWhoseCounterGrewByMoreThanWasTold) {
  const Intake intake = take({started(1, 1, 10), part(2, 11), ended(3, 1, 12)});
  ASSERT_EQ(intake.raised.size(), 1u);
  const auto found = disagreements(*db, machine, {}).items;
  EXPECT_EQ(found[0].kind, "run_parts");
  EXPECT_EQ(found[0].counted, 1);
  EXPECT_EQ(found[0].witness, 2);
}

TEST_F(Counts, EventsThatOvertakeEachOtherAreNoDisagreement) {
  EXPECT_TRUE(take({part(2, 2), part(4, 4)}).raised.empty());
  EXPECT_TRUE(take({part(3, 3), part(1, 1)}).raised.empty());
  EXPECT_TRUE(take(json::array({part(5, 5)})).raised.empty());
}

TEST_F(Counts, AnAgentThatSaysLessIsNotAccused) {
  json old_start = started(1, 1, 0), old_end = ended(3, 1, 0);
  old_start.erase("total");
  old_end.erase("total");
  EXPECT_TRUE(take({old_start, part(2, 1), old_end}).raised.empty());
}

TEST_F(Counts, TheRecountFromRawEventsIsTheSame) {
  std::mt19937 random(3);
  std::int64_t sequence = 0, total = 0;
  std::vector<json> all;
  for (std::int64_t run = 1; run <= 200; ++run) {
    all.push_back(started(++sequence, run, total));
    if (random() % 5 != 0) all.push_back(part(++sequence, ++total));
    if (random() % 10 != 0)
      all.push_back(ended(++sequence, run, total, random() % 4 == 0 ? "alarm" : "completed"));
  }
  for (int round = 0; round < 400; ++round) {  // repeats and orders of every kind
    json batch = json::array();
    for (int i = 0; i < 10; ++i) batch.push_back(all[random() % all.size()]);
    take(batch);
  }
  take(json(all));
  const auto counted = recount(*db, machine);
  ASSERT_EQ(counted.size(), 1u);
  EXPECT_TRUE(counted[0].differences.empty()) << counted[0].differences[0];
  EXPECT_EQ(counted[0].parts, total);
  EXPECT_EQ(counted[0].parts_stored, total);
  EXPECT_EQ(counted[0].runs, 200);
  EXPECT_EQ(counted[0].runs_stored, 200);
  EXPECT_TRUE(disagreements(*db, 0, {}).items.empty());
}

TEST_F(Counts, TheRecountFindsWhatWasTamperedWith) {
  take({started(1, 1, 0), part(2, 1), ended(3, 1, 1)});
  db->execute("UPDATE runs SET outcome = 'reset'");
  db->script("DROP TRIGGER parts_kept_delete");
  db->execute("DELETE FROM parts");
  const auto counted = recount(*db, 0);
  ASSERT_EQ(counted[0].differences.size(), 2u);
  EXPECT_NE(counted[0].differences[0].find("not in the table"), std::string::npos);
  EXPECT_NE(counted[0].differences[1].find("events: O1 1000 3000 completed"), std::string::npos);
}

TEST_F(Counts, AnOrderCountsItsPartsLessWhatWasRejected) {
  const Order order =
      make_order(*db, li, {.name = "4711", .machine = machine, .program = "O1", .required = 3}, 1'500);
  take({part(1, 1), part(2, 2), part(3, 3), part(4, 4, "O2")});
  db->execute(
      "INSERT INTO rejects (machine_id, at_ms, program, quantity, why, by_user, entered_ms) VALUES (?, 2500, "
      "'O1', 1, "
      "'scratch', 'li', 2500)",
      {machine});
  auto open = orders(*db, true);
  ASSERT_EQ(open.size(), 1u);
  EXPECT_EQ(open[0].made, 2) << "the first was before the order, the last another program";
  EXPECT_EQ(open[0].rejected, 1);
  close_order(*db, li, order.id, 2'999);
  EXPECT_TRUE(orders(*db, true).empty());
  EXPECT_EQ(orders(*db, false)[0].made, 1) << "later parts are not its";
  EXPECT_THROW(close_order(*db, li, order.id, 3'000), db::Refusal);
  EXPECT_THROW(make_order(*db, li, {.name = "x", .required = 0}, 1), db::Refusal);
}

}  // namespace
}  // namespace headstock::fleet

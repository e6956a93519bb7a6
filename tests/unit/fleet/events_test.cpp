#include "server/fleet/events.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "db/machine_store.hpp"
#include "server/fleet/machines.hpp"
#include "tests/unit/db/temporary_folder.hpp"

namespace headstock::fleet {
namespace {

using nlohmann::json;

json part(std::int64_t sequence) {
  return {{"seq", sequence},   {"at_ms", 1'000 + sequence}, {"kind", "part"},    {"count", sequence},
          {"total", sequence}, {"program", "O1"},           {"sha256", nullptr}, {"cycle_s", 12.5}};
}

struct Events : testing::Test {
  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> db = test::open_shop(folder / "s.db");
  std::int64_t machine = create_machine(*db, {}, "m", "fanuc-0i-t", "", 1).id;

  Intake take(const json& events, const char* spool = "spool") {
    return take_in(*db, machine, spool, events, 5'000);
  }
  std::int64_t count() { return db::part_total(*db, {machine, {}, {}}); }
};

TEST_F(Events, CountOnceHoweverOftenTheyCome) {
  EXPECT_EQ(take({part(1), part(2)}).sequence, 2u);
  const Intake again = take({part(1), part(2), part(3)});
  EXPECT_EQ(again.sequence, 3u);
  EXPECT_EQ(again.parts.size(), 1u);
  EXPECT_EQ(count(), 3);
}

TEST_F(Events, ABatchThatOvertookAnotherLosesNothing) {
  EXPECT_EQ(take({part(4), part(3)}).sequence, 0u);  // 1 and 2 are still to come
  EXPECT_EQ(take({part(2), part(1)}).sequence, 4u);
  EXPECT_EQ(count(), 4);
}

TEST_F(Events, RandomRepeatsAndOrdersCountExactly) {
  std::mt19937 random(4);
  std::uint64_t acknowledged = 0;
  for (int round = 0; round < 300; ++round) {
    json batch = json::array();
    for (int i = 0; i < 20; ++i) batch.push_back(part(1 + static_cast<std::int64_t>(random() % 200)));
    const auto sequence = take(batch).sequence;
    EXPECT_GE(sequence, acknowledged);
    acknowledged = sequence;
  }
  json all = json::array();
  for (std::int64_t i = 1; i <= 200; ++i) all.push_back(part(i));
  EXPECT_EQ(take(all).sequence, 200u);
  EXPECT_EQ(count(), 200);
}

TEST_F(Events, ANewSpoolStartsAnew) {
  take({part(1), part(2)});
  EXPECT_EQ(take(json::array({part(1)}), "another").sequence, 1u);
  EXPECT_EQ(count(), 3);
  EXPECT_EQ(take(json::array({part(2)})).sequence, 2u);  // the old one comes back: still known
  EXPECT_EQ(count(), 3);
}

TEST_F(Events, WhatTheAgentHasThrownAwayIsNotedAsAGap) {
  db::skip_spool_to(*db, machine, "spool", 10, 1);
  EXPECT_EQ(take(json::array({part(11)})).sequence, 11u);
  EXPECT_EQ(db->integer("SELECT last_sequence FROM event_gaps WHERE first_sequence = 1"), 10);
}

TEST_F(Events, AlarmsAreRaisedAndCleared) {
  const json raised = {{"seq", 1},
                       {"at_ms", 10},
                       {"kind", "alarm"},
                       {"id", 7},
                       {"code", "OT0500"},
                       {"line", 4},
                       {"text", {{"en", "OVER TRAVEL"}, {"zh", "超程"}}},
                       {"program", "O1"},
                       {"block", "G01 X999."}};
  EXPECT_EQ(take(json::array({raised})).raised.size(), 1u);
  db::AlarmFilter active;
  active.active_only = true;
  ASSERT_EQ(db::alarms(*db, active, {}).items.size(), 1u);
  EXPECT_EQ(db::alarms(*db, active, {}).items[0].text_zh, "超程");
  const Intake cleared =
      take(json::array({{{"seq", 2}, {"at_ms", 20}, {"kind", "alarm_cleared"}, {"id", 7}}}));
  ASSERT_EQ(cleared.cleared.size(), 1u);
  EXPECT_EQ(cleared.cleared[0].cleared_ms, 20);
  EXPECT_TRUE(db::alarms(*db, active, {}).items.empty());
  // A controller that was restarted counts its alarms from the start again.
  json later = raised;
  later["seq"] = 3;
  EXPECT_EQ(take(json::array({later})).raised.size(), 1u);
  db::AlarmFilter text;
  text.text = "超";
  EXPECT_EQ(db::alarms(*db, text, {}).items.size(), 2u);
  text.text = "100%";
  EXPECT_TRUE(db::alarms(*db, text, {}).items.empty());
}

TEST_F(Events, RunsMeetTheirEnd) {
  take({{{"seq", 1}, {"at_ms", 10}, {"kind", "run_started"}, {"run", 1}, {"program", "O1"}, {"sha256", "aa"}},
        {{"seq", 2},
         {"at_ms", 90},
         {"kind", "run_ended"},
         {"run", 1},
         {"outcome", "completed"},
         {"run_s", 80.0},
         {"cutting_s", 50.0}}});
  const auto runs = db::runs(*db, {machine, {}, {}}, {}).items;
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].outcome, "completed");
  EXPECT_EQ(runs[0].started_ms, 10);
  EXPECT_EQ(runs[0].ended_ms, 90);
}

TEST_F(Events, OffsetsBecomeTheDocumentOfTheChecks) {
  const auto change = [](std::int64_t sequence, const char* what, double value) {
    return json{{"seq", sequence}, {"at_ms", sequence}, {"kind", "offset"}, {"what", what},
                {"before", 0.0},   {"after", value},    {"origin", "panel"}};
  };
  take({change(1, "work/G54/Z", -100.5), change(2, "tool/3/geometry/X", 12.0),
        change(3, "tool/3/radius", 0.4), change(4, "work/EXT/X", 1.0), change(5, "parameter/3402#0", 1.0)});
  const auto row = db::machine(*db, machine);
  EXPECT_EQ(json::parse(row->offsets_json),
            json::parse(R"({"work":{"G54":{"Z":-100.5}},"tools":{"3":{"geometry":{"X":12.0},"radius":0.4}},
    "external":{"X":1.0}})"));
  EXPECT_EQ(row->offsets_version, 1);
  EXPECT_EQ(db::offsets(*db, machine).size(), 5u);
}

TEST_F(Events, NonsenseIsKeptButHarmsNothing) {
  const Intake intake = take({{{"seq", 1}, {"at_ms", "x"}, {"kind", "part"}, {"count", "many"}},
                              {{"seq", 2}, {"kind", "from the future"}, {"value", 1}},
                              {{"seq", 3}, {"kind", "alarm"}, {"text", 5}},
                              "not even an object",
                              {{"kind", "no sequence"}}});
  EXPECT_EQ(intake.sequence, 3u);
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM events"), 3);
}

}  // namespace
}  // namespace headstock::fleet

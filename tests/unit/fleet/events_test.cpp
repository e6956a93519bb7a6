#include "server/fleet/events.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "db/machine_store.hpp"
#include "server/fleet/counts.hpp"
#include "server/fleet/event_times.hpp"
#include "server/fleet/machines.hpp"
#include "tests/unit/db/shop_database.hpp"

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

struct ClockJumps : Events {
  static constexpr std::int64_t kNow = 1'000'000'000;
  std::int64_t sequence = 0;

  Intake state(const char* name, std::int64_t at_ms, std::int64_t heard_ms) {
    const json event = {
        {"seq", ++sequence}, {"at_ms", at_ms}, {"kind", "state"}, {"state", name}, {"mode", "memory"}};
    return take_in(*db, machine, "spool", json::array({event}), heard_ms);
  }
  /// "idle 0, running 10": state and start in seconds after kNow; the chain is whole and its last is open.
  std::string record() {
    std::string text;
    std::optional<std::int64_t> end;
    bool first = true;
    for (const db::StateRow& row : db::states(*db, {machine, {}, {}})) {
      EXPECT_TRUE(first || end == row.from_ms) << "a hole or an overlap at " << row.from_ms;
      end = row.to_ms;
      text += (first ? "" : ", ") + row.state + " " + std::to_string((row.from_ms - kNow) / 1000);
      first = false;
    }
    EXPECT_FALSE(end);
    return text;
  }
};

TEST_F(ClockJumps, AheadIsANamedAlarmAndNothingIsRecordedInTheFuture) {
  EXPECT_TRUE(state("idle", kNow, kNow).raised.empty());
  const Intake jumped = state("running", kNow + 3'600'000, kNow + 10'000);
  ASSERT_EQ(jumped.raised.size(), 1u);
  EXPECT_EQ(jumped.raised[0].code, kClockAlarm);
  EXPECT_NE(jumped.raised[0].text_en.find("3590 s ahead"), std::string::npos) << jumped.raised[0].text_en;
  EXPECT_TRUE(state("hold", kNow + 3'620'000, kNow + 30'000).raised.empty()) << "the same is one event";
  const Intake right = state("running", kNow + 40'000, kNow + 40'000);
  ASSERT_EQ(right.cleared.size(), 1u) << "set right";
  EXPECT_EQ(right.cleared[0].id, jumped.raised[0].id);
  EXPECT_EQ(record(), "idle 0, running 10, hold 30, running 40");
  std::int64_t told = 0;
  db->each("SELECT body FROM events WHERE sequence = 2", {},
           [&](const db::Row& row) { told = json::parse(row.text(0))["at_ms"]; });
  EXPECT_EQ(told, kNow + 3'600'000) << "the raw event says what the machine said";
}

TEST_F(ClockJumps, BackKeepsTheOrderOfTheMachine) {
  state("idle", kNow, kNow);
  state("running", kNow + 3'600'000, kNow + 3'600'000);
  const Intake jumped = state("alarm", kNow + 60'000, kNow + 3'660'000);
  ASSERT_EQ(jumped.raised.size(), 1u);
  EXPECT_NE(jumped.raised[0].text_en.find("went back by 3540 s"), std::string::npos)
      << jumped.raised[0].text_en;
  EXPECT_EQ(record(), "idle 0, alarm 3600") << "what the machine does now is not hidden behind what it did";
  EXPECT_EQ(state("running", kNow + 3'700'000, kNow + 3'700'000).cleared.size(), 1u);
  EXPECT_EQ(record(), "idle 0, alarm 3600, running 3700");
}

TEST_F(ClockJumps, LateDeliveryAndSmallStepsAreNoJump) {
  EXPECT_TRUE(state("idle", kNow, kNow + 86'400'000).raised.empty()) << "a day without a link";
  EXPECT_TRUE(state("running", kNow + 10'000, kNow + 86'400'000).raised.empty());
  EXPECT_TRUE(state("hold", kNow + 9'000, kNow + 86'400'000).raised.empty())
      << "the clock was set by a second";
  EXPECT_TRUE(state("alarm", kNow + 86'430'000, kNow + 86'400'000).raised.empty())
      << "two clocks are never the same";
}

TEST_F(ClockJumps, PartsAreCountedAllTheSameAndRecountedTheSame) {
  json batch = json::array();
  const std::int64_t told[] = {kNow, kNow + 90'000'000'000, 1, kNow + 30'000};
  for (int i = 0; i < 4; ++i) {
    json one = part(i + 1);
    one["at_ms"] = told[i];
    batch.push_back(one);
  }
  EXPECT_EQ(take_in(*db, machine, "spool", batch, kNow + 40'000).parts.size(), 4u);
  EXPECT_EQ(count(), 4);
  EXPECT_TRUE(recount(*db, machine).at(0).differences.empty());
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

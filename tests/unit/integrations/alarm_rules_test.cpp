#include "server/integrations/alarm_rules.hpp"

#include <gtest/gtest.h>

#include "db/access_store.hpp"
#include "db/event_store.hpp"
#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::integrations {
namespace {

constexpr std::int64_t kMinute = 60'000;

class AlarmRulesTest : public testing::Test {
 protected:
  AlarmRulesTest() {
    for (const char* name : {"Lathe 1", "Lathe 2"}) {
      db::MachineRow machine;
      machine.name = name;
      machine.profile = "fanuc-0i-t";
      machines.push_back(db::insert_machine(*db, machine));
    }
  }
  std::int64_t raise(std::int64_t at_ms, const char* code = "OT0500", std::size_t machine = 0) {
    db::AlarmRow alarm;
    alarm.machine = machines[machine];
    alarm.spool = "s";
    alarm.sequence = ++sequence;
    alarm.alarm = sequence;
    alarm.code = code;
    alarm.text_en = "over travel";
    alarm.text_zh = "超程";
    alarm.raised_ms = at_ms;
    db::insert_alarm(*db, alarm);
    return sequence;
  }
  void clear(std::int64_t alarm, std::int64_t at_ms, std::size_t machine = 0) {
    ASSERT_TRUE(db::clear_alarm(*db, machines[machine], "s", alarm, at_ms));
  }
  db::AlarmRuleRow rule() {
    db::AlarmRuleRow row;
    row.name = "r";
    row.email = "a@example.test";
    return row;
  }
  std::vector<db::NoticeRow> waiting() { return db::notices_due(*db, 100'000'000, 1000); }
  std::vector<db::AlarmEventRow> events() { return db::alarm_events(*db, {}, {}).items; }
  std::string refused(const db::AlarmRuleRow& row) {
    try {
      put_rule(*db, access::Actor{}, row);
    } catch (const db::Refusal& refusal) {
      return refusal.where();
    }
    return "";
  }

  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> db = test::open_shop(folder / "s.db");
  std::vector<std::int64_t> machines;
  std::int64_t sequence = 0;
};

TEST(CodeFits, StarsStandForAnything) {
  EXPECT_TRUE(code_fits("", "OT0500"));
  EXPECT_TRUE(code_fits("OT*", "OT0500"));
  EXPECT_TRUE(code_fits("*0500", "OT0500"));
  EXPECT_TRUE(code_fits("O*5*0", "OT0500"));
  EXPECT_FALSE(code_fits("OT", "OT0500"));
  EXPECT_FALSE(code_fits("PS*", "OT0500"));
  EXPECT_FALSE(code_fits("OT*1", "OT0500"));
}

TEST_F(AlarmRulesTest, OnlyAlarmsFromNowOnAndOnlyThatFit) {
  raise(1'000);
  auto row = rule();
  row.code = "OT*";
  row.machine = machines[0];
  put_rule(*db, access::Actor{}, row);
  EXPECT_EQ(evaluate(*db, 2'000), 0) << "an old alarm";
  raise(3'000, "PS0010");
  raise(3'000, "OT0500", 1);
  EXPECT_EQ(evaluate(*db, 4'000), 0);
  raise(5'000, "OT0501");
  EXPECT_EQ(evaluate(*db, 6'000), 1);
  EXPECT_EQ(evaluate(*db, 7'000), 0) << "once";
  ASSERT_EQ(waiting().size(), 1u);
  EXPECT_NE(waiting()[0].body.find("OT0501"), std::string::npos);
  EXPECT_NE(waiting()[0].body.find("超程"), std::string::npos);
}

TEST_F(AlarmRulesTest, AGroupOfMachines) {
  const auto group = db::put_machine_group(*db, {0, "g", {machines[1]}});
  auto row = rule();
  row.group = group;
  put_rule(*db, access::Actor{}, row);
  raise(1'000, "OT0500", 0);
  raise(1'000, "OT0500", 1);
  EXPECT_EQ(evaluate(*db, 2'000), 1);
  EXPECT_EQ(events().at(0).machine, machines[1]);
}

TEST_F(AlarmRulesTest, AnAlarmThatComesBackSoonIsTheSameEvent) {
  auto row = rule();
  row.again_after_s = 60;
  put_rule(*db, access::Actor{}, row);
  for (int i = 0; i < 10; ++i) {
    const auto alarm = raise(i * 20'000);
    evaluate(*db, i * 20'000 + 1'000);
    clear(alarm, i * 20'000 + 5'000);
    evaluate(*db, i * 20'000 + 6'000);
  }
  EXPECT_EQ(waiting().size(), 1u);
  ASSERT_EQ(events().size(), 1u);
  EXPECT_EQ(events()[0].times, 10);
  EXPECT_EQ(events()[0].cleared_ms, 9 * 20'000 + 5'000);
  // A minute later it is news again.
  raise(10 * kMinute);
  evaluate(*db, 10 * kMinute);
  EXPECT_EQ(waiting().size(), 2u);
}

TEST_F(AlarmRulesTest, SomeMustStayBeforeAnybodyIsTold) {
  auto row = rule();
  row.after_s = 30;
  put_rule(*db, access::Actor{}, row);
  const auto quick = raise(0);
  EXPECT_EQ(evaluate(*db, 10'000), 0);
  clear(quick, 20'000);
  raise(25'000);
  EXPECT_EQ(evaluate(*db, 50'000), 0);
  EXPECT_EQ(evaluate(*db, 55'000), 1);
  EXPECT_EQ(evaluate(*db, 56'000), 0);
}

TEST_F(AlarmRulesTest, AWholeAlarmBetweenTwoLooksIsNotMissed) {
  put_rule(*db, access::Actor{}, rule());
  clear(raise(1'000), 1'200);
  EXPECT_EQ(evaluate(*db, 2'000), 1);
  evaluate(*db, 3'000);
  EXPECT_EQ(events().at(0).cleared_ms, 1'200);
}

TEST_F(AlarmRulesTest, WhoDoesNotAnswerIsGoneAround) {
  auto row = rule();
  row.escalate_after_s = 300;
  row.escalate_email = "boss@example.test";
  put_rule(*db, access::Actor{}, row);
  raise(0, "OT0500", 0);
  const auto other = raise(0, "OT0500", 1);
  raise(0, "OT0600", 1);
  EXPECT_EQ(evaluate(*db, 1'000), 3);
  acknowledge(*db, access::Actor{}, events().back().id, "seen", 2'000);
  clear(other, 3'000, 1);
  EXPECT_EQ(evaluate(*db, 299'000), 0);
  EXPECT_EQ(evaluate(*db, 300'000), 1) << "the one that is neither cleared nor acknowledged";
  EXPECT_EQ(evaluate(*db, 900'000), 0) << "once";
  EXPECT_EQ(waiting().back().target, "boss@example.test");
  EXPECT_EQ(waiting().back().step, "escalation");
}

TEST_F(AlarmRulesTest, AStormIsCutShort) {
  put_rule(*db, access::Actor{}, rule());
  for (int i = 0; i < 200; ++i) raise(i * 100, ("X" + std::to_string(i)).c_str());
  evaluate(*db, 30'000);
  EXPECT_EQ(waiting().size(), static_cast<std::size_t>(kStormLimit));
  EXPECT_NE(waiting().back().body.find("\"storm\":true"), std::string::npos) << "the last one says so";
  EXPECT_EQ(db::alarm_events(*db, {}, {0, 1000}).items.size(), 200u) << "none is missing in the list";
  raise(kStormMs + 40'000, "Y");
  EXPECT_EQ(evaluate(*db, kStormMs + 40'000), 1);
}

TEST_F(AlarmRulesTest, ADeliveryIsTriedAgainAndGivenUpInTheEnd) {
  put_rule(*db, access::Actor{}, rule());
  raise(0);
  evaluate(*db, 0);
  std::int64_t now = 0;
  for (int i = 1; i <= 8; ++i) {
    const auto due = db::notices_due(*db, now, 10);
    ASSERT_EQ(due.size(), 1u) << i;
    delivered(*db, due[0], "no answer", now);
    EXPECT_TRUE(db::notices_due(*db, now, 10).empty());
    now += kMinute << (i - 1);
  }
  EXPECT_TRUE(waiting().empty());
  EXPECT_EQ(db::notices_of(*db, events()[0].id)[0].state, "failed");
}

TEST_F(AlarmRulesTest, ClocksThatJumpLoseNothing) {
  auto row = rule();
  row.after_s = 60;
  row.escalate_after_s = 60;
  row.escalate_email = "boss@example.test";
  put_rule(*db, access::Actor{}, row);
  raise(365ll * 86'400'000);  // the machine's clock is a year ahead
  EXPECT_EQ(evaluate(*db, kMinute), 1);
  EXPECT_EQ(evaluate(*db, 3 * kMinute), 1) << "escalates by the server's clock";
  // The server's clock is set back by a year: what waits does not wait that long.
  db::NoticeRow waits = waiting().front();
  waits.next_ms = 365ll * 86'400'000;
  db::update_notice(*db, waits);
  EXPECT_EQ(db::notices_due(*db, 3 * kMinute, 10).size(), 2u);
}

TEST_F(AlarmRulesTest, NonsenseIsRefused) {
  auto row = rule();
  row.email = "nobody";
  EXPECT_EQ(refused(row), "email");
  row.email = "a@b.c\r\nBcc: x@y.z";
  EXPECT_EQ(refused(row), "email");
  row = rule();
  row.webhook = "ftp://x";
  EXPECT_EQ(refused(row), "webhook");
  row = rule();
  row.escalate_after_s = 5;
  EXPECT_EQ(refused(row), "escalate_email");
  row = rule();
  row.after_s = -1;
  EXPECT_EQ(refused(row), "after_s");
  EXPECT_TRUE(db::alarm_rules(*db).empty());
}

TEST_F(AlarmRulesTest, ARuleIsForSettersAnAcknowledgementForOperators) {
  const access::Actor viewer{5, "v", access::Role::viewer, "", nullptr, {}},
      op{6, "o", access::Role::operator_, "", nullptr, {}};
  EXPECT_THROW(put_rule(*db, op, rule()), db::Refusal);
  put_rule(*db, access::Actor{}, rule());
  raise(0);
  evaluate(*db, 0);
  const auto id = events()[0].id;
  EXPECT_THROW(acknowledge(*db, viewer, id, "", 1), db::Refusal);
  EXPECT_NO_THROW(acknowledge(*db, op, id, "", 1));
  EXPECT_EQ(events()[0].acknowledged_by, "o");
}

}  // namespace
}  // namespace headstock::integrations

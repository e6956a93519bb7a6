// Machine data that a control has punched, as values of its pages: read by the profile's own numbers, written
// down for a machine without an agent, asked for where an agent has them otherwise.
#include "server/dnc/punched_values.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "server/fleet/machines.hpp"
#include "server/fleet/punched.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::dnc {
namespace {

const access::Actor kSetter{8, "wang", access::Role::setter, "here"};
const access::Actor kOperator{9, "zhao", access::Role::operator_, "here"};

struct Punched : testing::Test {
  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> db = test::open_shop(folder / "s.db");
  std::int64_t lathe = fleet::create_machine(*db, {}, "Lathe 1", "fanuc-0i-t", "", 1).id;
  std::int64_t mill = fleet::create_machine(*db, {}, "Mill 1", "fanuc-0i-m", "", 1).id;

  PunchedValues read(std::int64_t machine, std::string_view text) {
    return punched_values(fleet::machine_pages(*db, machine), text);
  }
  fleet::PunchedOutcome take(std::int64_t machine, std::int64_t punch, db::MachineValues values,
                             bool write = false, const access::Actor& who = kSetter) {
    return fleet::take_punched(*db, who, {machine, punch, 1'000 * punch, std::move(values), "set up", write},
                               900'000);
  }
  void give_agent(std::int64_t machine, const char* values) {
    db::insert_certificate(*db, machine, "serial", 1);
    fleet::reconcile(*db, machine, "spool", {{"sequence", 1}, {"values", nlohmann::json::parse(values)}}, 2);
  }
};

using Values = db::MachineValues;

TEST_F(Punched, OffsetsAndVariablesHaveTheNamesOfThePages) {
  EXPECT_EQ(read(lathe, "G10 P01 X0.1 Z-.05\nG10 P10001 X12.5 R0.8\n").values,
            (Values{{"tool/1/wear/X", 0.1},
                    {"tool/1/wear/Z", -0.05},
                    {"tool/1/geometry/X", 12.5},
                    {"tool/1/radius", 0.8}}));
  EXPECT_EQ(read(mill, "G10 L85 P500(4028000000000000)\n").values, (Values{{"variable/500", 12}}));
}

TEST_F(Punched, ParametersByTheProfilesOwnNumbers) {
  // Integers as they stand; lengths only with their decimal point; axes by their place; bits one by one.
  const auto found =
      read(mill, "N3401 P00000001\nN1320 A1 P500.5 A2 P600\nN6711 P12\nN9999 P1\nN1321 A9 P1.0\n");
  EXPECT_EQ(found.values.at("parameter/3401#0"), 1);
  EXPECT_EQ(found.values.at("parameter/1320/X"), 500.5);
  EXPECT_FALSE(found.values.contains("parameter/1320/Y"));
  EXPECT_EQ(found.values.at("parameter/6711"), 12);
  EXPECT_EQ(found.not_read, 3) << "1320 A2 without a point, 9999, a ninth axis";
}

TEST_F(Punched, ToolLifeByGroups) {
  EXPECT_EQ(read(lathe, "G10 L3\nP1 L30 Q2\nT0203\nT0404\nG11\n").values,
            (Values{{"tool_life/1/unit", 1},
                    {"tool_life/1/life", 1800},
                    {"tool_life/1/tool/0", 2},
                    {"tool_life/1/offset/0", 3},
                    {"tool_life/1/tool/1", 4},
                    {"tool_life/1/offset/1", 4}}));
  EXPECT_EQ(read(mill, "G10 L3\nP2 L50\nT11 H11 D12\nG11\n").values, (Values{{"tool_life/2/unit", 0},
                                                                             {"tool_life/2/life", 50},
                                                                             {"tool_life/2/tool/0", 11},
                                                                             {"tool_life/2/h/0", 11},
                                                                             {"tool_life/2/d/0", 12}}));
}

TEST_F(Punched, AMachineWithoutAnAgentHasWhatItHasPunched) {
  auto outcome = take(lathe, 5, {{"tool/1/wear/X", 0.1}, {"tool/1/wear/Z", 0}, {"tool/900/wear/X", 1}});
  EXPECT_EQ(outcome.written, 1);
  EXPECT_EQ(outcome.same, 1);
  EXPECT_EQ(outcome.without_place, 1);
  EXPECT_FALSE(outcome.request);
  const auto changes = db::value_changes(*db, {lathe, "", {}, {}}, {}).items;
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].origin, "import");
  EXPECT_EQ(changes[0].by, "wang");
  EXPECT_EQ(changes[0].at_ms, 5'000);
  EXPECT_EQ(changes[0].before, 0);
  EXPECT_EQ(changes[0].after, 0.1);
  const auto row = db::machine(*db, lathe);
  EXPECT_NE(row->offsets_json.find("0.1"), std::string::npos) << "the checks of programs use it";
  EXPECT_TRUE(row->offsets_at_ms);
}

TEST_F(Punched, AnEarlierPunchDoesNotUndoALaterOne) {
  take(lathe, 7, {{"tool/1/wear/X", 0.3}});
  EXPECT_EQ(take(lathe, 6, {{"tool/1/wear/X", 0.2}, {"tool/2/wear/X", 0.4}}).written, 1);
  const auto now = db::machine_values(*db, lathe);
  EXPECT_EQ(now.at("tool/1/wear/X"), 0.3);
  EXPECT_EQ(now.at("tool/2/wear/X"), 0.4);
}

TEST_F(Punched, AToolLifeGroupIsReplacedWhole) {
  take(lathe, 1, read(lathe, "G10 L3\nP1 L30\nT0101\nT0202\nP2 L5\nT0303\nG11\n").values);
  take(lathe, 2, read(lathe, "G10 L3\nP1 L40\nT0101\nG11\n").values);
  const auto now = db::machine_values(*db, lathe);
  EXPECT_EQ(now.at("tool_life/1/life"), 40);
  EXPECT_FALSE(now.contains("tool_life/1/tool/1"));
  EXPECT_TRUE(now.contains("tool_life/2/tool/0")) << "not in the punch";
}

TEST_F(Punched, WithoutTheRightNothingIsWritten) {
  EXPECT_THROW(take(lathe, 1, {{"tool/1/wear/X", 0.1}}, false, kOperator), db::Refusal);
  EXPECT_TRUE(db::machine_values(*db, lathe).empty());
}

TEST_F(Punched, AnAgentsValuesAreOnlyChangedWhenAskedForAndByARequest) {
  give_agent(mill, R"({"tool/1/geometry/Z": 120})");
  const Values punched{{"tool/1/geometry/Z", 120.5}, {"tool/2/geometry/Z", 0}};
  const auto looked = take(mill, 1, punched);
  EXPECT_EQ(looked.differ, 1);
  EXPECT_EQ(looked.same, 1);
  EXPECT_FALSE(looked.request);
  EXPECT_EQ(db::machine_values(*db, mill).at("tool/1/geometry/Z"), 120);

  const auto asked = take(mill, 2, punched, true);
  ASSERT_TRUE(asked.request);
  EXPECT_EQ(asked.request->origin, "import");
  EXPECT_EQ(asked.request->state, "sending");
  ASSERT_EQ(asked.request->items.size(), 1u);
  EXPECT_EQ(asked.request->items[0].before, 120);
  EXPECT_EQ(asked.request->items[0].after, 120.5);
  EXPECT_EQ(db::machine_values(*db, mill).at("tool/1/geometry/Z"), 120) << "the machine has to say so itself";
}

TEST_F(Punched, ALargeStepWaitsForASecondPerson) {
  give_agent(mill, R"({"tool/1/geometry/Z": 120})");
  db::put_value_limit(*db, 0, "geometry", 0.2);
  EXPECT_EQ(take(mill, 1, {{"tool/1/geometry/Z", 120.5}}, true).request->state, "waiting");
}

TEST_F(Punched, AGroupIsAskedForInTheOrderInWhichItCanBeWritten) {
  give_agent(lathe, "{}");
  const auto asked = take(lathe, 1, read(lathe, "G10 L3\nP1 L30 Q2\nT0203\nG11\n").values, true);
  ASSERT_TRUE(asked.request);
  EXPECT_EQ(asked.request->items.front().what, "tool_life/1/unit");
  EXPECT_EQ(asked.request->items.at(1).what, "tool_life/1/life");
}

}  // namespace
}  // namespace headstock::dnc

// Machine values at the server: history, reconciliation, requests with limits and a second person, sheets.
#include "server/fleet/values.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "db/refusal.hpp"
#include "server/fleet/events.hpp"
#include "server/fleet/machines.hpp"
#include "server/fleet/tool_life.hpp"
#include "server/fleet/value_requests.hpp"
#include "server/fleet/value_sheet.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::fleet {
namespace {

using access::Actor;
using access::Role;
using nlohmann::json;

struct Values : testing::Test {
  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> db = test::open_shop(folder / "s.db");
  std::int64_t machine = create_machine(*db, {}, "Lathe 1", "fanuc-0i-t", "", 1).id;
  Actor wang{8, "wang", Role::setter, ""}, li{9, "li", Role::setter, ""},
      zhao{10, "zhao", Role::operator_, ""};
  std::int64_t sequence = 0;

  void event(const char* what, json before, json after, const char* origin = "G10",
             json more = json::object()) {
    more.update({{"seq", ++sequence},
                 {"at_ms", 1'000 * sequence},
                 {"kind", "offset"},
                 {"what", what},
                 {"before", before},
                 {"after", after},
                 {"origin", origin}});
    take_in(*db, machine, "spool", json::array({more}), 1'000 * sequence);
  }
  std::int64_t report(json values) {
    return reconcile(*db, machine, "spool", {{"sequence", sequence}, {"values", std::move(values)}}, 500'000);
  }
  std::optional<double> now(const char* what) {
    const auto values = db::machine_values(*db, machine);
    const auto found = values.find(what);
    return found != values.end() ? std::optional(found->second) : std::nullopt;
  }
  std::vector<db::ValueChangeRow> history(const char* what = "") {
    return db::value_changes(*db, {machine, what, {}, {}}, {}).items;
  }
  db::ValueRequestRow ask(const Actor& who, std::vector<db::ValueItem> items) {
    return ask_values(*db, who, {machine, "person", "", std::move(items)}, 600'000);
  }
  std::string refusal(const std::function<void()>& work) {
    try {
      work();
      return "";
    } catch (const db::Refusal& refused) {
      return refused.code() + " " + refused.where();
    }
  }
};

TEST_F(Values, EveryChangeStaysWithWhoAndWhat) {
  event("tool/3/wear/X", 0, 0.02, "person", {{"by", "wang"}, {"request", 0}});
  event("tool/3/wear/X", 0.02, 0.05);
  event("variable/500", nullptr, 7.5, "program");
  event("variable/500", 7.5, nullptr, "program");
  const auto changes = history("tool/3/");
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[1].by, "wang");
  EXPECT_EQ(changes[0].origin, "G10");
  EXPECT_EQ(changes[0].before, 0.02);
  EXPECT_EQ(now("tool/3/wear/X"), 0.05);
  EXPECT_FALSE(now("variable/500"));
  EXPECT_EQ(history("variable/500")[0].after, std::nullopt);
  EXPECT_THROW(db->execute("UPDATE value_changes SET after_value = 1"), db::Error);
  EXPECT_THROW(db->execute("DELETE FROM value_changes"), db::Error);
}

TEST_F(Values, AClockThatJumpsBackLosesNoNewerValue) {
  take_in(*db, machine, "spool",
          json::array({{{"seq", 1},
                        {"at_ms", 900'000},
                        {"kind", "offset"},
                        {"what", "tool/1/wear/X"},
                        {"before", 0},
                        {"after", 0.1},
                        {"origin", "G10"}},
                       {{"seq", 2},
                        {"at_ms", 100'000},
                        {"kind", "offset"},
                        {"what", "tool/1/wear/X"},
                        {"before", 0.1},
                        {"after", 0.2},
                        {"origin", "G10"}}}),
          1);
  EXPECT_EQ(now("tool/1/wear/X"), 0.2) << "by the machine's own order, not by its clock";
}

TEST_F(Values, AMomentCanBeSeenAgain) {
  event("tool/3/wear/X", 0, 0.02);               // 1 s
  event("tool/3/wear/X", 0.02, 0.05);            // 2 s
  event("variable/500", nullptr, 1, "program");  // 3 s
  EXPECT_EQ(db::machine_values(*db, machine, 1'500).at("tool/3/wear/X"), 0.02);
  EXPECT_FALSE(db::machine_values(*db, machine, 2'500).contains("variable/500"));
  EXPECT_EQ(db::machine_values(*db, machine, 3'500), db::machine_values(*db, machine));
  report({{"tool/3/wear/X", 0.05}, {"variable/500", 1}});
  const Difference back = difference(*db, machine, db::machine_values(*db, machine, 1'500), "");
  ASSERT_EQ(back.items.size(), 2u);
  EXPECT_EQ(back.items[0].before, 0.05);
  EXPECT_EQ(back.items[0].after, 0.02);
  EXPECT_EQ(back.items[1].after, std::nullopt) << "the variable was not set then";
}

TEST_F(Values, WhatTheMachineHasIsTheTruthAndDifferencesAreHistory) {
  EXPECT_EQ(report({{"tool/1/geometry/X", -112.5}}), 0) << "never heard of before: nothing to differ from";
  EXPECT_EQ(now("tool/1/geometry/X"), -112.5);
  event("tool/1/wear/X", 0, 0.1);
  EXPECT_EQ(report({{"tool/1/geometry/X", -112.5}, {"tool/1/wear/X", 0.1}}), 0);
  EXPECT_EQ(report({{"tool/1/geometry/X", -112.0}}), 2);
  EXPECT_EQ(now("tool/1/wear/X"), 0);
  const auto found = history("tool/1/geometry/X");
  EXPECT_EQ(found[0].origin, "found");
  EXPECT_EQ(found[0].before, -112.5);
  EXPECT_EQ(found[0].after, -112.0);
  EXPECT_EQ(report({{"tool/1/geometry/X", -112.0}}), 0);
}

TEST_F(Values, NothingIsWrittenThatWasNotSeen) {
  EXPECT_EQ(refusal([&] { ask(wang, {{"tool/1/wear/X", 0, 0.1, {}, false}}); }), "machine_not_read Lathe 1");
  report({{"tool/1/wear/X", 0.05}});
  EXPECT_EQ(refusal([&] {
              ask(wang, {{"tool/1/wear/X", 0, 0.1, {}, false}});
            }),
            "changed_meanwhile tool/1/wear/X");
  EXPECT_EQ(refusal([&] { ask(zhao, {{"tool/1/wear/X", 0.05, 0.1, {}, false}}); }).substr(0, 9), "forbidden");
  EXPECT_EQ(refusal([&] { ask(wang, {{"tool/1/wear/X", 0.05, 0.05, {}, false}}); }), "no_values ");
  EXPECT_EQ(refusal([&] {
              ask(wang, {{"tool/201/wear/X", 0, 0.05, {}, false}});
            }),
            "value_refused tool/201/wear/X: bad_place");
  EXPECT_EQ(refusal([&] {
              ask(wang, {{"tool/1/geometry/X", 0, 20'000, {}, false}});
            }),
            "value_refused tool/1/geometry/X: out_of_range");
  EXPECT_EQ(ask(wang, {{"tool/1/wear/X", 0.05, 0.1, {}, false}}).state, "sending");
}

TEST_F(Values, AStepAboveTheLimitWaitsForAnotherPerson) {
  report(json::object());
  const auto asked = ask(wang, {{"tool/1/wear/X", 0, 0.5, {}, false}});
  EXPECT_EQ(asked.state, "waiting");
  EXPECT_EQ(asked.needs_second, "tool/1/wear/X");
  EXPECT_EQ(refusal([&] { agree(*db, wang, asked.id, 1); }), "same_person wang");
  EXPECT_EQ(refusal([&] { agree(*db, zhao, asked.id, 1); }).substr(0, 9), "forbidden");
  const auto agreed = agree(*db, li, asked.id, 1);
  EXPECT_EQ(agreed.state, "sending");
  EXPECT_EQ(agreed.second, "li");
  EXPECT_EQ(refusal([&] { withdraw(*db, wang, asked.id, 2); }).substr(0, 15), "already_decided");
  set_value_limit(*db, wang, machine, "wear", 1);
  EXPECT_EQ(ask(wang, {{"tool/2/wear/X", 0, 0.5, {}, false}}).state, "sending") << "this machine's own limit";
  set_value_limit(*db, wang, machine, "wear", std::nullopt);
  const auto again = ask(wang, {{"tool/2/wear/X", 0, 0.5, {}, false}});
  EXPECT_EQ(again.state, "waiting");
  EXPECT_EQ(withdraw(*db, wang, again.id, 3).state, "withdrawn");
}

TEST_F(Values, DoneIsWhatWasReadBack) {
  report(json::object());
  const auto send = [&](const json& answer) {
    const auto row = ask(wang, {{"tool/1/wear/X", 0, 0.1, {}, false}});
    return finish_request(*db, row.id, answer, 700'000);
  };
  EXPECT_EQ(send({{"accepted", true}, {"values", {{"tool/1/wear/X", 0.1}}}}).state, "done");
  const auto other = send({{"accepted", true}, {"values", {{"tool/1/wear/X", 0.2}}}});
  EXPECT_EQ(other.state + " " + other.reason, "failed read_back_differs");
  EXPECT_EQ(send({{"accepted", true}, {"overtaken", true}, {"values", {{"tool/1/wear/X", 0.2}}}}).state,
            "done")
      << "a later change was there before it was read";
  EXPECT_EQ(send({{"accepted", true}, {"values", json::object()}}).state, "failed")
      << "not read back is not done";
  const auto refused = send({{"accepted", false}, {"reason", "running"}, {"where", "tool/1/wear/X"}});
  EXPECT_EQ(refused.state + " " + refused.reason, "refused running");
  EXPECT_EQ(send({{"accepted", false}, {"reason", "not_connected"}}).state, "failed");
}

TEST_F(Values, AnAnswerThatWasLostIsSettledByTheMachinesOwnRecord) {
  report(json::object());
  const auto lost = [&](const char* what) {
    const auto row = ask(wang, {{what, 0, 0.1, {}, false}});
    EXPECT_EQ(finish_request(*db, row.id, {{"accepted", false}, {"reason", "link_lost"}}, 1).state,
              "unknown");
    return row.id;
  };
  const std::int64_t written = lost("tool/1/wear/X"), not_written = lost("tool/2/wear/X");
  event("tool/1/wear/X", 0, 0.1, "person", {{"by", "wang"}, {"request", written}});
  EXPECT_EQ(db::value_request(*db, written)->state, "done") << "its event came";
  EXPECT_EQ(db::value_request(*db, written)->items[0].read_back, 0.1);
  EXPECT_EQ(db::value_request(*db, not_written)->state, "unknown");
  settle_unknown(*db, machine, 2);
  EXPECT_EQ(db::value_request(*db, not_written)->state, "failed");
  EXPECT_EQ(db::value_request(*db, not_written)->reason, "not_carried_out");
}

TEST_F(Values, WhatAStalledMachineCarriesOutAfterAllIsDone) {
  report(json::object());
  const auto row = ask(wang, {{"tool/1/wear/X", 0, 0.1, {}, false}});
  EXPECT_EQ(finish_request(*db, row.id, {{"accepted", false}, {"reason", "timeout"}}, 1).state, "unknown");
  settle_unknown(*db, machine, 2);  // with a report it had made before it came to the request
  EXPECT_EQ(db::value_request(*db, row.id)->reason, "not_carried_out");
  event("tool/1/wear/X", 0, 0.1, "person", {{"by", "wang"}, {"request", row.id}});
  EXPECT_EQ(db::value_request(*db, row.id)->state, "done");
  EXPECT_EQ(db::value_request(*db, row.id)->reason, "");
}

TEST_F(Values, ASetIsComparedAndCopied) {
  report({{"tool/1/geometry/X", 1}, {"tool/2/geometry/X", 2}, {"parameter/6713", 5}});
  const Difference to = difference(
      *db, machine, {{"tool/1/geometry/X", 9}, {"tool/300/geometry/X", 1}, {"tool/1/wear/Y", 3}}, "offsets");
  ASSERT_EQ(to.items.size(), 2u);
  EXPECT_EQ(to.items[0].after, 9);
  EXPECT_EQ(to.items[1].what, "tool/2/geometry/X");
  EXPECT_EQ(to.items[1].after, 0) << "the other machine has nothing there";
  EXPECT_EQ(to.without_place, 2) << "a number and an axis this machine does not have";
}

/// A group of uses with so many tools, as a machine reports it.
json life_group(int group, int tools, int used = 0) {
  const std::string place = "tool_life/" + std::to_string(group) + "/";
  json values = {{place + "unit", 0}, {place + "life", 100}, {place + "current", 0}};
  for (int i = 0; i < tools; ++i) {
    const std::string entry = "/" + std::to_string(i);
    values.update({{place + "tool" + entry, 10 + i},
                   {place + "offset" + entry, 1},
                   {place + "h" + entry, 0},
                   {place + "d" + entry, 0},
                   {place + "used" + entry, used},
                   {place + "skipped" + entry, 0}});
  }
  return values;
}
db::MachineValues as_values(const json& object) {
  db::MachineValues values;
  for (const auto& [what, value] : object.items()) values[what] = value.get<double>();
  return values;
}

TEST_F(Values, AGroupOfToolLifeIsWrittenAsItsPageIsFilledIn) {
  report({{"tool/1/geometry/X", 1}});
  json wanted = life_group(1, 12, 7);
  wanted["parameter/8132#0"] = 1;
  wanted["tool/1/geometry/X"] = 1;
  const Difference all = difference(*db, machine, as_values(wanted), "");
  ASSERT_EQ(all.items.size(), wanted.size() - 1);
  EXPECT_EQ(all.items[0].what, "parameter/8132#0");
  EXPECT_EQ(all.items[1].what, "tool_life/1/unit");
  EXPECT_EQ(all.items[2].what, "tool_life/1/life");
  for (std::size_t i = 0; i < 12; ++i)
    EXPECT_EQ(all.items[3 + i].what, "tool_life/1/tool/" + std::to_string(i));
  EXPECT_EQ(refusal([&] { ask(wang, all.items); }), "") << "the machine's rules take it in this order";
}

TEST_F(Values, MoreThanTenToolsOfAGroupAreKnown) {
  report(life_group(1, 12, 7));
  const MachinePages pages = machine_pages(*db, machine);
  ASSERT_EQ(pages.data.tool_life.groups.at(1).tools.size(), 12u);
  EXPECT_EQ(pages.data.tool_life.groups.at(1).tools[11].tool, 21);
  EXPECT_EQ(pages.data.tool_life.groups.at(1).tools[11].used, 7);
  EXPECT_TRUE(difference(*db, machine, as_values(life_group(1, 12, 7)), "").items.empty());
}

TEST_F(Values, WhatASetFromBeforeTheReportDoesNotNameOfAToolThatStaysWasZero) {
  report(life_group(1, 2, 7));
  db::MachineValues before = as_values(life_group(1, 2));
  std::erase_if(before, [](const auto& one) { return one.first.find("/used/") != std::string::npos; });
  const Difference back = difference(*db, machine, before, "");
  ASSERT_EQ(back.items.size(), 2u);
  for (const db::ValueItem& item : back.items) {
    EXPECT_TRUE(item.what.starts_with("tool_life/1/used/")) << item.what;
    EXPECT_EQ(item.before, 7);
    EXPECT_EQ(item.after, 0);
  }
}

TEST_F(Values, AGroupTooManyIsTakenOffWholeAndAToolTooManyFromTheEnd) {
  json there = life_group(1, 13);
  there.update(life_group(2, 2));
  report(there);
  const Difference less = difference(*db, machine, as_values(life_group(1, 10)), "");
  std::vector<std::string> what;
  for (const db::ValueItem& item : less.items) {
    what.push_back(item.what);
    EXPECT_FALSE(item.after) << item.what;
  }
  EXPECT_EQ(what, (std::vector<std::string>{"tool_life/2/life", "tool_life/1/tool/12", "tool_life/1/tool/11",
                                            "tool_life/1/tool/10"}));
  EXPECT_EQ(refusal([&] { ask(wang, less.items); }), "");
  event("tool_life/2/life", 100, nullptr, "restore");
  EXPECT_EQ(machine_pages(*db, machine).data.tool_life.groups.size(), 1u)
      << "the machine told that the group is gone";
}

TEST_F(Values, LivesAreUsesOrMinutesAndDoNotTurnIntoEachOther) {
  report(life_group(1, 2, 7));
  const std::string refused = refusal([&] {
    ask(wang, {{"tool_life/2/unit", std::nullopt, 2, std::nullopt, false}});
  });
  EXPECT_EQ(refused, "value_refused tool_life/2/unit: out_of_range") << "no control of ours counts by weight";
  json minutes = life_group(1, 2, 7);
  minutes["tool_life/1/unit"] = 1;
  const Difference other = difference(*db, machine, as_values(minutes), "");
  EXPECT_EQ(refusal([&] { ask(wang, other.items); }), "value_refused tool_life/1/unit: out_of_range")
      << "counts of one are no counts of the other: told, nothing written";
}

TEST_F(Values, ASnapshotIsKeptAsItWas) {
  report({{"tool/1/geometry/X", 1}});
  const auto row = take_snapshot(*db, wang, machine, "before the overhaul", 5);
  event("tool/1/geometry/X", 1, 2);
  EXPECT_EQ(db::snapshot_values(*db, row.id), (db::MachineValues{{"tool/1/geometry/X", 1}}));
  EXPECT_EQ(db::snapshots(*db, machine).at(0).values, 1);
  EXPECT_THROW(db->execute("DELETE FROM value_snapshot_rows"), db::Error);
  EXPECT_EQ(refusal([&] { take_snapshot(*db, wang, machine, "", 5); }).substr(0, 8), "bad_name");
}

// ---- tables

struct Sheets : Values {
  Sheet read(const std::string& text) { return read_sheet(machine_pages(*db, machine), text); }
};

TEST_F(Sheets, APageGoesOutAndComesBackTheSame) {
  report({{"tool/1/geometry/X", -112.503},
          {"tool/200/wear/Z", 0.001},
          {"tool/7/tip", 3},
          {"tool/7/radius", 0.8},
          {"work/G59/X", 1e-3},
          {"variable/500", 1.0 / 3},
          {"parameter/3402#0", 1}});
  const MachinePages pages = machine_pages(*db, machine);
  for (const char* kind : {"offsets", "work", "variables", "parameters", ""}) {
    const std::string text = write_sheet(pages, db::machine_values(*db, machine), kind);
    const Sheet sheet = read(text);
    EXPECT_TRUE(sheet.rows.empty()) << kind << ": " << sheet.rows.size() << " differ, first "
                                    << sheet.rows[0].item.what;
    EXPECT_GT(sheet.values, 0) << kind;
  }
  EXPECT_EQ(read(write_sheet(pages, {}, "offsets")).rows.size(), 4u)
      << "all zero: four values would be changed";
}

TEST_F(Sheets, APasteFromASpreadsheet) {
  report({{"tool/1/wear/X", 0.01}});
  const Sheet sheet = read("序号\tX磨损\tZ磨损\tR\t刀尖\r\n01\t0,02\t\t0,4\t3\r\nT02\t-0,015\t1.5\t\t\r\n");
  ASSERT_EQ(sheet.rows.size(), 5u);
  EXPECT_EQ(sheet.rows[0].item.what, "tool/1/wear/X");
  EXPECT_EQ(sheet.rows[0].item.before, 0.01);
  EXPECT_EQ(sheet.rows[0].item.after, 0.02);
  EXPECT_EQ(sheet.rows[3].item.what, "tool/2/wear/X");
  EXPECT_EQ(sheet.rows[3].item.after, -0.015);
  for (const SheetRow& row : sheet.rows) EXPECT_EQ(row.problem, "") << row.item.what;
}

TEST_F(Sheets, WhatIsWrongIsToldRowByRow) {
  report(json::object());
  const Sheet sheet = read("number,X,tip\n1,abc,3\n2,99999,12\n999,1,1\n3,=A1,\n");
  std::vector<std::string> problems;
  for (const SheetRow& row : sheet.rows) problems.push_back(std::to_string(row.line) + " " + row.problem);
  EXPECT_EQ(problems, (std::vector<std::string>{"2 not_a_number", "2 ", "3 out_of_range", "3 out_of_range",
                                                "4 bad_place", "4 bad_place", "5 not_a_number"}));
}

TEST_F(Sheets, AFileOfAnotherControllerOrUnitIsRefusedAsAWhole) {
  report(json::object());
  EXPECT_EQ(
      refusal([&] { read("# Headstock; profile gsk-2000tc; unit mm; machine Lathe 2\nnumber,X\n1,1\n"); }),
      "other_profile gsk-2000tc");
  EXPECT_EQ(refusal([&] { read("# Headstock; profile fanuc-0i-t; unit inch\nnumber,X\n1,1\n"); }),
            "other_unit inch");
  EXPECT_EQ(refusal([&] { read("number,Q\n1,1\n"); }), "bad_sheet 1: Q");
  EXPECT_EQ(refusal([&] { read("PK\x03\x04zip\n"); }).substr(0, 9), "bad_sheet");
  EXPECT_EQ(refusal([&] { read(""); }).substr(0, 9), "bad_sheet");
}

// ---- tool life

TEST_F(Values, LifeLeftAndTheNextChangeComeFromWhatWasCounted) {
  report({{"tool_life/1/unit", 0},
          {"tool_life/1/life", 100},
          {"tool_life/1/current", 0},
          {"tool_life/1/tool/0", 1},
          {"tool_life/1/used/0", 90},
          {"tool_life/1/tool/1", 2},
          {"tool_life/1/used/1", 0},
          {"tool_life/1/skipped/1", 1},
          {"tool_life/1/tool/2", 3},
          {"tool_life/1/used/2", 40}});
  for (int part = 1; part <= 5; ++part) {
    take_in(*db, machine, "spool",
            json::array({{{"seq", ++sequence},
                          {"at_ms", 60'000 * part},
                          {"kind", "part"},
                          {"count", part},
                          {"total", part},
                          {"program", "O1"},
                          {"sha256", "aa"},
                          {"cycle_s", 60}}}),
            1);
    const int used = 90 + part;
    take_in(*db, machine, "spool",
            json::array({{{"seq", ++sequence},
                          {"at_ms", 60'000 * part},
                          {"kind", "offset"},
                          {"what", "tool_life/1/used/0"},
                          {"before", used - 1},
                          {"after", used},
                          {"origin", "program"}}}),
            1);
  }
  const auto groups = tool_life(*db, 0, 0);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].left_current, 5);
  EXPECT_EQ(groups[0].left_total, 65) << "a skipped tool is not there";
  EXPECT_EQ(groups[0].per_part, 1);
  EXPECT_EQ(groups[0].parts_left, 5);
  EXPECT_EQ(groups[0].next_change_s, 300);
  EXPECT_EQ(groups[0].tools[0].mark, "@");
  EXPECT_EQ(groups[0].tools[1].mark, "#");
  set_short_life_policy(*db, wang, "warn");
  EXPECT_EQ(to_string(short_life_policy(*db)), "warn");
  EXPECT_EQ(refusal([&] { set_short_life_policy(*db, wang, "perhaps"); }), "bad_value short_life");
}

TEST_F(Values, CountsOfToolLifeDoNotMakeChecksOldButGroupsDo) {
  const auto version = [&] { return db::machine(*db, machine)->offsets_version; };
  report({{"tool_life/1/unit", 0},
          {"tool_life/1/life", 100},
          {"tool_life/1/tool/0", 1},
          {"tool_life/1/used/0", 1}});
  const auto before = version();
  event("tool_life/1/used/0", 1, 2, "program");
  EXPECT_EQ(version(), before);
  event("tool_life/1/life", 100, 200, "person");
  EXPECT_EQ(version(), before + 1);
  event("variable/500", nullptr, 2, "program");
  EXPECT_EQ(version(), before + 2);
}

}  // namespace
}  // namespace headstock::fleet

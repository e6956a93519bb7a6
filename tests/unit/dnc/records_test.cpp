// Places in a program, what really went out, the census, machine data, plans, the log.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "db/machine_store.hpp"
#include "db/plan_store.hpp"
#include "db/refusal.hpp"
#include "db/transfer_store.hpp"
#include "server/dnc/agent_port.hpp"
#include "server/dnc/census.hpp"
#include "server/dnc/outgoing.hpp"
#include "server/dnc/ports.hpp"
#include "server/dnc/received.hpp"
#include "server/dnc/start_place.hpp"
#include "server/dnc/transfer_log.hpp"
#include "server/library/programs.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::dnc {
namespace {

const access::Actor kSetter{8, "setter", access::Role::setter, "here"};
const access::Actor kProgrammer{7, "prog", access::Role::programmer, "here"};

struct RecordsTest : testing::Test {
  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> database = test::open_shop(folder / "headstock.db");
  db::Blobs blobs{folder.path()};

  std::string file(const std::string& text) {
    std::ofstream(folder / "text", std::ios::binary) << text;
    return (folder / "text").string();
  }
  std::int64_t machine(const std::string& name) {
    db::MachineRow row;
    row.name = name;
    row.profile = "fanuc-0i-t";
    return db::insert_machine(*database, row);
  }
  db::PortRow port(const std::string& name, const std::string& address, std::int64_t machine) {
    return create_port(*database, kSetter,
                       {{"name", name},
                        {"address", address},
                        {"machine", machine},
                        {"settings", {{"protocol", "xon-xoff"}}}},
                       5);
  }
  library::Added stored(const std::string& name, const std::string& text) {
    library::Upload upload(blobs);
    upload.append(text);
    return library::add_revision(*database, kProgrammer, {"/", name}, upload.finish(), "", "upload", 5);
  }
  std::int64_t transfer(const db::PortRow& over, const char* kind, const std::string& state,
                        const library::Added& of, std::int64_t ended) {
    db::PortTransferRow row;
    row.port = over.id;
    row.kind = kind;
    row.state = "waiting";
    row.program = of.program.id;
    row.revision = of.revision.number;
    row.name = of.program.name;
    row.sha256 = of.revision.blob.sha256;
    row.by = "op";
    row.created_ms = ended - 1;
    row.id = db::insert_port_transfer(*database, row);
    row.state = state;
    row.ended_ms = ended;
    db::update_port_transfer(*database, row);
    return row.id;
  }
  std::int64_t punch(const db::PortRow& over, const std::string& text, std::int64_t at) {
    db::PortTransferRow row;
    row.port = over.id;
    row.kind = "receive";
    row.state = "done";
    row.id = db::insert_port_transfer(*database, row);
    auto taken =
        take_apart(text, true, settings_from(nlohmann::json::parse(over.settings_json)), over, blobs);
    EXPECT_EQ(taken.reason, "");
    return keep(*database, blobs, std::move(taken), over, row.id, at).at(0);
  }
};

constexpr const char* kMill =
    "%\nO1(PLATE)\n\nN10 T5\nN20 M06 (T7 IS NEXT)\n/2 N30 G00 X1.\nT7 M06\nN20 G01 X2.\nT5\nM06\nM30\n%\n";

TEST_F(RecordsTest, PlacesAreFoundByBlockSequenceNumberAndTool) {
  const auto mill = file(kMill);
  using enum StartWish::By;
  EXPECT_EQ(find_place(mill, {line, 4, 1}, true).text, "N10 T5");
  EXPECT_EQ(find_place(mill, {block, 2, 1}, true).line, 4)
      << "O1 is the first block, empty lines and % are none";
  EXPECT_EQ(find_place(mill, {sequence, 30, 1}, true).line, 6) << "behind a block skip";
  const auto twice = find_place(mill, {sequence, 20, 2}, true);
  EXPECT_EQ(twice.line, 8);
  EXPECT_EQ(twice.occurrences, 2);
  EXPECT_EQ(find_place(mill, {tool, 5, 1}, true).line, 5)
      << "the M06, not the T before it, not the T in a comment";
  EXPECT_EQ(find_place(mill, {tool, 5, 2}, true).line, 10);
  EXPECT_EQ(find_place(mill, {tool, 7, 1}, true).line, 7);
  EXPECT_EQ(find_place(mill, {tool, 9, 1}, true).line, 0);
  const auto lathe = file("%\nO2\nT0101\nG00X5.\nT0202\nt0100\n%\n");
  EXPECT_EQ(find_place(lathe, {tool, 2, 1}, false).line, 5);
  EXPECT_EQ(find_place(lathe, {tool, 1, 1}, false).line, 3);
  EXPECT_EQ(find_place(lathe, {sequence, 1, 1}, false).line, 0);
}

TEST_F(RecordsTest, TheTailIsWhatReallyWentOut) {
  const auto settings = settings_from({{"protocol", "xon-xoff"}, {"code", "iso"}, {"strip_spaces", true}});
  const OutgoingText text{file("%\nO1\nG01 X1.\nG01 X2.\nM30\n%\n"), "", 0};
  const auto all = examine(text, settings).bytes;
  EXPECT_EQ(tail_of(text, settings, 1, 0).line, 0);
  const auto part = tail_of(text, settings, 1, std::string("%\nO1\nG01X1.\nG01").size());
  EXPECT_EQ(part.line, 3);
  EXPECT_EQ(part.text, "%\nO1\nG01X1.\nG01") << "as it went out: without spaces, readable";
  EXPECT_EQ(tail_of(text, settings, 1, all).line, 6);
  const OutgoingText rest{text.file, "%\nO1\n(HEADER)\n", std::string("%\nO1\nG01 X1.\n").size()};
  EXPECT_EQ(tail_of({text.file, rest.header, 0}, settings, 4, examine(rest, settings).bytes).line, 6)
      << "a certificate knows the line, not the offset";
  EXPECT_EQ(tail_of(rest, settings, 4, 5).line, 0) << "the header was not over";
  EXPECT_EQ(tail_of(rest, settings, 4, std::string("%\nO1\n(HEADER)\nG01X2.\nM").size()).line, 4);
}

TEST_F(RecordsTest, TheCensusSaysWhatLiesWhereAndHowThatIsKnown) {
  auto& db = *database;
  const auto over = port("P", "tcp://h:1", machine("Lathe 1"));
  const auto first = stored("O0001", "%\nO0001\nG1X1F100\nM30\n%\n");
  db::CheckRow check;
  check.sha256 = first.revision.blob.sha256;
  check.machine = over.machine;
  check.ok = true;
  check.result_json = "{}";
  db::put_check(db, check);
  library::release(db, kSetter, first.program.id, 1, "test", 6);
  transfer(over, "send", "done", first, 10);
  const auto drip = stored("O0002", "%\nO0002\nM30\n%\n");
  transfer(over, "drip", "done", drip, 11);
  transfer(over, "send", "failed", drip, 12);
  auto found = census(db, 0);
  ASSERT_EQ(found.size(), 1u) << "a drip-feed and a failed transfer leave nothing that could be named";
  EXPECT_EQ(found[0].machine_name, "Lathe 1");
  EXPECT_EQ(found[0].state, "released");
  EXPECT_EQ(found[0].proof, "sent");
  EXPECT_EQ(found[0].proven_ms, 10);
  const auto received = punch(over, "%\nO0001\nG1X1F120\nM30\n%\n", 20);
  found = census(db, 0);
  EXPECT_EQ(found.at(0).state, "changed");
  EXPECT_EQ(found[0].proof, "punched");
  EXPECT_EQ(found[0].classes, "feed_speed");
  accept(db, blobs, kProgrammer, received, {}, 21);
  found = census(db, over.machine);
  EXPECT_EQ(found.at(0).state, "older") << "a revision now, but not the released one";
  EXPECT_EQ(found[0].revision, 2);
  EXPECT_EQ(found[0].released, 1);
  punch(over, "%\nO0777\nM30\n%\n", 30);
  EXPECT_EQ(census(db, 0).at(1).state, "unknown");
  EXPECT_TRUE(census(db, over.machine + 1).empty());
}

TEST_F(RecordsTest, AcceptedMachineDataBecomeASet) {
  auto& db = *database;
  const auto over = port("P", "tcp://h:1", machine("Lathe 1"));
  const auto first = punch(over, "%\nG10 P01 X0.1 Z0\n%\n", 20);
  EXPECT_THROW(accept(db, blobs, kProgrammer, first, {}, 21), db::Refusal) << "who accepts it edits offsets";
  EXPECT_TRUE(db::punched_data_rows(db, over.machine, "", {}).items.empty());
  EXPECT_EQ(accept(db, blobs, kSetter, first, {}, 21).values.written, 1);
  accept(db, blobs, kSetter, punch(over, "%\nG10 P01 X0.3 Z0\n%\n", 30), {}, 31);
  const auto sets = db::punched_data_rows(db, over.machine, "tool_offsets", {}).items;
  ASSERT_EQ(sets.size(), 2u);
  EXPECT_EQ(sets[0].entries, 2);
  EXPECT_EQ(sets[0].by, "setter");
  EXPECT_EQ(db::punched_data_before(db, sets[0])->id, sets[1].id);
  EXPECT_FALSE(db::punched_data_before(db, sets[1]));
  EXPECT_TRUE(db::punched_data_rows(db, over.machine, "parameters", {}).items.empty());
}

TEST_F(RecordsTest, AgentsArePortsToo) {
  EXPECT_EQ(agent_of("agent:12"), 12);
  for (const char* text : {"agent:", "agent:0", "agent:-1", "agent:1x", "agents:1", "/dev/ttyS0"})
    EXPECT_EQ(agent_of(text), 0) << text;
  const auto number = machine("Mill 1");
  const auto row =
      create_port(*database, kSetter,
                  {{"name", "A"}, {"address", "agent:" + std::to_string(number)}, {"listens", true}}, 5);
  EXPECT_EQ(row.machine, number);
  EXPECT_FALSE(row.listens);
  EXPECT_THROW(create_port(*database, kSetter, {{"name", "B"}, {"address", "agent:99"}}, 5), db::Refusal);
}

TEST_F(RecordsTest, PlansAreDueOnce) {
  auto& db = *database;
  const auto over = port("P", "tcp://h:1", 0);
  db::PlanRow plan;
  plan.port = over.id;
  plan.program = plan.revision = 1;
  plan.at_ms = 100;
  plan.by = "op";
  plan.id = db::insert_plan(db, plan);
  EXPECT_TRUE(db::due_plans(db, 99).empty());
  ASSERT_EQ(db::due_plans(db, 100).size(), 1u);
  plan.state = "started";
  plan.ended_ms = 100;
  db::update_plan(db, plan);
  EXPECT_TRUE(db::due_plans(db, 1'000).empty());
  EXPECT_EQ(db::plans(db, over.id, false, {}).items.size(), 1u);
  EXPECT_TRUE(db::plans(db, over.id, true, {}).items.empty());
}

TEST_F(RecordsTest, TheLogHasEveryTransferAndNoFormulas) {
  auto& db = *database;
  const auto number = machine("=Mill, 1");
  const auto over = port("P", "tcp://h:1", number);
  const auto program = stored("O0001", "%\nO0001\nM30\n%\n");
  transfer(over, "send", "done", program, 2'000);
  transfer(over, "send", "failed", program, 3'000);
  db::TransferRow agent;
  agent.machine = number;
  agent.program = program.program.id;
  agent.revision = 1;
  agent.name = "O0001";
  agent.sha256 = program.revision.blob.sha256;
  agent.kind = "put";
  agent.state = "done";
  agent.by = "op";
  agent.created_ms = 1'000;
  agent.started_ms = 1'000;
  agent.ended_ms = 3'500;
  db::insert_transfer(db, agent);
  std::string text = log_head();
  LogPlace place;
  while (append_log(db, {}, place, text)) {
  }
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
  EXPECT_NE(text.find("\"'=Mill, 1\""), std::string::npos) << text;
  EXPECT_NE(text.find(",2.500\r\n"), std::string::npos) << text;
  EXPECT_NE(text.find(program.revision.blob.sha256), std::string::npos);
  std::string later;
  place = {};
  while (append_log(db, {2'500, 0, 0, 0}, place, later)) {
  }
  EXPECT_EQ(std::count(later.begin(), later.end(), '\n'), 1);
}

}  // namespace
}  // namespace headstock::dnc

// What is decided beside the line: settings, requests, what goes out, what came in, where a program can begin
// again.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "db/refusal.hpp"
#include "server/dnc/outgoing.hpp"
#include "server/dnc/ports.hpp"
#include "server/dnc/received.hpp"
#include "server/dnc/settings.hpp"
#include "server/library/checks.hpp"
#include "server/library/programs.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::dnc {
namespace {

using nlohmann::json;

const access::Actor kSetter{8, "setter", access::Role::setter, "here"};
const access::Actor kProgrammer{7, "prog", access::Role::programmer, "here"};
const access::Actor kOperator{6, "op", access::Role::operator_, "here"};

std::string refusal_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const db::Refusal& refusal) {
    EXPECT_NE(db::refusal_text(refusal.code()), nullptr) << refusal.code();
    return refusal.code() + ":" + refusal.where();
  }
  return "";
}

TEST(Settings, AreTheProtocolsUnlessSaidAndSurviveTheStore) {
  const auto settings =
      settings_from({{"protocol", "lathe-200t"}, {"strip_spaces", true}, {"after_stop", 20}});
  EXPECT_EQ(serial::to_text(settings.link.line), "9600-8-O-1-software");
  EXPECT_TRUE(settings.filter.strip_spaces);
  EXPECT_EQ(to_json(settings_from(to_json(settings))), to_json(settings));
}

TEST(Settings, WhatIsWrongIsNamed) {
  EXPECT_EQ(refusal_of([] { settings_from({{"protocol", "x"}}); }), "bad_value:protocol");
  EXPECT_EQ(refusal_of([] { settings_from({{"line", "9600"}}); }), "bad_value:line");
  EXPECT_EQ(refusal_of([] { settings_from({{"after_stop", 1}}); }), "bad_value:after_stop");
  EXPECT_EQ(refusal_of([] { settings_from({{"leader", -1}}); }), "bad_value:leader");
  EXPECT_EQ(refusal_of([] { settings_from({{"frame", 1}}); }), "bad_value:frame");
  EXPECT_EQ(refusal_of([] { settings_from({{"symbols", "#=61"}}); }), "bad_value:symbols");
}

TEST(Requests, ArePatternsNotPrograms) {
  const auto rules = rules_from(json::parse(
      R"j([{"pattern":"(GET=*)","name":"O*"},{"pattern":"(LIST)","action":"list","name":"O9999"}])j"));
  EXPECT_EQ(wanted("%\nO0001( get = 1234 )\nM30\n%\n", rules).name, "O1234");
  EXPECT_EQ(wanted("%\nO1(LIST)\n%\n", rules).name, "O9999");
  EXPECT_EQ(wanted("%\nO1(GET=)\n%\n", rules).rule, nullptr);
  EXPECT_EQ(wanted("%\nO1(GET=../X)\n%\n", rules).rule, nullptr);
  EXPECT_EQ(wanted("%\nO1\nG0X1\n%\n", rules).rule, nullptr);
  EXPECT_EQ(refusal_of([] { rules_from(json::parse(R"([{"pattern":"G*","name":"*"}])")); }),
            "bad_value:rules");
  EXPECT_EQ(refusal_of([] { rules_from(json::parse(R"j([{"pattern":"(GET=*)","name":""}])j")); }),
            "bad_value:rules");
}

struct DncTest : testing::Test {
  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> database = test::open_shop(folder / "headstock.db");
  db::Blobs blobs{folder.path()};

  std::string file(const std::string& text) {
    std::ofstream(folder / "text", std::ios::binary) << text;
    return (folder / "text").string();
  }
  static std::string sent(const OutgoingText& text, const PortSettings& settings) {
    const auto source = outgoing(text, settings);
    std::string all, piece(7, '\0');
    for (auto read = source->read(piece); read.count > 0; read = source->read(piece))
      all.append(piece, 0, read.count);
    return all;
  }
};

TEST_F(DncTest, PortsAreRecordsWithRules) {
  auto& db = *database;
  const auto row = create_port(
      db, kSetter,
      {{"name", "Old lathe"}, {"address", "/dev/ttyS0"}, {"settings", {{"protocol", "xon-xoff"}}}}, 5);
  EXPECT_EQ(db::ports(db).size(), 1u);
  EXPECT_EQ(refusal_of([&] {
              create_port(db, kOperator, {{"name", "X"}, {"address", "/dev/ttyS1"}}, 5);
            }),
            "forbidden:edit_machine");
  EXPECT_EQ(refusal_of([&] {
              create_port(db, kSetter, {{"name", "Old lathe"}, {"address", "/dev/ttyS1"}}, 5);
            }),
            "name_taken:Old lathe");
  EXPECT_EQ(refusal_of([&] {
              create_port(db, kSetter, {{"name", "X"}, {"address", "/dev/ttyS0"}}, 5);
            }),
            "name_taken:address");
  EXPECT_EQ(refusal_of([&] {
              create_port(db, kSetter, {{"name", "X"}, {"address", "/etc/passwd"}}, 5);
            }),
            "bad_value:address");
  EXPECT_EQ(refusal_of([&] {
              create_port(db, kSetter, {{"name", "X"}, {"address", "/dev/../etc/passwd"}}, 5);
            }),
            "bad_value:address");
  EXPECT_EQ(refusal_of([&] {
              create_port(db, kSetter, {{"name", "X"}, {"address", "tcp://h:1"}, {"machine", 99}}, 5);
            }),
            "not_found:machine");
  const auto changed =
      change_port(db, kSetter, row.id, {{"listens", true}, {"address", "tcp://serial-1:4001"}}, 6);
  EXPECT_TRUE(changed.listens);
  EXPECT_EQ(changed.name, "Old lathe");
  remove_port(db, kSetter, row.id, 7);
  EXPECT_TRUE(db::ports(db).empty());
}

TEST_F(DncTest, WhatGoesOutIsLookedThroughFirst) {
  PortSettings settings = settings_from({{"protocol", "xon-xoff"}});
  const OutgoingText text{file("%\nO1\nG0 X1\nM30\n%\n"), "", 0};
  const auto facts = examine(text, settings);
  EXPECT_EQ(facts.reason, "");
  EXPECT_EQ(facts.bytes, sent(text, settings).size());
  EXPECT_EQ(facts.sha256, db::sha256_hex(sent(text, settings)));
  settings.link.code = tape::Code::eia;
  const auto bad = examine({file("%\nO1\n#1=2\n%\n"), "", 0}, settings);
  EXPECT_EQ(bad.reason, "no_code");
  EXPECT_NE(bad.where.find("line 3"), std::string::npos);
  settings.filter.number_step = 10;
  EXPECT_EQ(examine({file("%\nO1\nGOTO10\n%\n"), "", 0}, settings).reason, "numbers_are_used");
  EXPECT_EQ(examine({"/nowhere", "", 0}, settings_from({{"protocol", "plain"}})).reason, "blob_unreadable");
}

TEST_F(DncTest, ARestartSendsItsHeaderThenTheRest) {
  const auto settings = settings_from({{"protocol", "xon-xoff"}});
  EXPECT_EQ(sent({file("%\nO1\nG0 X1\nG1 X2\nM30\n%\n"), "%\nO1\n(HEADER)\n", 11}, settings),
            "%\nO1\n(HEADER)\nG1 X2\nM30\n%\n");
  const auto lathe = settings_from({{"protocol", "lathe-200t"}});
  EXPECT_EQ(examine({file("G0\n"), "", 0}, lathe).bytes, 5u) << "G0 CR LF and 1A";
}

TEST_F(DncTest, APunchWaitsForApprovalAndChangesNothingBefore) {
  auto& db = *database;
  const auto port = create_port(
      db, kSetter, {{"name", "P"}, {"address", "tcp://h:1"}, {"settings", {{"protocol", "xon-xoff"}}}}, 5);
  const auto settings = settings_from(json::parse(port.settings_json));
  library::Upload upload(blobs);
  upload.append("%\nO0001\nG1X1F100\nM30\n%\n");
  library::add_revision(db, kProgrammer, {"/", "O0001"}, upload.finish(), "", "upload", 5);
  db::PortTransferRow transfer;
  transfer.port = port.id;
  transfer.kind = "receive";
  transfer.state = "done";
  transfer.by = "control";
  const auto id = db::insert_port_transfer(db, transfer);
  auto punch =
      take_apart("%\r\nO0001\r\nG1X1F120\r\nM30\r\nO0002(NEW)\r\nM99\r\n%\r\n", true, settings, port, blobs);
  ASSERT_EQ(punch.reason, "");
  const auto ids = keep(db, blobs, std::move(punch), port, id, 6);
  ASSERT_EQ(ids.size(), 2u);
  const auto first = *db::received(db, ids[0]), second = *db::received(db, ids[1]);
  EXPECT_EQ(first.name, "O0001");
  EXPECT_EQ(first.classes, "feed_speed");
  EXPECT_EQ(first.state, "waiting");
  EXPECT_EQ(second.program, 0);
  EXPECT_EQ(second.comment, "NEW");
  EXPECT_EQ(db::program_named(db, "/", "O0001")->newest->number, 1) << "nothing changed yet";
  EXPECT_EQ(refusal_of([&] { accept(db, blobs, kOperator, ids[0], {}, 7); }), "forbidden:upload_program");
  accept(db, blobs, kProgrammer, ids[0], {"better feed"}, 7);
  const auto program = *db::program_named(db, "/", "O0001");
  EXPECT_EQ(program.newest->number, 2);
  EXPECT_EQ(program.newest->origin, std::string("port:").append(std::to_string(port.id)));
  EXPECT_FALSE(program.released);
  EXPECT_EQ(refusal_of([&] { reject(db, kProgrammer, ids[0], "", 8); }), "already_decided:");
  reject(db, kProgrammer, ids[1], "no", 8);
  EXPECT_FALSE(db::program_named(db, "/", "O0002"));
}

TEST_F(DncTest, WhatIsInTheLibraryAlreadyNeedsNoDecision) {
  auto& db = *database;
  const auto port = create_port(
      db, kSetter, {{"name", "P"}, {"address", "tcp://h:1"}, {"settings", {{"protocol", "xon-xoff"}}}}, 5);
  library::Upload upload(blobs);
  upload.append("%\r\nO0001\r\nM30\r\n%");
  library::add_revision(db, kProgrammer, {"/", "O0001"}, upload.finish(), "", "upload", 5);
  db::PortTransferRow transfer;
  transfer.port = port.id;
  transfer.kind = "receive";
  transfer.state = "done";
  const auto id = db::insert_port_transfer(db, transfer);
  const auto settings = settings_from(json::parse(port.settings_json));
  auto punch = take_apart("%\nO0001\nM30\n%\n", true, settings, port, blobs);
  const auto ids = keep(db, blobs, std::move(punch), port, id, 6);
  ASSERT_EQ(ids.size(), 1u);
  EXPECT_EQ(db::received(db, ids[0])->state, "same");
  EXPECT_EQ(take_apart("", true, settings, port, blobs).reason, "punch_empty");
  auto iso = settings;
  iso.link.code = tape::Code::iso;
  EXPECT_EQ(take_apart("G1\n", true, iso, port, blobs).reason, "punch_parity");
  const auto offsets = take_apart("%\nG10 P1 X0.1 Z0.2 R0 Q0\n%\n", true, settings, port, blobs);
  EXPECT_EQ(offsets.pieces.at(0).row.kind, "tool_offsets");
}

TEST_F(DncTest, EndedTransfersStayAsTheyWere) {
  auto& db = *database;
  const auto port = create_port(db, kSetter, {{"name", "P"}, {"address", "tcp://h:1"}}, 5);
  db::PortTransferRow transfer;
  transfer.port = port.id;
  transfer.kind = "send";
  transfer.state = "waiting";
  transfer.id = db::insert_port_transfer(db, transfer);
  EXPECT_EQ(db::end_open_port_transfers(db, "server_restarted", 9), 1);
  EXPECT_EQ(db::port_transfer(db, transfer.id)->reason, "server_restarted");
  transfer.state = "done";
  EXPECT_THROW(db::update_port_transfer(db, transfer), db::Error);
}

library::Restart restart_of(test::TemporaryFolder& folder, const std::string& profile,
                            const std::string& text, std::int64_t line) {
  std::ofstream(folder / "restart.nc", std::ios::binary) << text;
  library::CheckJob job;
  job.file = (folder / "restart.nc").string();
  job.machine.profile = profile;
  return library::run_restart(job, line);
}

constexpr const char* kMill =
    "%\nO2001(PLATE)\nG21 G17 G90 G94 G54\nT5 M06\nS2000 M03\nM08\nG00 X10. Y5. Z20.\nG01 Z-1. "
    "F1200.\nX20.\nY20.\nG00 Z20.\nM30\n%\n";

TEST_F(DncTest, ARestartHeaderHoldsWhatTheBlocksBeforeWouldHaveLeft) {
  const auto restart = restart_of(folder, "fanuc-0i-m", kMill, 10);
  ASSERT_EQ(restart.reason, "") << restart.where;
  EXPECT_EQ(restart.offset, std::string(kMill).find("Y20."));
  for (const char* block : {"%\nO2001(PLATE)\n", "G21", "G54", "G94", "G91 G28 Z0.\nG90\n", "T5 M06\n",
                            "S2000 M03\n", "X20. Y5.", "M00", "G01 Z-1. F1200.\n", "M08\n"})
    EXPECT_NE(restart.header.find(block), std::string::npos) << block << "\n" << restart.header;
  EXPECT_TRUE(restart.header.ends_with("G01\n")) << restart.header;
}

TEST_F(DncTest, IncrementalProgrammingComesBackBehindTheHeadersOwnMoves) {
  const auto restart =
      restart_of(folder, "fanuc-0i-m", "%\nO1\nG90 G00 X5. Y5.\nG91 G01 X1. F100.\nX2.\nX3.\nM30\n%\n", 6);
  ASSERT_EQ(restart.reason, "") << restart.where;
  EXPECT_TRUE(restart.header.ends_with("G91\nG01\n")) << restart.header;
  EXPECT_LT(restart.header.find("\nG90\n"), restart.header.find("X8. Y5.")) << restart.header;
}

TEST_F(DncTest, ConstantSurfaceSpeedIsNotGuessed) {
  const auto restart = restart_of(
      folder, "fanuc-0i-t", "%\nO1\nG50 S2000\nG96 S150 M03\nG00 X50. Z2.\nG01 Z-5. F0.2\nX60.\nM30\n%\n", 7);
  EXPECT_EQ(restart.reason, "restart_mode");
  EXPECT_EQ(restart.where, "G96");
}

TEST_F(DncTest, WhereAHeaderCannotHelpItSaysSo) {
  EXPECT_EQ(restart_of(folder, "fanuc-0i-m", kMill, 99).reason, "restart_not_reached");
  EXPECT_EQ(restart_of(folder, "fanuc-0i-m", kMill, 13).reason, "restart_not_reached");
  EXPECT_EQ(restart_of(folder, "fanuc-0i-m", "%\nO1\nG01 X1.\nX2.\nM30\n%\n", 4).reason, "restart_alarm")
      << "no feed";
  EXPECT_EQ(restart_of(folder, "fanuc-0i-m", "%\nO1\nG00 X1.\nX#100\nM30\n%\n", 4).reason,
            "restart_variables");
  EXPECT_EQ(restart_of(folder, "nothing", kMill, 5).reason, "bad_machine_file");
}

}  // namespace
}  // namespace headstock::dnc

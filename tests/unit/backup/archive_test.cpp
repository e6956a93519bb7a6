#include "server/backup/archive.hpp"

#include <gtest/gtest.h>

#include "db/access_store.hpp"
#include "db/blobs.hpp"
#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "db/user_store.hpp"
#include "server/backup/dump.hpp"
#include "server/backup/machine_backup.hpp"
#include "server/backup/server_backup.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::backup {
namespace {

using test::TemporaryFolder;

std::string refusal_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const db::Refusal& refusal) {
    EXPECT_NE(db::refusal_text(refusal.code()), nullptr) << refusal.code();
    return refusal.code();
  }
  return "";
}

void write_file(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

TEST(Archive, ComesBackAsItWasWritten) {
  TemporaryFolder folder;
  write_file(folder / "big", std::string(3u << 20, 'x'));
  {
    ArchiveWriter archive(folder / "a.tar.zst");
    archive.add("one", "1");
    archive.add("empty", "");
    archive.add_file("dir/big", folder / "big");
    EXPECT_FALSE(std::filesystem::exists(folder / "a.tar.zst")) << "not before it is whole";
    const auto finished = archive.finish({{"kind", "test"}});
    EXPECT_EQ(finished.sha256, db::sha256_hex(test::read_file(folder / "a.tar.zst")));
  }
  EXPECT_EQ(verify(folder / "a.tar.zst").at("entries").size(), 3u);
  std::map<std::string, std::string> found;
  each_entry(folder / "a.tar.zst", [&](Entry& entry) { found[entry.name()] = entry.all(); });
  EXPECT_EQ(found, (std::map<std::string, std::string>{
                       {"one", "1"}, {"empty", ""}, {"dir/big", std::string(3u << 20, 'x')}}));
}

TEST(Archive, AHalfOneLeavesNothing) {
  TemporaryFolder folder;
  { ArchiveWriter(folder / "a.tar.zst").add("one", "1"); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Archive, AFileThatIsNotWhatWasStoredStopsTheBackup) {
  TemporaryFolder folder;
  write_file(folder / "f", "text");
  ArchiveWriter archive(folder / "a.tar.zst");
  EXPECT_THROW(archive.add_file("f", folder / "f", std::string(64, '0')), db::Error);
}

// Every byte, one at a time, and every length: whatever is damaged is noticed.
TEST(Archive, AnyDamageIsRefused) {
  TemporaryFolder folder;
  {
    ArchiveWriter archive(folder / "a.tar.zst");
    archive.add("one", "hello there, this is text");
    archive.finish({{"kind", "test"}});
  }
  const std::string whole = test::read_file(folder / "a.tar.zst");
  int harmless = 0;
  const auto refused = [&](const std::string& bytes) {
    write_file(folder / "b.tar.zst", bytes);
    const auto code = refusal_of([&] {
      verify(folder / "b.tar.zst");
      std::string text;
      each_entry(folder / "b.tar.zst", [&](Entry& entry) { text += entry.all(); });
      // What passes must say the same as before (padding, times and the like may differ).
      EXPECT_EQ(text, "hello there, this is text");
      ++harmless;
    });
    return code;
  };
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ 0x10);
    refused(bytes);
  }
  EXPECT_LT(harmless, static_cast<int>(whole.size()) / 10);
  for (std::size_t length = 0; length < whole.size() * 9 / 10; length += 7)
    EXPECT_NE(refused(whole.substr(0, length)), "") << length;
}

TEST(Archive, ANameThatLeavesTheFolderIsRefused) {
  TemporaryFolder folder;
  {
    ArchiveWriter archive(folder / "a.tar.zst");
    archive.add("files/../../evil", "x");
    archive.finish({{"kind", "test"}});
  }
  EXPECT_EQ(refusal_of([&] { verify(folder / "a.tar.zst"); }), "damaged_backup");
}

struct ServerBackupTest : testing::Test {
  /// A shop with something of everything that is awkward: bytes that are no UTF-8, reals, nulls, a changed
  /// identity.
  void fill(db::Database& db) {
    db::put_setting(db, "odd", "a\xFFz\n\"'");
    db::UserRow user;
    user.user = "li";
    user.name = "李";
    user.role = "viewer";
    user.language = "zh";
    db::insert_user(db, user);
    db.execute("UPDATE users SET last_sign_in_ms = NULL");
    db::MachineRow machine;
    machine.name = "Lathe 1";
    machine.profile = "fanuc-0i-t";
    const auto id = db::insert_machine(db, machine);
    db.execute(
        "INSERT INTO tool_life (machine_id, tool, unit, used, life, at_ms) VALUES (?, 'T1', 'min', ?, 5, 1)",
        {id, 1.0 / 3.0});
    for (int i = 0; i < 3; ++i) db::append_audit(db, {0, i, "li", "", "a", "s", "{}", "", ""});
    const db::Blobs blobs(folder.path());
    auto writer = blobs.begin();
    writer.append("O1\nM30\n");
    sha256 = writer.finish();
    db.execute(
        "INSERT INTO blobs (sha256, bytes, lines, longest_line, encoding, line_ends, nul_bytes, has_percent, "
        "created_ms) "
        "VALUES (?, 7, 2, 3, 'ascii', 'lf', 0, 0, 1)",
        {sha256});
    std::filesystem::create_directories(folder / "pki");
    write_file(folder / "pki/ca.pem", "key");
  }
  std::filesystem::path back_up(db::Database& db) {
    const auto snapshot = db.snapshot(folder.path());
    while (snapshot->step()) {
      // Somebody goes on working meanwhile.
      db::put_setting(db, "meanwhile", "x");
    }
    ArchiveWriter archive(folder / "a.tar.zst");
    const auto copy = snapshot->open();
    auto facts = write_server(archive, *copy, db::Blobs(folder.path()), folder.path());
    facts["kind"] = "server";
    archive.finish(facts);
    return folder / "a.tar.zst";
  }
  TemporaryFolder folder, second;
  std::string sha256;
};

TEST_F(ServerBackupTest, IsRestoredWholeIntoAnEmptyFolder) {
  const auto db = test::open_shop(folder / "headstock.db");
  fill(*db);
  const auto archive = back_up(*db);
  const std::string connection = test::test_database();
  const auto restored = restore_server(archive, second / "data", connection);
  EXPECT_EQ(restored.programs, 1);
  const auto copy =
      connection.empty() ? db::open_sqlite(second / "data" / "headstock.db") : db::open_postgres(connection);
  EXPECT_EQ(db::first_broken_audit(*copy), 0);
  EXPECT_EQ(db::audit_head(*copy).id, 3);
  EXPECT_EQ(db::setting(*copy, "odd"), db::setting(*db, "odd"));
  EXPECT_EQ(db::user_named(*copy, "li")->name, "李");
  copy->each("SELECT used FROM tool_life", {}, [](const db::Row& row) { EXPECT_EQ(row.real(0), 1.0 / 3.0); });
  EXPECT_TRUE(db::Blobs(second / "data").verify(sha256));
  EXPECT_EQ(test::read_file(second / "data" / "pki/ca.pem"), "key");
  EXPECT_EQ(copy->integer("SELECT COUNT(*) FROM downtime_reasons"),
            db->integer("SELECT COUNT(*) FROM downtime_reasons"));
  db::MachineRow machine;
  machine.name = "Lathe 2";
  machine.profile = "fanuc-0i-t";
  EXPECT_GT(db::insert_machine(*copy, machine), 1) << "ids go on where they were";
}

TEST_F(ServerBackupTest, NeverOverWhatIsThereAndNothingStaysOfAFailure) {
  const auto db = test::open_shop(folder / "headstock.db");
  fill(*db);
  const auto archive = back_up(*db);
  std::filesystem::create_directories(second / "data");
  write_file(second / "data" / "precious", "x");
  EXPECT_EQ(refusal_of([&] { restore_server(archive, second / "data", ""); }), "not_empty");
  EXPECT_EQ(test::read_file(second / "data" / "precious"), "x");
  std::string bytes = test::read_file(archive);
  bytes.resize(bytes.size() / 2);
  write_file(folder / "half", bytes);
  EXPECT_EQ(refusal_of([&] { restore_server(folder / "half", second / "new", ""); }), "damaged_backup");
  EXPECT_FALSE(std::filesystem::exists(second / "new"));
  {
    ArchiveWriter other(folder / "newer");
    other.add("tables/from_the_future/000001.jsonl", "[\"a\"]\n[1]\n");
    other.finish({{"kind", "server"}});
  }
  EXPECT_EQ(refusal_of([&] { restore_server(folder / "newer", second / "new", ""); }), "newer_backup");
  EXPECT_TRUE(std::filesystem::is_empty(second / "new"));
}

}  // namespace
}  // namespace headstock::backup

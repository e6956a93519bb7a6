#include "server/library/programs.hpp"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <map>
#include <nlohmann/json.hpp>

#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "server/library/checks.hpp"
#include "server/library/distribution.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::library {
namespace {

const Actor kProgrammer{7, "prog", access::Role::programmer, "here"};
const Actor kSetter{8, "setter", access::Role::setter, "here"};
const Actor kViewer{9, "viewer", access::Role::viewer, "here"};

std::string refusal_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const db::Refusal& refusal) {
    EXPECT_NE(db::refusal_text(refusal.code()), nullptr) << refusal.code();
    return refusal.code();
  }
  return "";
}

/// A library with one machine in it.
struct Library {
  explicit Library(const std::filesystem::path& folder) : blobs(folder) {}

  db::BlobRow put(const std::string& text) const {
    Upload upload(blobs);
    upload.append(text);
    return upload.finish();
  }
  static std::int64_t add_machine(db::Database& db, const std::string& name = "Lathe 1",
                                  const std::string& config = "c1") {
    db::MachineRow row;
    row.name = name;
    row.profile = "fanuc-0i-t";
    row.config_hash = config;
    return db::insert_machine(db, row);
  }
  static void pass(db::Database& db, const std::string& sha256, std::int64_t machine,
                   const std::string& config = "c1", bool ok = true) {
    db::put_check(db,
                  {0, machine, sha256, config, checker_version(), 0, ok, R"({"ok":true,"findings":[]})", 5});
  }
  db::Blobs blobs;
};

struct ProgramsTest : testing::Test {
  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> db = test::open_shop(folder / "s.db");
  Library library{folder.path()};

  Added add(const std::string& text, const Place& place = {"/customer", "O1001"}) {
    return add_revision(*db, kProgrammer, place, library.put(text), "why", "upload", 100);
  }
};

TEST_F(ProgramsTest, TheSameContentIsTheSameRevision) {
  const Added first = add("O1001\nM30\n");
  EXPECT_TRUE(first.created);
  EXPECT_EQ(first.revision.number, 1);
  EXPECT_FALSE(first.duplicate_of);
  const Added again = add("O1001\nM30\n");
  EXPECT_FALSE(again.created);
  EXPECT_EQ(again.revision.number, 1);
  const Added second = add("O1001\nM02\n");
  EXPECT_EQ(second.revision.number, 2);
  EXPECT_EQ(second.program.id, first.program.id);
  const Added back = add("O1001\nM30\n");  // going back is a revision of its own
  EXPECT_EQ(back.revision.number, 3);
  ASSERT_TRUE(back.duplicate_of);
  EXPECT_EQ(back.duplicate_of->number, 1);
  const Added elsewhere = add("O1001\nM30\n", {"/", "COPY"});
  EXPECT_NE(elsewhere.program.id, first.program.id);
  EXPECT_TRUE(elsewhere.duplicate_of);
  EXPECT_EQ(db::revisions(*db, first.program.id).size(), 3u);
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM blobs"), 2);
}

TEST_F(ProgramsTest, UploadsAreRefusedWithAReason) {
  EXPECT_EQ(refusal_of([&] { library.put(""); }), "empty_program");
  EXPECT_EQ(refusal_of([&] {
              Upload upload(library.blobs, {100});
              upload.append(std::string(101, 'X'));
            }),
            "too_large");
  for (const char* name : {"", ".", "..", "a/b", "a\\b", "a\nb", "\xFF", " x"})
    EXPECT_EQ(refusal_of([&] { add("M30\n", {"/", name}); }), "bad_name") << name;
  EXPECT_EQ(refusal_of([&] { add("M30\n", {"/a/../b", "x"}); }), "bad_folder");
  EXPECT_EQ(refusal_of([&] {
              add_revision(*db, kViewer, {"/", "x"}, library.put("M30"), "", "", 1);
            }),
            "forbidden");
  EXPECT_EQ(db->integer("SELECT COUNT(*) FROM programs"), 0);
}

TEST_F(ProgramsTest, FoldersAndNames) {
  EXPECT_EQ(clean_folder("//a//零件/"), "/a/零件");
  EXPECT_EQ(clean_folder(""), "/");
  const auto one = add("M30\n").program;
  add("M02\n", {"/customer", "O2"});
  EXPECT_EQ(refusal_of([&] {
              move_program(*db, kProgrammer, one.id, {"/customer", "O2"}, 1);
            }),
            "name_taken");
  EXPECT_EQ(move_program(*db, kProgrammer, one.id, {"/x/y", "O9"}, 1).folder, "/x/y");
  EXPECT_EQ(db::folders(*db), (std::vector<std::string>{"/", "/customer", "/x", "/x/y"}));
  EXPECT_EQ(refusal_of([&] { remove_folder(*db, kProgrammer, "/x", 1); }), "not_empty");
  remove_program(*db, kProgrammer, one.id, 2);
  EXPECT_EQ(refusal_of([&] { require_program(*db, one.id); }), "not_found");
  EXPECT_TRUE(add("M30\n", {"/x/y", "O9"}).created);  // the name is free again
}

TEST_F(ProgramsTest, ReleaseNeedsAPassedCheckAReasonAndASetter) {
  const Added added = add("M30\n");
  const auto id = added.program.id;
  const auto machine = Library::add_machine(*db);
  const auto release_it = [&](const Actor& actor, const std::string& why, std::int64_t for_machine = 0) {
    return refusal_of([&] { release(*db, actor, id, 1, why, 10, for_machine); });
  };
  EXPECT_EQ(release_it(kProgrammer, "tested"), "forbidden");
  EXPECT_EQ(release_it(kSetter, "  "), "reason_missing");
  EXPECT_EQ(release_it(kSetter, "tested"), "not_checked");
  Library::pass(*db, added.revision.blob.sha256, machine, "c1", false);
  EXPECT_EQ(release_it(kSetter, "tested"), "not_checked");
  Library::pass(*db, added.revision.blob.sha256, machine, "an older configuration");
  EXPECT_EQ(release_it(kSetter, "tested"), "not_checked");
  Library::pass(*db, added.revision.blob.sha256, machine);
  const auto other = Library::add_machine(*db, "Lathe 2");
  EXPECT_EQ(release_it(kSetter, "tested", other), "not_checked");
  EXPECT_EQ(release_it(kSetter, "tested", machine), "");
  EXPECT_EQ(refusal_of([&] { remove_program(*db, kProgrammer, id, 11); }), "released");
  EXPECT_EQ(refusal_of([&] { release(*db, kSetter, id, 2, "x", 10); }), "not_found");
  EXPECT_EQ(db::program(*db, id)->released->number, 1);

  const Added next = add("M02\n");
  Library::pass(*db, next.revision.blob.sha256, machine);
  release(*db, kSetter, id, 2, "better", 12);
  EXPECT_EQ(db::program(*db, id)->released->number, 2);
  const auto history = db::releases(*db, id);
  ASSERT_EQ(history.size(), 2u);
  EXPECT_EQ(history[1].withdrawn_by, "setter");
  withdraw(*db, kSetter, id, "scrap", 13);
  EXPECT_FALSE(db::program(*db, id)->released);
  EXPECT_EQ(refusal_of([&] { withdraw(*db, kSetter, id, "scrap", 13); }), "not_released");
}

/// Stands for the gateway.
struct FakeCarrier {
  std::map<std::int64_t, std::string> answers;  // machine → reason against, empty: takes it
  std::map<std::int64_t, std::string> received;
  std::vector<std::uint64_t> drips, offered_again, cancelled;
  std::vector<std::int64_t> connected;

  Carrier carrier() {
    return {[this](std::int64_t machine) { return std::ranges::find(connected, machine) != connected.end(); },
            [this](std::uint64_t id, std::int64_t machine, std::string, std::string sha256,
                   std::shared_ptr<server::BlobReader> content) {
              return put(id, machine, std::move(sha256), std::move(content));
            },
            [this](std::uint64_t id, std::int64_t machine, std::string, std::string,
                   std::shared_ptr<server::BlobReader>) { return drip(id, machine); },
            [this](std::uint64_t id, std::int64_t, std::string, std::string,
                   std::shared_ptr<server::BlobReader>) { offered_again.push_back(id); },
            [this](std::uint64_t id, const std::string&) {
              cancelled.push_back(id);
              return true;
            }};
  }
  boost::asio::awaitable<server::TransferState> put(std::uint64_t id, std::int64_t machine,
                                                    std::string sha256,
                                                    std::shared_ptr<server::BlobReader> content) {
    std::string text(content->size(), ' ');
    content->read(0, text.data(), text.size());
    server::TransferState state;
    state.id = id;
    state.machine = machine;
    state.kind = "put";
    state.state = answers[machine].empty() ? "done" : "failed";
    state.reason = answers[machine];
    state.bytes = state.total = content->size();
    state.sha256 = sha256;
    if (state.reason.empty()) received[machine] = text;
    co_return state;
  }
  boost::asio::awaitable<server::MachineAnswer> drip(std::uint64_t id, std::int64_t machine) {
    drips.push_back(id);
    server::MachineAnswer answer;
    answer.accepted = answers[machine].empty();
    answer.reason = answers[machine];
    co_return answer;
  }
};

struct DistributionTest : testing::Test {
  test::TemporaryFolder folder;
  db::Store store{folder.path(), test::test_database()};
  db::Pool workers{1};
  Library library{folder.path()};
  Checks checks{store, workers, library.blobs};
  FakeCarrier fake;
  std::map<std::int64_t, db::TransferRow> news;
  std::int64_t machine_1 = 0, machine_2 = 0, machine_3 = 0, program = 0;
  boost::asio::io_context io;
  std::unique_ptr<Distributor> distributor;

  DistributionTest() {
    const db::BlobRow blob = library.put("O1\nM30\n");
    store.now([&](db::Database& db) {
      machine_1 = Library::add_machine(db, "1");
      machine_2 = Library::add_machine(db, "2");
      machine_3 = Library::add_machine(db, "3");
      program = add_revision(db, kProgrammer, {"/", "O1"}, blob, "", "upload", 1).program.id;
      for (const auto machine : {machine_1, machine_2, machine_3}) Library::pass(db, blob.sha256, machine);
      release(db, kSetter, program, 1, "ok", 2);
    });
    distributor =
        std::make_unique<Distributor>(io.get_executor(), store, library.blobs, checks, fake.carrier(),
                                      [this](const db::TransferRow& row) { news[row.machine] = row; });
  }

  template <class T>
  T wait_for(boost::asio::awaitable<T> work) {
    std::optional<T> result;
    std::exception_ptr error;
    boost::asio::co_spawn(io, std::move(work), [&](std::exception_ptr thrown, T value) {
      error = thrown;
      if (!thrown) result = std::move(value);
    });
    io.restart();
    io.run();  // until everything it set in motion has ended
    if (error) std::rethrow_exception(error);
    return std::move(*result);
  }
  db::TransferRow stored(std::int64_t id) {
    db::TransferRow row;
    store.now([&](db::Database& db) { row = *db::transfer(db, id); });
    return row;
  }
};

TEST_F(DistributionTest, EachMachineHasItsResultAndReason) {
  fake.connected = {machine_1, machine_3};
  fake.answers[machine_3] = "memory_full";
  const auto plan = wait_for(
      distributor->distribute(kProgrammer, program, 1, {machine_1, machine_2, machine_3, machine_1}));
  ASSERT_EQ(plan.transfers.size(), 3u);
  EXPECT_EQ(fake.received[machine_1], "O1\nM30\n");
  const auto check = [&](std::size_t index, const char* state, const char* reason) {
    const auto row = stored(plan.transfers[index].id);
    EXPECT_EQ(row.state, state);
    EXPECT_EQ(row.reason, reason);
    EXPECT_TRUE(row.ended_ms);
    EXPECT_EQ(news[row.machine].state, state);
  };
  check(0, "done", "");
  check(1, "failed", "not_connected");
  check(2, "failed", "memory_full");
}

TEST_F(DistributionTest, NothingUnreleasedIsSent) {
  fake.connected = {machine_1};
  store.now([&](db::Database& db) { withdraw(db, kSetter, program, "wrong", 3); });
  const auto plan = wait_for(distributor->distribute(kProgrammer, program, 1, {machine_1}));
  EXPECT_EQ(plan.transfers.at(0).reason, "not_released");
  EXPECT_TRUE(fake.received.empty());
  EXPECT_EQ(refusal_of([&] { wait_for(distributor->drip(kProgrammer, machine_1, program, 1)); }),
            "not_released");
  EXPECT_EQ(refusal_of([&] { wait_for(distributor->distribute(kViewer, program, 1, {machine_1})); }),
            "forbidden");
  EXPECT_EQ(refusal_of([&] { wait_for(distributor->distribute(kProgrammer, program, 1, {})); }),
            "no_machines");
  EXPECT_EQ(refusal_of([&] { wait_for(distributor->distribute(kProgrammer, program, 1, {99})); }),
            "not_found");
}

TEST_F(DistributionTest, ADripFeedSurvivesARestartOfTheServer) {
  fake.connected = {machine_1};
  const auto row = wait_for(distributor->drip(kProgrammer, machine_1, program, 1));
  EXPECT_EQ(row.state, "sending");
  EXPECT_EQ(refusal_of([&] { wait_for(distributor->drip(kProgrammer, machine_1, program, 1)); }),
            "drip_open");
  EXPECT_EQ(refusal_of([&] { wait_for(distributor->drip(kProgrammer, machine_2, program, 1)); }),
            "not_connected");

  Distributor restarted(io.get_executor(), store, library.blobs, checks, fake.carrier(), {});
  boost::asio::co_spawn(io, restarted.resume(), boost::asio::detached);
  io.restart();
  io.run();
  EXPECT_EQ(fake.drips, std::vector<std::uint64_t>{static_cast<std::uint64_t>(row.id)});
  EXPECT_EQ(fake.offered_again, fake.drips);
  server::TransferState done;
  done.id = static_cast<std::uint64_t>(row.id);
  done.machine = machine_1;
  done.state = "done";
  done.bytes = 7;
  restarted.transfer_changed(done);
  EXPECT_EQ(stored(row.id).state, "done");
  EXPECT_EQ(stored(row.id).bytes, 7);
}

TEST_F(DistributionTest, ACancelledTransferStaysCancelled) {
  fake.connected = {machine_1};
  const auto row = wait_for(distributor->drip(kProgrammer, machine_1, program, 1));
  EXPECT_EQ(wait_for(distributor->cancel(kProgrammer, row.id)).state, "cancelled");
  EXPECT_EQ(fake.cancelled.size(), 1u);
  server::TransferState late;
  late.id = static_cast<std::uint64_t>(row.id);
  late.machine = machine_1;
  late.state = "sending";
  distributor->transfer_changed(late);
  EXPECT_EQ(stored(row.id).state, "cancelled");
  EXPECT_EQ(refusal_of([&] { wait_for(distributor->cancel(kProgrammer, row.id)); }), "transfer_over");
}

}  // namespace
}  // namespace headstock::library

#include "server/fleet/fleet.hpp"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <nlohmann/json.hpp>

#include "db/event_store.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/fleet/machines.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::fleet {
namespace {

using nlohmann::json;

struct FleetTest : testing::Test {
  test::TemporaryFolder folder;
  boost::asio::io_context io;
  Changes changes;
  db::Store store{folder.path(), test::test_database()};
  std::int64_t machine = 0;
  std::unique_ptr<Fleet> fleet;

  FleetTest() {
    store.now([&](db::Database& db) { machine = create_machine(db, {}, "Lathe", "fanuc-0i-t", "", 1).id; });
    start();
  }
  void start() {
    fleet.reset();
    fleet = std::make_unique<Fleet>(io.get_executor(), store, changes);
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
    io.run();
    if (error) std::rethrow_exception(error);
    return std::move(*result);
  }
  void wait_for(boost::asio::awaitable<void> work) {
    boost::asio::co_spawn(io, std::move(work), boost::asio::detached);
    io.restart();
    io.run();
  }
  std::string interval() {
    std::string state;
    store.now([&](db::Database& db) {
      state = db.text("SELECT state FROM state_intervals WHERE to_ms IS NULL").value_or("none");
    });
    return state;
  }
};

TEST_F(FleetTest, ATokenEnrolsOnce) {
  std::string secret;
  store.now([&](db::Database& db) { secret = issue_token(db, {}, machine, db::now_ms()); });
  EXPECT_EQ(wait_for(fleet->redeem_token("wrong")), 0);
  EXPECT_EQ(wait_for(fleet->redeem_token(secret)), machine);
  EXPECT_EQ(wait_for(fleet->redeem_token(secret)), 0);
  store.now([&](db::Database& db) { secret = issue_token(db, {}, machine, db::now_ms() - kTokenLifeMs); });
  EXPECT_EQ(wait_for(fleet->redeem_token(secret)), 0);
}

TEST_F(FleetTest, ANewCertificateRevokesTheOld) {
  wait_for(fleet->certificate_issued(machine, "aa"));
  EXPECT_TRUE(wait_for(fleet->certificate_valid(machine, "aa")));
  wait_for(fleet->certificate_issued(machine, "bb"));
  EXPECT_FALSE(wait_for(fleet->certificate_valid(machine, "aa")));
  EXPECT_TRUE(wait_for(fleet->certificate_valid(machine, "bb")));
  store.now([&](db::Database& db) { remove_machine(db, {}, machine, 5); });
  EXPECT_FALSE(wait_for(fleet->certificate_valid(machine, "bb")));
}

TEST_F(FleetTest, UnknownUntilHeardAndAfterSilence) {
  EXPECT_EQ(fleet->live_of(machine)["state"], "unknown");
  EXPECT_TRUE(fleet->live_of(machine)["age_ms"].is_null());
  EXPECT_TRUE(fleet->live_of(99).is_null());
  fleet->connected(machine, {{"boot_id", "b1"}, {"software", "agent 1"}});
  EXPECT_EQ(fleet->live_of(machine)["state"], "unknown");
  fleet->live(machine,
              {{"state", "running"}, {"mode", "memory"}, {"remote_armed", true}, {"absolute", {1.0, 2.0}}});
  EXPECT_EQ(fleet->live_of(machine)["state"], "running");
  EXPECT_EQ(fleet->live_of(machine)["remote_armed"], true);
  EXPECT_EQ(interval(), "running");
  fleet->disconnected(machine, "timeout");
  const json live = fleet->live_of(machine);
  EXPECT_EQ(live["state"], "unknown");
  EXPECT_EQ(live["remote_armed"], false);
  EXPECT_EQ(live["absolute"], json({1.0, 2.0}));  // as last seen
  EXPECT_EQ(live["connected"], false);
  EXPECT_EQ(interval(), "unknown");
}

TEST_F(FleetTest, CutOffBeforeItsFirstPictureIsUnknownEvenIfItWasOffBefore) {
  fleet->connected(machine, {{"boot_id", "b1"}});
  fleet->live(machine, {{"state", "idle"}, {"mode", "memory"}});
  fleet->disconnected(machine, "shutdown");
  EXPECT_EQ(fleet->live_of(machine)["state"], "off");
  fleet->connected(machine, {{"boot_id", "b2"}});
  EXPECT_EQ(fleet->live_of(machine)["state"], "unknown");
  fleet->disconnected(machine, "timeout");
  EXPECT_EQ(fleet->live_of(machine)["state"], "unknown");
  EXPECT_EQ(interval(), "unknown");
  start();
  EXPECT_EQ(fleet->live_of(machine)["state"], "unknown");
}

TEST_F(FleetTest, AServerRestartKnowsNothingButKeepsWhatWasSeen) {
  fleet->connected(machine, {{"boot_id", "b1"}});
  fleet->live(machine, {{"state", "running"}, {"mode", "memory"}, {"line", 12}});
  start();
  EXPECT_EQ(fleet->live_of(machine)["state"], "unknown");
  EXPECT_EQ(fleet->live_of(machine)["line"], 12);
  EXPECT_EQ(interval(), "unknown");
}

TEST_F(FleetTest, EventsReachTheStoreAndTheWatchers) {
  int woken = 0;
  const auto watcher = changes.subscribe([&] { ++woken; });
  fleet->connected(machine, {{"boot_id", "b1"}});
  const json events = {
      {{"seq", 1}, {"at_ms", 5}, {"kind", "part"}, {"count", 1}, {"total", 1}, {"program", "O1"}},
      {{"seq", 2},
       {"at_ms", 6},
       {"kind", "alarm"},
       {"id", 1},
       {"code", "PS0010"},
       {"text", {{"en", "e"}, {"zh", "z"}}}}};
  EXPECT_EQ(wait_for(fleet->events(machine, "spool", events)), 2u);
  EXPECT_EQ(wait_for(fleet->events(machine, "spool", events)), 2u);
  EXPECT_EQ(woken, 1);
  std::map<std::string, int> topics;
  for (const Change& change : watcher->take()) ++topics[change.topic];
  EXPECT_EQ(topics["part"], 1);
  EXPECT_EQ(topics["alarm"], 1);
  EXPECT_EQ(topics["live"], 1);
  EXPECT_EQ(fleet->live_of(machine)["alarms"][0]["code"], "PS0010");
  EXPECT_EQ(wait_for(fleet->events(machine, "spool",
                                   {{{"seq", 3}, {"at_ms", 9}, {"kind", "alarm_cleared"}, {"id", 1}}})),
            3u);
  EXPECT_TRUE(fleet->live_of(machine)["alarms"].empty());
}

TEST_F(FleetTest, ARestartedControllerHasNoOldAlarms) {
  fleet->connected(machine, {{"boot_id", "b1"}});
  wait_for(fleet->events(machine, "spool",
                         {{{"seq", 1}, {"at_ms", 6}, {"kind", "alarm"}, {"id", 1}, {"code", "PS0010"}}}));
  fleet->disconnected(machine, "timeout");
  fleet->connected(machine, {{"boot_id", "b2"}});
  fleet->live(machine, {{"state", "idle"}, {"alarms", json::array()}});
  store.now([](db::Database&) {});
  io.restart();
  io.run();
  EXPECT_TRUE(fleet->live_of(machine)["alarms"].empty());
}

TEST_F(FleetTest, TheAgentsMachineFileIsWhatIsCheckedAgainst) {
  std::string before;
  store.now([&](db::Database& db) { before = require_machine(db, machine).config_hash; });
  fleet->connected(machine, {{"boot_id", "b1"}, {"machine_toml", "[axis.X]\nnonsense = 1\n"}});
  store.now([&](db::Database& db) { EXPECT_EQ(require_machine(db, machine).config_hash, before); });
  fleet->connected(machine, {{"boot_id", "b1"}, {"machine_toml", "[axis.X]\nmax_mm = 123.0\n"}});
  store.now([&](db::Database& db) { EXPECT_NE(require_machine(db, machine).config_hash, before); });
}

TEST(ChangesHub, ASlowWatcherGetsTheNewestAndIsToldWhenPiecesWereDropped) {
  Changes changes;
  int woken = 0;
  const auto watcher = changes.subscribe([&] { ++woken; });
  for (int i = 0; i < 5'000; ++i) {
    changes.publish_live(1, std::make_shared<const json>(i));
    changes.publish({"part", 1, std::make_shared<const json>(i)});
  }
  EXPECT_EQ(woken, 1);
  const auto all = watcher->take();
  ASSERT_EQ(all.size(), 1u + 1'024 + 1);
  EXPECT_EQ(all.front().topic, "resync");
  EXPECT_EQ(*all.back().body, 4'999);
  EXPECT_TRUE(watcher->take().empty());
}

TEST_F(FleetTest, MachinesAreRefusedWithAReason) {
  const auto refusal = [&](const std::function<void(db::Database&)>& action) {
    std::string code;
    store.now([&](db::Database& db) {
      try {
        action(db);
      } catch (const db::Refusal& thrown) {
        code = thrown.code();
      }
    });
    return code;
  };
  EXPECT_EQ(refusal([](db::Database& db) { create_machine(db, {}, "Lathe", "fanuc-0i-t", "", 1); }),
            "name_taken");
  EXPECT_EQ(refusal([](db::Database& db) { create_machine(db, {}, "L2", "siemens", "", 1); }), "bad_profile");
  EXPECT_EQ(
      refusal([](db::Database& db) { create_machine(db, {}, "L2", "fanuc-0i-t", "[axis.X]\nmax = 1", 1); }),
      "bad_machine_file");
  access::Actor operator_;
  operator_.role = access::Role::operator_;
  EXPECT_EQ(refusal([&](db::Database& db) { create_machine(db, operator_, "L2", "fanuc-0i-t", "", 1); }),
            "forbidden");
}

}  // namespace
}  // namespace headstock::fleet

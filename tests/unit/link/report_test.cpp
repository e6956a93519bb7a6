// What comes up: live, census, events; and the commands that go down.
#include <gtest/gtest.h>

#include "tests/unit/link/shop.hpp"

namespace headstock {
namespace {

using namespace testing_support;
using namespace std::chrono_literals;

struct Connected : ::testing::Test {
  Shop shop;
  Agent agent{shop.folder.path() / "agent"};
  void SetUp() override {
    auto options = agent.options(shop.gateway->port());
    options.enrolment_token = shop.token_for(3);
    agent.connect(shop.io, options);
    ASSERT_TRUE(shop.until([&] { return shop.gateway->is_connected(3); }));
  }
};

TEST_F(Connected, LiveArrivesWithItsTrail) {
  agent.machine.now.program_name = "O1001";
  ASSERT_TRUE(shop.until([&] {
    return shop.fleet.live_of[3].is_object() && shop.fleet.live_of[3]["program"].is_object() &&
           !shop.fleet.live_of[3]["trail"].empty();
  }));
  const json live = shop.fleet.live_of[3];
  EXPECT_EQ(live["program"]["name"], "O1001");
  EXPECT_EQ(live["trail"][0].size(), 2u);
  EXPECT_LE(live["trail"].size(), 100u);
  EXPECT_TRUE(live["drip"].is_null());
}

TEST_F(Connected, AnAgentThatIsSwitchedOffSaysSo) {
  ASSERT_TRUE(shop.until([&] { return agent.link->status().connected; }));
  EXPECT_TRUE(agent.link->say_good_bye());
  ASSERT_TRUE(shop.until([&] { return !agent.link->connection_open(); }));
  ASSERT_TRUE(shop.until([&] { return !shop.fleet.disconnects.empty(); }));
  EXPECT_EQ(shop.fleet.disconnects.back(), "shutdown") << "not a lost link: the machine is off";
  const int connects = shop.fleet.connects[3];
  shop.run_for(200ms);
  EXPECT_EQ(shop.fleet.connects[3], connects) << "it does not come back by itself";
}

TEST_F(Connected, AServerThatIsSwitchedOffSaysSo) {
  ASSERT_TRUE(shop.until([&] { return agent.machine.ups == 1; }));
  bool over = false;
  asio::co_spawn(
      shop.io,
      [&]() -> asio::awaitable<void> {
        co_await shop.gateway->shut_down(5s);
        over = true;
      },
      asio::detached);
  ASSERT_TRUE(shop.until([&] { return over && agent.machine.losts == 1; }));
  EXPECT_EQ(agent.machine.lost_reason, "closed by the server: shutdown");
}

TEST_F(Connected, CensusFollowsTheMemory) {
  ASSERT_TRUE(shop.until([&] { return shop.fleet.census_of.contains(3); }));
  agent.memory.put("O1", "G0\n");
  ASSERT_TRUE(shop.until([&] { return shop.fleet.census_of[3].size() == 1; }));
  EXPECT_EQ(shop.fleet.census_of[3][0]["sha256"], wire::sha256_hex("G0\n"));
}

TEST_F(Connected, CommandsAreAnsweredWithTheMachinesReason) {
  auto answer = shop.wait_for(shop.gateway->command(3, "set_feed_override", 0.8, "li"));
  EXPECT_TRUE(answer.accepted);
  EXPECT_EQ(agent.machine.commands.back(),
            std::to_string(static_cast<int>(operation::Action::set_feed_override)) + " 0.800000 li");
  agent.machine.answer = {false, "not_armed"};
  answer = shop.wait_for(shop.gateway->command(3, "cycle_start", 0, "li"));
  EXPECT_FALSE(answer.accepted);
  EXPECT_EQ(answer.reason, "not_armed");
  EXPECT_EQ(shop.wait_for(shop.gateway->command(3, "explode", 0, "li")).reason, "unknown_action");
  EXPECT_EQ(shop.wait_for(shop.gateway->select(3, "O1", "li")).reason, "not_armed");
  EXPECT_EQ(agent.machine.commands.back(), "select O1 li");
  EXPECT_EQ(shop.wait_for(shop.gateway->delete_program(3, "O1")).reason, "not_found");
  EXPECT_EQ(shop.wait_for(shop.gateway->command(4, "cycle_start", 0, "li")).reason, "not_connected");
}

TEST_F(Connected, ResidentProgramIsReadBack) {
  const std::string text = program_text(700'000);
  agent.memory.put("O1", text);
  const auto program = shop.wait_for(shop.gateway->get(3, "O1"));
  ASSERT_TRUE(program.ok) << program.reason;
  EXPECT_EQ(program.text, text);
  EXPECT_EQ(shop.wait_for(shop.gateway->get(3, "O2")).reason, "not_found");
}

TEST_F(Connected, LossOfTheLinkIsToldOnceOnBothSides) {
  shop.gateway->drop(3, "removed");
  EXPECT_TRUE(shop.until([&] { return agent.machine.losts == 1 && shop.fleet.disconnects.size() == 1; }));
  EXPECT_TRUE(shop.until([&] { return agent.machine.ups == 2; }))
      << "its certificate is still good, so it may come back";
}

TEST_F(Connected, StoreThatFailsLosesNoEvent) {
  shop.fleet.store_broken = true;
  agent.spool.commit(std::vector<link::NewEvent>{{1, "part", R"({"count":1})"}});
  ASSERT_TRUE(shop.until([&] { return !shop.fleet.disconnects.empty(); }));
  EXPECT_EQ(agent.spool.pending(), 1u);
  shop.fleet.store_broken = false;
  ASSERT_TRUE(shop.until([&] { return agent.spool.pending() == 0; }));
  ASSERT_EQ(shop.fleet.events_committed.size(), 1u);
  EXPECT_EQ(shop.fleet.events_committed[0]["count"], 1);
  EXPECT_EQ(shop.fleet.events_committed[0]["kind"], "part");
}

// A report says what the machine had when one event was written. Taken up behind a later one it would differ
// from what that event told, and a change that somebody made would be noted as found.
TEST_F(Connected, AReportIsTakenUpBetweenTheEventsItStandsBetween) {
  ASSERT_TRUE(shop.until([&] { return shop.fleet.census_of.contains(3); }));
  const auto write = [&](const char* after) {
    agent.spool.commit(std::vector<link::NewEvent>{{1, "offset", std::string(R"({"after":)") + after + "}"}});
  };
  write("1");
  ASSERT_TRUE(shop.until([&] { return agent.spool.pending() == 0; }));
  shop.fleet.stored[3].clear();
  shop.fleet.census_held = true;
  agent.memory.put("O1", "G0\n");
  ASSERT_TRUE(shop.until([&] { return !shop.fleet.stored[3].empty(); }));
  agent.machine.report = {{"sequence", 1}, {"values", {{"tool/3/wear/X", 1}}}};
  ASSERT_TRUE(shop.until([&] { return agent.machine.reports == 1; }));
  write("2");
  // Its answer comes behind them: the server has read both by then.
  ASSERT_TRUE(shop.wait_for(shop.gateway->command(3, "feed_hold", 0, "li")).accepted);
  shop.fleet.census_held = false;
  ASSERT_TRUE(shop.until([&] { return agent.spool.pending() == 0; }));
  EXPECT_EQ(shop.fleet.stored[3], (std::vector<std::string>{"census", "report 1", "events 2"}));
}

TEST(Events, EachOnceThoughTheLinkIsCutAtRandomBytesAndBothEndsRestart) {
  Shop shop;
  auto proxy = std::make_unique<CuttingProxy>(shop.io, shop.gateway->port());
  std::mt19937 random(5);
  Agent agent(shop.folder.path() / "agent");
  auto options = agent.options(proxy->port());
  options.enrolment_token = shop.token_for(3);
  agent.connect(shop.io, options);
  ASSERT_TRUE(shop.until([&] { return agent.link->status().connected; }));
  options.enrolment_token.clear();
  proxy->allowance = [&]() -> std::optional<std::size_t> { return 3'000 + random() % 6'000; };
  proxy->cut_all();

  constexpr int kParts = 1'500;
  int made = 0, gateways = 0, links = 0;
  while (made < kParts || agent.spool.pending() > 0) {
    if (made < kParts) {
      std::vector<link::NewEvent> events;
      for (auto n = 1 + random() % 5; n > 0 && made < kParts; --n)
        events.push_back({made, "part", "{\"count\":" + std::to_string(++made) + "}"});
      agent.spool.commit(events);
    }
    const auto chance = random() % 40;
    if (chance == 0) {
      shop.stop_gateway();
      shop.start_gateway();
      proxy->forward_to(shop.gateway->port());
      ++gateways;
    } else if (chance == 1) {
      agent.link.reset();
      agent.connect(shop.io, options);
      ++links;
    }
    shop.run_for(std::chrono::milliseconds(random() % 20));
    if (made == kParts) {
      proxy->allowance = nullptr;  // let it finish
      ASSERT_TRUE(shop.until([&] { return agent.spool.pending() == 0; }));
    }
  }
  EXPECT_GT(proxy->cuts, 5);
  EXPECT_GT(gateways, 2);
  EXPECT_GT(links, 2);
  ASSERT_EQ(shop.fleet.events_committed.size(), static_cast<std::size_t>(kParts));
  for (int n = 0; n < kParts; ++n)
    EXPECT_EQ(shop.fleet.events_committed[static_cast<std::size_t>(n)]["count"], n + 1);
}

}  // namespace
}  // namespace headstock

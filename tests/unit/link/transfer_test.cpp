// What goes down: programs into the memory, and drip-feeds over a line that is cut.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/unit/link/shop.hpp"

namespace headstock {
namespace {

using namespace testing_support;
using namespace std::chrono_literals;

struct Transfers : ::testing::Test {
  Shop shop;
  std::unique_ptr<CuttingProxy> proxy = std::make_unique<CuttingProxy>(shop.io, shop.gateway->port());
  Agent agent{shop.folder.path() / "agent", 4u << 20};
  std::mt19937 random{9};

  void SetUp() override {
    auto options = agent.options(proxy->port());
    options.enrolment_token = shop.token_for(3);
    options.drip_buffer_bytes = 256 << 10;
    agent.connect(shop.io, options);
    ASSERT_TRUE(shop.until([&] { return shop.gateway->is_connected(3); }));
  }
  static std::shared_ptr<TextBlob> blob(const std::string& text) {
    return std::make_shared<TextBlob>(std::make_shared<const std::string>(text));
  }
  server::TransferState put(const std::string& name, const std::string& text, std::uint64_t id = 1) {
    return shop.wait_for(shop.gateway->put(id, 3, name, wire::sha256_hex(text), blob(text)));
  }
  /// Reads the stream as the interpreter does. @return status of the last read.
  program::ReadStatus read_some(std::string& into, std::size_t at_most) {
    std::vector<char> buffer(at_most);
    const auto result = agent.machine.stream->read(buffer);
    into.append(buffer.data(), result.bytes);
    return result.status;
  }
  /// Runs the loop and reads until the stream ends.
  program::ReadStatus read_to_end(std::string& into) {
    auto status = program::ReadStatus::wait;
    shop.until([&] {
      status = read_some(into, 30'000);
      EXPECT_LE(shop.fleet.transfers[5].bytes, into.size() + (512u << 10));
      return status == program::ReadStatus::end || status == program::ReadStatus::failed;
    });
    return status;
  }
};

TEST_F(Transfers, ProgramArrivesWhole) {
  const std::string text = program_text(1'000'000);
  const auto state = put("O1", text);
  EXPECT_EQ(state.state, "done") << state.reason;
  EXPECT_EQ(state.bytes, text.size());
  EXPECT_EQ(agent.memory.find("O1")->sha256, wire::sha256_hex(text));
  EXPECT_EQ(put("O1", text, 2).state, "done") << "the same again is no work";
  EXPECT_EQ(put("empty", "", 3).state, "done");
}

TEST_F(Transfers, RefusalsNameTheirReason) {
  EXPECT_EQ(put("big", std::string((4u << 20) + 1, 'x')).reason, "memory_full");
  EXPECT_EQ(put("../etc/passwd", "x").reason, "bad_name");
  agent.memory.put("O1", "old");
  agent.memory.in_use([](const std::string& name) { return name == "O1"; });
  EXPECT_EQ(put("O1", "new").reason, "running");
  const auto lying = shop.wait_for(shop.gateway->put(9, 3, "O2", std::string(64, 'a'), blob("text")));
  EXPECT_EQ(lying.reason, "blob_damaged")
      << "a store that changed its bytes is noticed before the machine has them";
  EXPECT_FALSE(agent.memory.find("O2"));
  EXPECT_EQ(shop.wait_for(shop.gateway->put(10, 4, "O1", wire::sha256_hex("x"), blob("x"))).reason,
            "not_connected");
  EXPECT_TRUE(shop.gateway->is_connected(3));
}

TEST_F(Transfers, PutsOfOneMachineTakeTurns) {
  const std::string one = program_text(600'000, 1), two = program_text(600'000, 2);
  int done = 0;
  for (const auto& [id, text] : {std::pair(1, &one), std::pair(2, &two)})
    asio::co_spawn(
        shop.io,
        [&, work = shop.gateway->put(static_cast<std::uint64_t>(id), 3,
                                     std::string(1, 'O').append(std::to_string(id)), wire::sha256_hex(*text),
                                     blob(*text))]() mutable -> asio::awaitable<void> {
          const auto state = co_await std::move(work);
          done += state.state == "done";
        },
        asio::detached);
  EXPECT_TRUE(shop.until([&] { return done == 2; }));
}

TEST_F(Transfers, PutGoesOnAfterCuts) {
  const std::string text = program_text(3'000'000);
  proxy->allowance = [&]() -> std::optional<std::size_t> { return 150'000 + random() % 400'000; };
  proxy->cut_all();
  ASSERT_TRUE(shop.until([&] { return shop.fleet.connects[3] >= 2 && shop.gateway->is_connected(3); }));
  const auto state = put("O1", text);
  EXPECT_EQ(state.state, "done") << state.reason;
  EXPECT_GE(proxy->cuts, 5);
  EXPECT_EQ(agent.memory.find("O1")->sha256, wire::sha256_hex(text));
}

TEST_F(Transfers, DripFeedIsByteIdenticalThroughManyCuts) {
  const std::string text = program_text(12'000'000);
  const auto answer = shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex(text), blob(text)));
  ASSERT_TRUE(answer.accepted) << answer.reason;
  EXPECT_EQ(agent.machine.stream_bytes, text.size());
  proxy->allowance = [&]() -> std::optional<std::size_t> { return 100'000 + random() % 700'000; };
  proxy->cut_all();
  std::string received;
  EXPECT_EQ(read_to_end(received), program::ReadStatus::end);
  EXPECT_EQ(received.size(), text.size());
  EXPECT_TRUE(received == text);
  EXPECT_GE(proxy->cuts, 20);
  EXPECT_GE(shop.fleet.waits, 20);
  proxy->allowance = nullptr;
  proxy->cut_all();
  ASSERT_TRUE(shop.until([&] { return shop.fleet.transfers[5].state == "done"; }))
      << shop.fleet.transfers[5].state;
}

/// How many times the line is cut at a random byte: a few dozen on every commit,
/// `HEADSTOCK_LINK_CUTS=1000 link_test --gtest_filter=*CutAtRandomBytes` for the whole proof.
int cuts_wanted() {
  const char* text = std::getenv("HEADSTOCK_LINK_CUTS");
  return text ? std::max(1, std::atoi(text)) : 40;
}

TEST_F(Transfers, LinkCutAtRandomBytesAndTheExecutedProgramIsTheStoredOne) {
  const int wanted = cuts_wanted();
  const std::string text = program_text(static_cast<std::size_t>(wanted) * 40'000 + 300'000);
  ASSERT_TRUE(shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex(text), blob(text))).accepted);
  // From the first byte of the handshake on: many connections never come to their hello.
  proxy->allowance = [&]() -> std::optional<std::size_t> { return 1 + random() % 120'000; };
  proxy->cut_all();
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(30 + wanted / 2);
  std::string received;
  auto status = program::ReadStatus::wait;
  while (status != program::ReadStatus::end && status != program::ReadStatus::failed) {
    ASSERT_LT(std::chrono::steady_clock::now(), limit) << proxy->cuts << " cuts, " << received.size() << " bytes";
    shop.io.restart();
    shop.io.run_one_for(2ms);
    if (proxy->cuts >= wanted) proxy->allowance = nullptr;
    // The machine takes what comes no faster than the cuts do: the last one is near the end of the program.
    const std::size_t due = proxy->cuts >= wanted
                                ? text.size()
                                : text.size() / static_cast<std::size_t>(wanted) * static_cast<std::size_t>(proxy->cuts + 1);
    if (received.size() < due || due == text.size()) status = read_some(received, 20'000);
  }
  EXPECT_EQ(status, program::ReadStatus::end);
  EXPECT_GE(proxy->cuts, wanted);
  EXPECT_EQ(wire::sha256_hex(received), wire::sha256_hex(text));
  ASSERT_TRUE(shop.until([&] { return shop.fleet.transfers[5].state == "done"; })) << shop.fleet.transfers[5].state;
  EXPECT_EQ(shop.fleet.transfers[5].bytes, text.size());
}

TEST_F(Transfers, PermissionEndsWithEveryDisconnectAndOnlyReceivingGoesOn) {
  const std::string text = program_text(2'000'000);
  ASSERT_TRUE(shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex(text), blob(text))).accepted);
  const int lost = agent.machine.losts, ups = agent.machine.ups;
  agent.machine.commands.clear();
  for (int cut = 1; cut <= 3; ++cut) {
    proxy->cut_all();
    ASSERT_TRUE(shop.until([&] { return agent.machine.losts == lost + cut; }))
        << "the controller is told, and remote operation is no longer armed";
    ASSERT_TRUE(shop.until([&] { return agent.machine.ups == ups + cut && shop.gateway->is_connected(3); }));
  }
  shop.run_for(200ms);
  EXPECT_TRUE(agent.machine.commands.empty()) << "no command comes of a reconnect";
  std::string received;
  EXPECT_EQ(read_to_end(received), program::ReadStatus::end);
  EXPECT_TRUE(received == text);
}

TEST_F(Transfers, DripFeedWaitsForTheMachineAndIsDoneOnlyWhenItHasRun) {
  const std::string text = program_text(1'000'000);
  ASSERT_TRUE(shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex(text), blob(text))).accepted);
  shop.run_for(300ms);
  EXPECT_LE(shop.fleet.transfers[5].bytes, 256u << 10) << "no more than the buffer while nothing is cut";
  EXPECT_EQ(shop.fleet.live_of[3]["drip"]["transfer"], 5);
  EXPECT_LE(shop.fleet.live_of[3]["drip"]["buffered"], 256 << 10);
  std::string received;
  while (received.size() < text.size()) {
    ASSERT_NE(read_some(received, 10'000), program::ReadStatus::failed);
    shop.run_for(1ms);
  }
  shop.run_for(100ms);
  EXPECT_EQ(shop.fleet.transfers[5].state, "sending")
      << "the last block has been taken, the end not yet seen";
  EXPECT_EQ(read_to_end(received), program::ReadStatus::end);
  ASSERT_TRUE(shop.until([&] { return shop.fleet.transfers[5].state == "done"; }));
  EXPECT_EQ(received, text);
}

TEST_F(Transfers, DripFeedThatTheMachineRefuses) {
  agent.machine.answer = {false, "running"};
  const auto answer = shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex("G0"), blob("G0")));
  EXPECT_FALSE(answer.accepted);
  EXPECT_EQ(answer.reason, "running");
  EXPECT_EQ(shop.fleet.transfers[5].state, "failed");
}

TEST_F(Transfers, ResetAtTheMachineEndsTheDripFeed) {
  const std::string text = program_text(1'000'000);
  ASSERT_TRUE(shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex(text), blob(text))).accepted);
  agent.machine.stream.reset();
  ASSERT_TRUE(shop.until([&] { return shop.fleet.transfers[5].state == "failed"; }));
  EXPECT_EQ(shop.fleet.transfers[5].reason, "closed_by_machine");
}

TEST_F(Transfers, ResetWhileTheLinkIsDownIsToldLater) {
  const std::string text = program_text(1'000'000);
  ASSERT_TRUE(shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex(text), blob(text))).accepted);
  proxy->allowance = []() -> std::optional<std::size_t> { return 100; };
  proxy->cut_all();
  ASSERT_TRUE(shop.until([&] { return shop.fleet.transfers[5].state == "waiting"; }));
  agent.machine.stream.reset();
  proxy->allowance = nullptr;
  ASSERT_TRUE(shop.until([&] { return shop.fleet.transfers[5].reason == "closed_by_machine"; }));
}

TEST_F(Transfers, CancelledDripFeedFailsAtTheMachine) {
  const std::string text = program_text(1'000'000);
  ASSERT_TRUE(shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex(text), blob(text))).accepted);
  EXPECT_TRUE(shop.gateway->cancel(5, "stopped by li"));
  EXPECT_FALSE(shop.gateway->cancel(5, "again"));
  std::string received;
  EXPECT_EQ(read_to_end(received), program::ReadStatus::failed);
  EXPECT_EQ(shop.fleet.transfers[5].state, "cancelled");
}

TEST_F(Transfers, RestartedServerThatOffersItAgainGoesOnAtTheByte) {
  const std::string text = program_text(4'000'000);
  ASSERT_TRUE(shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex(text), blob(text))).accepted);
  std::string received;
  while (received.size() < 1'000'000) {
    read_some(received, 30'000);
    shop.run_for(1ms);
  }
  shop.stop_gateway();
  shop.gateway = std::make_unique<server::Gateway>(shop.io, shop.gateway_options(), shop.fleet);
  shop.gateway->offer_again(5, 3, "big.nc", wire::sha256_hex(text), blob(text));
  shop.gateway->start();
  proxy->forward_to(shop.gateway->port());
  EXPECT_EQ(read_to_end(received), program::ReadStatus::end);
  EXPECT_TRUE(received == text);
  ASSERT_TRUE(shop.until([&] { return shop.fleet.transfers[5].state == "done"; }));
}

TEST_F(Transfers, RestartedServerThatDoesNotOfferItAgainEndsIt) {
  const std::string text = program_text(4'000'000);
  ASSERT_TRUE(shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex(text), blob(text))).accepted);
  shop.stop_gateway();
  shop.start_gateway();
  proxy->forward_to(shop.gateway->port());
  std::string received;
  EXPECT_EQ(read_to_end(received), program::ReadStatus::failed);
  EXPECT_TRUE(text.starts_with(received));
}

TEST_F(Transfers, RestartedMachineFailsTheDripFeed) {
  const std::string text = program_text(1'000'000);
  ASSERT_TRUE(shop.wait_for(shop.gateway->drip(5, 3, "big.nc", wire::sha256_hex(text), blob(text))).accepted);
  agent.link.reset();
  agent.machine.stream.reset();
  agent.connect(shop.io, agent.options(proxy->port()));
  ASSERT_TRUE(shop.until([&] { return shop.fleet.transfers[5].state == "failed"; }));
  EXPECT_EQ(shop.fleet.transfers[5].reason, "machine_restarted");
}

TEST_F(Transfers, ProgressIsReportedSparingly) {
  const std::string text = program_text(3'500'000);
  shop.fleet.transfer_reports = 0;
  const auto started = std::chrono::steady_clock::now();
  ASSERT_EQ(put("O1", text).state, "done");
  const auto seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  EXPECT_LE(shop.fleet.transfer_reports, 4 + static_cast<int>(seconds * 5 + 1));
}

}  // namespace
}  // namespace headstock

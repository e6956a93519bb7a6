// Programs that a machine asks for: M198 while it runs, and an operator at the panel.
#include <gtest/gtest.h>

#include "tests/unit/link/shop.hpp"

namespace headstock {
namespace {

using namespace testing_support;
using namespace std::chrono_literals;
using program::ReadStatus;

struct Requests : ::testing::Test {
  Shop shop;
  std::unique_ptr<CuttingProxy> proxy = std::make_unique<CuttingProxy>(shop.io, shop.gateway->port());
  Agent agent{shop.folder.path() / "agent"};
  void SetUp() override {
    auto options = agent.options(proxy->port());
    options.enrolment_token = shop.token_for(3);
    agent.connect(shop.io, options);
    ASSERT_TRUE(shop.until([&] { return agent.machine.ups == 1; }));
  }
  ReadStatus read_to_end(program::Source& source, std::string& into) {
    auto status = ReadStatus::wait;
    shop.until([&] {
      char buffer[5'000];
      const auto result = source.read(buffer);
      into.append(buffer, result.bytes);
      status = result.status;
      return status == ReadStatus::end || status == ReadStatus::failed;
    });
    return status;
  }
};

TEST_F(Requests, M198GetsItsProgramFromTheServer) {
  const std::string text = program_text(300'000);
  shop.fleet.library["O1234"] = text;
  agent.memory.put("O1234", "another one of that number\n");
  for (int call = 1; call <= 3; ++call) {
    auto source = agent.memory.open_external(1234);
    ASSERT_TRUE(source);
    char byte;
    EXPECT_EQ(source->read({&byte, 1}).status, ReadStatus::wait) << "nobody waits inside a call";
    EXPECT_FALSE(source->seek(0));
    std::string received;
    EXPECT_EQ(read_to_end(*source, received), ReadStatus::end);
    EXPECT_EQ(received, text);
    source.reset();
    const auto transfer = static_cast<std::uint64_t>(1'000 + call);
    ASSERT_TRUE(shop.until([&] { return shop.fleet.transfers[transfer].state == "done"; }));
  }
  EXPECT_FALSE(agent.machine.stream) << "a sub-program is not the selected program";
}

TEST_F(Requests, M198ReturnsBeforeTheEndOfItsTextAndThatIsDone) {
  const std::string text = "O77\nG01 X1.\nM99\n%\n";
  shop.fleet.library["O77"] = text;
  auto source = agent.memory.open_external(77);
  ASSERT_TRUE(source);
  std::string received;
  shop.until([&] {
    char buffer[100];
    const auto result = source->read(buffer);
    received.append(buffer, result.bytes);
    return result.bytes > 0;
  });
  source.reset();  // M99 was read; the end of the text was not
  ASSERT_TRUE(shop.until([&] {
    return shop.fleet.transfers[1'001].state == "done" || shop.fleet.transfers[1'001].state == "failed";
  }));
  EXPECT_EQ(shop.fleet.transfers[1'001].state, "done") << shop.fleet.transfers[1'001].reason;
}

TEST_F(Requests, WhatTheServerDoesNotHaveFails) {
  auto source = agent.memory.open_external(99);
  ASSERT_TRUE(source);
  std::string received;
  EXPECT_EQ(read_to_end(*source, received), ReadStatus::failed);
  EXPECT_EQ(shop.fleet.asked, std::vector<std::string>{"O99"});
}

TEST_F(Requests, WithoutALinkThereIsNoExternalProgram) {
  agent.memory.put("O1234", "another one of that number\n");
  proxy->allowance = []() -> std::optional<std::size_t> { return 100; };
  proxy->cut_all();
  ASSERT_TRUE(shop.until([&] { return agent.machine.losts == 1; }));
  EXPECT_FALSE(agent.memory.open_external(1234)) << "not the resident one of the same number";
  EXPECT_FALSE(agent.link->request("O1234"));
}

TEST_F(Requests, ALinkLostBeforeTheAnswerFails) {
  proxy->stalled = true;
  auto source = agent.memory.open_external(1234);
  ASSERT_TRUE(source);
  shop.run_for(20ms);
  proxy->cut_all();
  proxy->stalled = false;
  std::string received;
  EXPECT_EQ(read_to_end(*source, received), ReadStatus::failed);
}

TEST_F(Requests, AnOperatorAsksForAProgramToBeFed) {
  const std::string text = program_text(100'000);
  shop.fleet.library["O1234"] = text;
  EXPECT_TRUE(agent.link->request("O1234"));
  ASSERT_TRUE(shop.until([&] { return agent.machine.stream != nullptr && !agent.machine.answers.empty(); }));
  EXPECT_EQ(agent.machine.answers.back(), "O1234 accepted");
  std::string received;
  EXPECT_EQ(read_to_end(*agent.machine.stream, received), ReadStatus::end);
  EXPECT_EQ(received, text);
  EXPECT_TRUE(agent.link->request("O5"));
  ASSERT_TRUE(shop.until([&] { return agent.machine.answers.size() == 2; }));
  EXPECT_EQ(agent.machine.answers.back(), "O5 not_found");
}

}  // namespace
}  // namespace headstock

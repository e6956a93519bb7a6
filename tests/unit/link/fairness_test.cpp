// Several machines fed at once. `bench_drip_fleet` does it with 200 and a clock.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/link/shop.hpp"

namespace headstock {
namespace {

using namespace testing_support;
using namespace std::chrono_literals;

TEST(Fairness, MachinesThatTakeAllTheyCanGetEquallyMuch) {
  constexpr int kMachines = 6;
  Shop shop;
  const std::string text = program_text(3'000'000);
  const std::string sha256 = wire::sha256_hex(text);
  std::vector<std::unique_ptr<Agent>> agents;
  std::vector<std::string> received(kMachines);
  for (int i = 1; i <= kMachines; ++i) {
    agents.push_back(std::make_unique<Agent>(shop.folder.path() / std::to_string(i)));
    auto options = agents.back()->options(shop.gateway->port());
    options.enrolment_token = shop.token_for(i);
    options.drip_buffer_bytes = 128 << 10;
    agents.back()->connect(shop.io, options);
    ASSERT_TRUE(shop.until([&] { return shop.gateway->is_connected(i); }));
    const auto answer = shop.wait_for(shop.gateway->drip(static_cast<std::uint64_t>(i), i, "big.nc", sha256,
                                                         std::make_shared<TextBlob>(std::make_shared<const std::string>(text))));
    ASSERT_TRUE(answer.accepted) << answer.reason;
  }
  int ended = 0;
  std::size_t least_when_first_ended = 0;
  ASSERT_TRUE(shop.until([&] {
    for (std::size_t i = 0; i < kMachines; ++i) {
      if (received[i].size() == text.size()) continue;
      char buffer[16'000];
      const auto result = agents[i]->machine.stream->read(buffer);
      received[i].append(buffer, result.bytes);
      if (received[i].size() < text.size()) continue;
      if (ended++ == 0)
        least_when_first_ended = std::ranges::min(received, {}, &std::string::size).size();
    }
    return ended == kMachines;
  }));
  for (const std::string& one : received) EXPECT_TRUE(one == text);
  EXPECT_GT(least_when_first_ended, text.size() * 3 / 4) << "nobody is served at the cost of another";
}

TEST(Fairness, AMachineThatTakesNothingHoldsUpNobody) {
  Shop shop;
  const std::string text = program_text(2'000'000);
  const std::string sha256 = wire::sha256_hex(text);
  std::vector<std::unique_ptr<Agent>> agents;
  for (int i = 1; i <= 3; ++i) {
    agents.push_back(std::make_unique<Agent>(shop.folder.path() / std::to_string(i)));
    auto options = agents.back()->options(shop.gateway->port());
    options.enrolment_token = shop.token_for(i);
    options.drip_buffer_bytes = 128 << 10;
    agents.back()->connect(shop.io, options);
    ASSERT_TRUE(shop.until([&] { return shop.gateway->is_connected(i); }));
    ASSERT_TRUE(shop.wait_for(shop.gateway->drip(static_cast<std::uint64_t>(i), i, "big.nc", sha256,
                                                 std::make_shared<TextBlob>(std::make_shared<const std::string>(text))))
                    .accepted);
  }
  std::string received;
  ASSERT_TRUE(shop.until([&] {
    char buffer[16'000];
    received.append(buffer, agents[2]->machine.stream->read(buffer).bytes);
    return received.size() == text.size();
  }));
  EXPECT_TRUE(received == text);
  EXPECT_LE(shop.fleet.transfers[1].bytes, 128u << 10);
}

}  // namespace
}  // namespace headstock

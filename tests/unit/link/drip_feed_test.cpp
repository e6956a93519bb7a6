// The buffer of a drip-feed between two threads.
#include "link/drip_feed.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "protocol/wire/digest.hpp"
#include "tests/unit/link/shop.hpp"

namespace headstock::link {
namespace {

using testing_support::program_text;

std::shared_ptr<DripFeed> feed_of(
    const std::string& text, std::size_t buffer, std::function<void()> wake = [] {}) {
  return DripFeed::make({1, "big.nc", text.size(), wire::sha256_hex(text)}, buffer, std::move(wake));
}

TEST(DripFeed, GrantsNoMoreThanItsBuffer) {
  const std::string text = program_text(200'000);
  const auto feed = feed_of(text, 64 << 10);
  const auto source = feed->source();
  const auto grant = feed->resume();
  ASSERT_TRUE(grant);
  EXPECT_EQ(grant->offset, 0u);
  EXPECT_EQ(grant->granted, 64u << 10);
  EXPECT_FALSE(feed->grant()) << "nothing new";
  char buffer[1000];
  EXPECT_EQ(source->read(buffer).status, program::ReadStatus::wait);
  EXPECT_TRUE(feed->append(text.substr(0, 64 << 10)));
  EXPECT_FALSE(feed->append("x")) << "never granted";
  EXPECT_EQ(source->read(buffer).status, program::ReadStatus::failed);
  EXPECT_EQ(feed->state().reason, "more_than_granted");
}

TEST(DripFeed, WrongHashAtTheEndFails) {
  const auto feed = feed_of("G0 X1\n", 64 << 10);
  const auto source = feed->source();
  feed->resume();
  EXPECT_TRUE(feed->append("G0 X9\n"));
  EXPECT_FALSE(feed->finish(6, wire::sha256_hex("G0 X1\n")));
  char buffer[100];
  EXPECT_EQ(source->read(buffer).status, program::ReadStatus::failed);
}

TEST(DripFeed, EndComesOnlyAfterTheProof) {
  const auto feed = feed_of("G0 X1\n", 64 << 10);
  auto source = feed->source();
  feed->resume();
  feed->append("G0 X1\n");
  char buffer[100];
  EXPECT_EQ(source->read(buffer).bytes, 6u);
  EXPECT_EQ(source->read(buffer).status, program::ReadStatus::wait)
      << "all bytes are here, but nobody has said so";
  EXPECT_TRUE(feed->finish(6, wire::sha256_hex("G0 X1\n")));
  EXPECT_EQ(feed->state().outcome, DripFeed::Outcome::running);
  EXPECT_EQ(source->read(buffer).status, program::ReadStatus::end);
  EXPECT_EQ(feed->state().outcome, DripFeed::Outcome::drained);
  source.reset();
  EXPECT_EQ(feed->state().outcome, DripFeed::Outcome::drained) << "closing after the end is no failure";
}

TEST(DripFeed, TwoThreadsPassEveryByteOnce) {
  const std::string text = program_text(3'000'000);
  std::atomic<int> wakes = 0;
  const auto feed = feed_of(text, 64 << 10, [&] { ++wakes; });
  auto source = feed->source();
  std::string received;
  std::thread interpreter([&, taken = std::move(source)] {
    char buffer[777];
    for (;;) {
      const auto result = taken->read(buffer);
      if (result.status == program::ReadStatus::data)
        received.append(buffer, result.bytes);
      else if (result.status == program::ReadStatus::wait)
        std::this_thread::yield();
      else
        break;
    }
  });
  std::uint64_t sent = 0, limit = feed->resume()->granted;
  while (sent < text.size()) {
    if (const auto grant = feed->grant()) limit = grant->offset + grant->granted;
    const std::size_t piece = static_cast<std::size_t>(std::min<std::uint64_t>(limit - sent, 5'000));
    ASSERT_TRUE(feed->append(std::string_view(text).substr(sent, piece)));
    sent += piece;
  }
  EXPECT_TRUE(feed->finish(text.size(), wire::sha256_hex(text)));
  interpreter.join();
  EXPECT_TRUE(received == text);
  EXPECT_EQ(feed->state().outcome, DripFeed::Outcome::drained);
  EXPECT_GT(wakes.load(), 10);
}

}  // namespace
}  // namespace headstock::link

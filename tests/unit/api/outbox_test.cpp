#include "server/api/events/hub.hpp"

#include <gtest/gtest.h>

namespace headstock::api {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

fleet::Change live(std::int64_t machine, int line, json trail = json::array()) {
  return {"live", machine, std::make_shared<const json>(json{{"machine", machine}, {"line", line}, {"trail", std::move(trail)}})};
}
fleet::Change event(const char* topic, std::int64_t machine, json body) {
  return {topic, machine, std::make_shared<const json>(std::move(body))};
}
Wishes wishing(const char* message) {
  Wishes wishes;
  EXPECT_TRUE(wishes.read(message));
  return wishes;
}
json next(Outbox& outbox, Outbox::Clock::time_point now) {
  const auto message = outbox.take(now);
  return message ? json::parse(*message) : json(nullptr);
}

TEST(Wishes, OnlyWhatWasAskedFor) {
  const auto one = wishing(R"({"subscribe":["machine:3"]})");
  EXPECT_TRUE(one.wants(live(3, 1)));
  EXPECT_FALSE(one.wants(live(4, 1)));
  EXPECT_FALSE(one.wants(event("program", 0, {})));
  const auto floor = wishing(R"({"subscribe":["floor"]})");
  EXPECT_TRUE(floor.wants(live(4, 1)));
  EXPECT_TRUE(floor.wants(event("alarm", 4, {})));
}

TEST(Wishes, NonsenseIsRefused) {
  Wishes wishes;
  for (const char* bad : {"", "[]", "{}", "{\"subscribe\":3}", "\xff", "nul"}) EXPECT_FALSE(wishes.read(bad)) << bad;
  EXPECT_TRUE(wishes.read(R"({"subscribe":["machine:x","machine:",7,"unheard-of"]})"));
  EXPECT_FALSE(wishes.any());
}

TEST(Outbox, OfAMachineTheNewestWinsAtMostFiveTimesASecond) {
  const auto floor = wishing(R"({"subscribe":["floor"]})");
  Outbox outbox;
  const Outbox::Clock::time_point start{1h};
  int sent = 0, last = 0;
  for (int ms = 0; ms <= 2000; ms += 10) {   // a hundred states a second for two seconds
    outbox.put(live(3, ms), floor);
    const auto got = next(outbox, start + std::chrono::milliseconds(ms));
    if (got.is_null()) continue;
    ++sent;
    last = got.at("live").at("line");
    EXPECT_EQ(last, ms) << "the newest";
  }
  EXPECT_EQ(sent, 11);   // at 0, 200, … 2000 ms
}

TEST(Outbox, ThePathHasNoHolesWhereStatesAreLeftOut) {
  const auto one = wishing(R"({"subscribe":["machine:3"]})");
  Outbox outbox;
  const Outbox::Clock::time_point start{1h};
  for (int i = 0; i < 4; ++i) outbox.put(live(3, i, json::array({json::array({i, i})})), one);
  const auto got = next(outbox, start);
  EXPECT_EQ(got.at("live").at("trail"), json::parse("[[0,0],[1,1],[2,2],[3,3]]"));
  EXPECT_EQ(got.at("live").at("line"), 3);
}

TEST(Outbox, TheFloorGetsNoPaths) {
  const auto floor = wishing(R"({"subscribe":["floor"]})");
  Outbox outbox;
  outbox.put(live(3, 1, json::array({1})), floor);
  EXPECT_FALSE(next(outbox, Outbox::Clock::time_point{1h}).at("live").contains("trail"));
}

TEST(Outbox, EventsKeepTheirOrderAndGoFirst) {
  const auto floor = wishing(R"({"subscribe":["floor"]})");
  Outbox outbox;
  const Outbox::Clock::time_point now{1h};
  outbox.put(live(3, 1), floor);
  outbox.put(event("alarm", 3, {{"n", 1}}), floor);
  outbox.put(event("part", 3, {{"n", 2}}), floor);
  EXPECT_EQ(next(outbox, now).at("type"), "alarm");
  EXPECT_EQ(next(outbox, now).at("type"), "part");
  EXPECT_EQ(next(outbox, now).at("type"), "live");
  EXPECT_TRUE(outbox.idle());
}

TEST(Outbox, NeverMoreThanOneMebibyte) {
  const auto floor = wishing(R"({"subscribe":["floor"]})");
  Outbox outbox;
  const json big = {{"text", std::string(100'000, 'x')}};
  int taken = 0;
  while (outbox.put(event("alarm", 3, big), floor)) {
    ASSERT_LE(outbox.bytes(), Outbox::max_bytes);
    ASSERT_LT(++taken, 100);
  }
  EXPECT_EQ(taken, 10);
  // States never fill it: one a machine, however many come.
  const auto before = outbox.bytes();
  for (int i = 0; i < 10'000; ++i) EXPECT_TRUE(outbox.put(live(i % 5, i), floor));
  EXPECT_EQ(outbox.bytes(), before);
}

TEST(Outbox, TicksAreLeftOutWhileOthersWait) {
  const auto floor = wishing(R"({"subscribe":["floor"]})");
  Outbox outbox;
  outbox.put(event("alarm", 3, {}), floor);
  outbox.put(std::make_shared<const std::string>(R"({"type":"tick"})"), Outbox::Kind::droppable);
  const Outbox::Clock::time_point now{1h};
  EXPECT_EQ(next(outbox, now).at("type"), "alarm");
  EXPECT_TRUE(next(outbox, now).is_null());
}

}  // namespace
}  // namespace headstock::api

#include "link/live_json.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace headstock::link {
namespace {

using nlohmann::json;
using namespace operation;

TEST(LiveJson, HasTheShapeOfTheApi) {
  Live live;
  live.state = State::running;
  live.mode = Mode::remote;
  live.program_name = "O1001";
  live.axes = {"X", "Z"};
  live.absolute = {20, -5};
  live.progress = 0.42;
  live.feed_override = 1.2;
  live.alarms.push_back({9, "OT0500", "over travel", "超程", {1001, 4, 0, 30, 0}, 1000});
  const json value = live_to_json(live, std::string(64, 'a'));
  EXPECT_EQ(value["state"], "running");
  EXPECT_EQ(value["mode"], "remote");
  EXPECT_EQ(value["program"]["name"], "O1001");
  EXPECT_EQ(value["absolute"], json::parse("[20.0,-5.0]"));
  EXPECT_EQ(value["overrides"]["feed"], 120.0);
  EXPECT_EQ(value["alarms"][0]["text"]["zh"], "超程");
  EXPECT_EQ(value["alarms"][0]["program"], "O1001");
  EXPECT_EQ(value["progress"], 0.42);
}

TEST(LiveJson, UnknownIsNullNeverZero) {
  Live live;
  live.progress = -1;
  live.feed_actual_mm_min = std::numeric_limits<double>::quiet_NaN();
  const json value = live_to_json(live, "");
  EXPECT_TRUE(value["progress"].is_null());
  EXPECT_TRUE(value["program"].is_null());
  EXPECT_TRUE(value["feed"]["actual_mm_min"].is_null());
  EXPECT_TRUE(value["last_cycle_s"].is_null());
  EXPECT_TRUE(value["remaining_s"].is_null());
}

TEST(LiveJson, BlocksInAnyCodePageCanBeSent) {
  Live live;
  live.block = "(\xd6\xd0\xce\xc4) G1" + std::string(1, '\0') + std::string(1 << 20, 'X');
  const json value = live_to_json(live, "");
  EXPECT_NO_THROW((void)value.dump());
  EXPECT_LT(value["block"].get<std::string>().size(), 1024u);
}

void expect_kind(Event event, const std::string& kind) {
  const NewEvent made = to_new_event({77, std::move(event)});
  EXPECT_EQ(made.kind, kind);
  EXPECT_EQ(made.at_ms, 77);
  EXPECT_TRUE(json::parse(made.body).is_object());
}

TEST(LiveJson, EveryEventHasKindAndBody) {
  ActiveAlarm alarm;
  alarm.code = "PS0010";
  OffsetChanged offset;
  offset.change.what = "work/G54/Z";
  expect_kind(PartCounted{12, 1012, "O1", "", 31.5}, "part");
  expect_kind(AlarmRaised{alarm, "G999"}, "alarm");
  expect_kind(AlarmCleared{3}, "alarm_cleared");
  expect_kind(RunStarted{1, "O1", ""}, "run_started");
  expect_kind(RunEnded{1, "completed", 2, 1}, "run_ended");
  expect_kind(StateChanged{State::hold, Mode::memory}, "state");
  expect_kind(offset, "offset");
  EXPECT_EQ(json::parse(to_new_event({0, PartCounted{12, 1012, "O1", "", 31.5}}).body)["total"], 1012);
}

TEST(LiveJson, ActionsGoBothWays) {
  for (int n = 0; n <= static_cast<int>(Action::tap_retract); ++n) {
    Action back{};
    ASSERT_TRUE(action_from_name(action_name(static_cast<Action>(n)), back));
    EXPECT_EQ(static_cast<int>(back), n);
  }
  Action unused{};
  EXPECT_FALSE(action_from_name("explode", unused));
}

}  // namespace
}  // namespace headstock::link

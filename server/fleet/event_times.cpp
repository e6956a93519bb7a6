#include "server/fleet/event_times.hpp"

#include <algorithm>
#include <cstdlib>

namespace headstock::fleet {

std::int64_t EventTimes::of(std::int64_t sequence, std::int64_t told_ms) {
  if (before_ms_ < 0)
    before_ms_ = db_.integer(
                        "SELECT at_ms FROM events WHERE machine_id = ? AND spool = ? AND sequence < ? ORDER "
                        "BY sequence DESC LIMIT 1",
                        {machine_, spool_, sequence})
                     .value_or(0);
  last_ = sequence;
  std::int64_t at_ms = told_ms > 0 ? told_ms : now_ms_;
  std::int64_t wrong_by = 0;
  if (at_ms > now_ms_ + kClockSlackMs)
    wrong_by = at_ms - now_ms_, at_ms = now_ms_;
  else if (at_ms < before_ms_ - kClockSlackMs)
    wrong_by = at_ms - before_ms_, at_ms = before_ms_;
  if (std::abs(wrong_by) > std::abs(wrong_by_ms_)) wrong_by_ms_ = wrong_by, wrong_at_ = sequence;
  before_ms_ = std::max(before_ms_, at_ms);
  return at_ms;
}

void EventTimes::tell(std::vector<db::AlarmRow>& raised, std::vector<db::AlarmRow>& cleared) {
  if (last_ == 0) return;
  const auto active = db_.integer(
      "SELECT alarm FROM alarms WHERE machine_id = ? AND spool = ? AND code = ? AND cleared_ms IS NULL",
      {machine_, spool_, kClockAlarm});
  if (wrong_by_ms_ == 0) {
    if (!active) return;
    if (const auto alarm = db::clear_alarm(db_, machine_, spool_, *active, now_ms_))
      cleared.push_back(*alarm);
    return;
  }
  if (active) return;  // the same is one event
  const std::string seconds = std::to_string(std::abs(wrong_by_ms_) / 1000);
  db::AlarmRow alarm;
  alarm.machine = machine_;
  alarm.spool = spool_;
  alarm.sequence = wrong_at_;
  alarm.alarm = -wrong_at_;  // the controller's own numbers are positive
  alarm.code = kClockAlarm;
  alarm.text_en = wrong_by_ms_ > 0 ? "The machine's clock is " + seconds + " s ahead of the server's"
                                   : "The machine's clock went back by " + seconds + " s";
  alarm.text_zh =
      wrong_by_ms_ > 0 ? "机床时钟比服务器快 " + seconds + " 秒" : "机床时钟倒退了 " + seconds + " 秒";
  alarm.raised_ms = now_ms_;
  alarm.id = db::insert_alarm(db_, alarm);
  raised.push_back(std::move(alarm));
}

}  // namespace headstock::fleet

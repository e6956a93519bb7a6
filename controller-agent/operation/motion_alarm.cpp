#include "operation/motion_alarm.hpp"

#include <algorithm>
#include <cmath>

#include "operation/path_length.hpp"

namespace headstock::operation {
namespace {

constexpr MachineAlarm kTooFast{"HS0003", "Thread: lead × spindle speed is above the feed of an axis",
                                "螺纹：螺距×主轴转速超过轴的最大进给速度"};
constexpr MachineAlarm kTooShort{"HS0004", "Thread: too short to reach its lead at this spindle speed",
                                 "螺纹：长度不足以在此主轴转速下达到规定螺距"};

}  // namespace

std::optional<MachineAlarm> thread_alarm(const machine::Machine& machine, const machine::AxisVector& start,
                                         const motion::Move& move, const motion::ThreadFeed& thread,
                                         double rpm) {
  const machine::AxisVector& end = end_of(move);
  double longest = 0;
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    longest = std::max(longest, std::abs(end[i] - start[i]));
  if (longest <= 0 || rpm <= 0) return std::nullopt;
  // Variable lead: the last turn is the longest or the first is. lead² grows evenly with the length.
  const double last_square = thread.lead_mm * thread.lead_mm + 2 * thread.lead_change_mm * longest;
  const double lead = std::max(thread.lead_mm, std::sqrt(std::max(0.0, last_square)));
  const double turns_s = rpm / 60;
  double run_up = 0;
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const machine::Axis& axis = machine.axes[i];
    const double share = std::abs(end[i] - start[i]) / longest;
    if (share * lead * turns_s * 60 > axis.max_feed_mm_min * (1 + 1e-9)) return kTooFast;
    const double speed = share * thread.lead_mm * turns_s;
    if (share > 0) run_up = std::max(run_up, speed * speed / (2 * axis.max_acceleration_mm_s2) / share);
  }
  return run_up > longest ? std::optional(kTooShort) : std::nullopt;
}

MachineAlarm zone_alarm(bool positive) {
  return positive ? MachineAlarm{"OT0502", "+ overtravel (soft limit 2)", "正向超程（软限位 2）"}
                  : MachineAlarm{"OT0503", "- overtravel (soft limit 2)", "负向超程（软限位 2）"};
}

}  // namespace headstock::operation

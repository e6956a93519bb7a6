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
                                         double rpm, double run_up_mm, double bell_s) {
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
    if (share > 0)
      run_up = std::max(run_up, (speed * speed / (2 * axis.max_acceleration_mm_s2) + speed * bell_s / 2) / share);
  }
  if (move.speed_up_mm_s2 > 0) {
    const double speed = thread.lead_mm * turns_s, along = path_length(start, move) / longest;
    run_up = std::max(run_up, speed * speed * along / (2 * move.speed_up_mm_s2) + speed * bell_s / 2);
  }
  return run_up > std::max(longest, run_up_mm) ? std::optional(kTooShort) : std::nullopt;
}

MachineAlarm zone_alarm(std::size_t check, bool positive) {
  if (check == 2)
    return positive ? MachineAlarm{"OT0502", "+ overtravel (soft limit 2)", "正向超程（软限位 2）"}
                    : MachineAlarm{"OT0503", "- overtravel (soft limit 2)", "负向超程（软限位 2）"};
  return positive ? MachineAlarm{"OT0504", "+ overtravel (soft limit 3)", "正向超程（软限位 3）"}
                  : MachineAlarm{"OT0505", "- overtravel (soft limit 3)", "负向超程（软限位 3）"};
}

MachineAlarm before_move_alarm(bool positive) {
  return positive ? MachineAlarm{"OT0510", "+ overtravel (before move)", "正向超程（移动前检查）"}
                  : MachineAlarm{"OT0511", "- overtravel (before move)", "负向超程（移动前检查）"};
}

namespace {

enum class Refusal : std::uint8_t { not_homed, slave, ladder, not_contour, tap_speed, tap_feed };
struct Row {
  std::string_view profile;  // beginning of the profile's name; empty: every other
  Refusal refusal;
  MachineAlarm alarm;
};
constexpr Row kRefusals[] = {
    {"fanuc", Refusal::not_homed, {"PS0224", "Return to reference point", "请返回参考点"}},
    {"gsk-2000tc",
     Refusal::not_homed,
     {"225", "Reference return needed before motion", "未回参考点，不能移动"}},
    {"", Refusal::not_homed, {"HS0025", "Reference return needed before motion", "未回参考点，不能移动"}},
    {"fanuc", Refusal::slave, {"PS0213", "Illegal command in synchro-mode", "同步方式中的非法指令"}},
    {"",
     Refusal::slave,
     {"HS0026", "A synchronous axis is not commanded by itself", "同步从动轴不能单独指令"}},
    {"fanuc", Refusal::ladder, {"PS0130", "NC and PMC axis conflict", "NC 轴与 PMC 轴冲突"}},
    {"", Refusal::ladder, {"HS0027", "This axis is moved by the ladder", "该轴由梯形图控制"}},
    {"fanuc", Refusal::not_contour, {"PS0197", "C-axis commanded in spindle mode", "主轴方式中指令了 C 轴"}},
    {"",
     Refusal::not_contour,
     {"HS0028", "C axis commanded while the spindle is under speed control", "主轴速度方式中指令了 C 轴"}},
    {"fanuc", Refusal::tap_speed, {"PS0200", "Illegal S code command", "S 代码指令非法"}},
    {"gsk-2000tc", Refusal::tap_speed, {"182", "S above the maximum of tapping", "S 超过攻丝最高转速"}},
    {"",
     Refusal::tap_speed,
     {"HS0029", "Tapping: spindle speed missing or above what it can do", "攻丝：主轴转速未指令或超过上限"}},
    {"gsk-2000tc",
     Refusal::tap_feed,
     {"011", "Tapping: F x S above the cutting feed", "攻丝：F×S 超过切削进给上限"}},
    {"k2000tc", Refusal::tap_feed, {"SV3", "Command rate too high", "指令脉冲频率过高"}},
    {"",
     Refusal::tap_feed,
     {"HS0003", "Lead times speed is above the feed of the axis", "螺距与转速之积超过轴的进给上限"}},
};

MachineAlarm refusal(const machine::Machine& machine, Refusal what) {
  for (const Row& row : kRefusals)
    if (row.refusal == what && std::string_view(machine.profile).starts_with(row.profile)) return row.alarm;
  return {};
}

}  // namespace

std::optional<MachineAlarm> axis_alarm(const machine::Machine& machine, std::size_t axis, bool homed,
                                       bool contour) {
  const machine::Axis& data = machine.axes[axis];
  if (data.follows != 0) return refusal(machine, Refusal::slave);
  if (data.plc) return refusal(machine, Refusal::ladder);
  if (!homed) return refusal(machine, Refusal::not_homed);
  if (data.name == machine.spindle.contour_axis && !contour) return refusal(machine, Refusal::not_contour);
  return std::nullopt;
}

std::optional<MachineAlarm> tap_alarm(const machine::Machine& machine, std::size_t axis, double pitch_mm,
                                      double rpm, bool rigid) {
  const machine::Spindle& spindle = machine.spindle;
  const double most =
      rigid && spindle.tap_rpm > 0 ? std::min(spindle.tap_rpm, spindle.max_rpm) : spindle.max_rpm;
  if (!(rpm > 0) || rpm > most * (1 + 1e-9)) return refusal(machine, Refusal::tap_speed);
  if (!(pitch_mm > 0) || rpm * pitch_mm > machine.axes[axis].max_feed_mm_min * (1 + 1e-9))
    return refusal(machine, Refusal::tap_feed);
  return std::nullopt;
}

MachineAlarm dry_run_alarm() {
  return {"PS5009", "Feed zero (dry run)", "进给速度为零（空运行）"};
}

MachineAlarm homing_alarm() {
  return {"PS0090", "Reference return incomplete: too fast for the dog", "返回参考点未完成：减速挡块过短"};
}

MachineAlarm polygon_alarm() {
  return {"PS5018", "Polygon spindle speed error", "多边形主轴速度错误"};
}

MachineAlarm acceleration_message() {
  return {"HS0031", "Acceleration by these parameters is not done as they say; instead",
          "下列参数要求的加减速方式未实现，改为"};
}

MachineAlarm tap_across_alarm() {
  return {"HS0030", "A tap moves along one axis only", "攻丝只能沿一个轴"};
}

}  // namespace headstock::operation

#include "operation/overtravel_alarm.hpp"

namespace headstock::operation {
namespace {

struct Row {
  std::string_view profile;  // beginning of the profile's name
  char axis;                 // 0: every axis
  std::string_view plus, minus;
};
// FANUC: 0i-D appendix, L73420. GSK 218T: L6954; 2000TC takes the numbers of its family. K2000TC prints
// FANUC's numbers [its manual gives none]. 200T has one limit alarm for all (L8225).
constexpr Row kRows[] = {
    {"fanuc-0i", 0, "OT0500", "OT0501"}, {"gsk-", 'X', "201", "202"},     {"gsk-", 'Z', "203", "204"},
    {"gsk-", 0, "205", "206"},           {"lathe-200t", 0, "A10", "A10"}, {"", 0, "OT0500", "OT0501"},
};

}  // namespace

MachineAlarm overtravel_alarm(std::string_view profile, char axis, bool positive) {
  for (const Row& row : kRows) {
    if (!profile.starts_with(row.profile) || (row.axis != 0 && row.axis != axis)) continue;
    return positive ? MachineAlarm{row.plus, "+ overtravel (soft limit 1)", "正向超程（软限位 1）"}
                    : MachineAlarm{row.minus, "- overtravel (soft limit 1)", "负向超程（软限位 1）"};
  }
  return {};
}

MachineAlarm starved_message() {
  return {"DNC", "Program data ran out: feed hold. Cycle start goes on when data are there",
          "程序数据中断：已进给保持，数据到达后按循环启动继续"};
}

MachineAlarm port_code_alarm() {
  return {"HS0010", "This machine cannot carry out an M code that waits for an input, a delay or a position",
          "本机不能执行等待输入、延时或按位置动作的 M 代码"};
}

MachineAlarm tool_life_message() {
  return {"TLCH", "Tool life: the last tool of a group is spent. New tools are needed",
          "刀具寿命：组内最后一把刀具寿命已到，需要更换刀具"};
}

}  // namespace headstock::operation

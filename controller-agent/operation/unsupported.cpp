#include "operation/unsupported.hpp"

#include <variant>

namespace headstock::operation {
namespace {

constexpr MachineAlarm kSkip{"HS0002", "Skip move: this machine has no skip input",
                             "跳转指令：本机没有跳转信号输入"};
constexpr MachineAlarm kAuxiliary{"HS0002", "Second auxiliary function is not wired on this machine",
                                  "本机没有连接第二辅助功能"};
constexpr MachineAlarm kDrivenTap{"HS0002", "Synchronous tapping with a driven tool: only the main spindle is synchronised",
                                  "动力刀具同步攻丝：本机只同步主轴"};

constexpr MachineAlarm kPolygon{"HS0002", "Polygon turning: this machine has no driven tool axis",
                                "本机没有多边形车削的刀具轴"};

}  // namespace

std::optional<MachineAlarm> unsupported_alarm(const interp::Operation& operation,
                                              const machine::Machine& machine, bool skip_input) {
  if (const auto* feed = std::get_if<interp::Feed>(&operation); feed != nullptr && feed->skip_signals != 0) {
    const bool torque = (feed->skip_signals & interp::kSkipTorque) != 0;  // no drive reports its torque yet
    if (!skip_input || torque) return kSkip;
  }
  if (const auto* polygon = std::get_if<interp::PolygonTurning>(&operation);
      polygon != nullptr && polygon->on && machine.polygon_axis == 0)
    return kPolygon;
  if (const auto* tap = std::get_if<interp::Tap>(&operation); tap != nullptr && tap->spindle != 0) return kDrivenTap;
  if (std::holds_alternative<interp::SecondAuxiliary>(operation) && !machine.second_auxiliary)
    return kAuxiliary;
  return std::nullopt;
}

MachineAlarm interruption_alarm() {
  return {"HS0002", "Interruption macro (M96): this machine has no interruption signal", "中断宏程序 (M96)：本机没有中断信号"};
}

}  // namespace headstock::operation

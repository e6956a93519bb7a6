#include "operation/unsupported.hpp"

#include <variant>

namespace headstock::operation {
namespace {

constexpr MachineAlarm kSkip{"HS0002", "Skip move: this machine has no skip input",
                             "跳转指令：本机没有跳转信号输入"};
constexpr MachineAlarm kStroke{"HS0002", "Stored stroke check 2 is not supervised by this machine",
                               "本机不监控存储行程检查 2"};
constexpr MachineAlarm kWatch{"HS0002", "Spindle speed fluctuation is not supervised by this machine",
                              "本机不监控主轴速度波动"};
constexpr MachineAlarm kAuxiliary{"HS0002", "Second auxiliary function is not wired on this machine",
                                  "本机没有连接第二辅助功能"};

constexpr MachineAlarm kPolygon{"HS0002", "Polygon turning: this machine has no driven tool axis",
                                "本机没有多边形车削的刀具轴"};

}  // namespace

std::optional<MachineAlarm> unsupported_alarm(const interp::Operation& operation) {
  if (const auto* feed = std::get_if<interp::Feed>(&operation); feed != nullptr && feed->skip_signals != 0)
    return kSkip;
  if (const auto* zone = std::get_if<interp::StrokeCheck>(&operation);
      zone != nullptr && zone->on && zone->axes != 0)
    return kStroke;
  if (const auto* watch = std::get_if<interp::SpindleWatch>(&operation); watch != nullptr && watch->on)
    return kWatch;
  if (const auto* polygon = std::get_if<interp::PolygonTurning>(&operation);
      polygon != nullptr && polygon->on)
    return kPolygon;
  if (std::holds_alternative<interp::SecondAuxiliary>(operation)) return kAuxiliary;
  return std::nullopt;
}

}  // namespace headstock::operation

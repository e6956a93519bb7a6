#include "operation/input_alarm.hpp"

namespace headstock::operation {
namespace {

struct Row {
  std::string_view profile;  // beginning of the profile's name
  std::string_view fault;    // empty: every one that the rows before do not name
  std::string_view code, en, zh;
};
// FANUC 0i-D appendix G: L71364-L71369 (TH, TV), L71750-L71763 (reader/punch interface 1), L72839 (framing).
// GSK print 032 for everything on the line (L6870). K2000TC takes FANUC's numbers [its manual has no line].
// 200T has no DNC mode and no number: HS codes.
constexpr Row kRows[] = {
    {"", "no_start_mark", "HS0041", "What came in does not begin with %: not a program from its beginning",
     "输入内容不以 % 开头：不是从头开始的程序"},
    {"fanuc-0i", "th", "PS0001", "TH error", "TH 校验错误"},
    {"fanuc-0i", "tv", "PS0002", "TV check error", "TV 校验错误"},
    {"fanuc-0i", "buffer_overflow", "PS0087", "Buffer overflow", "缓冲区溢出"},
    {"fanuc-0i", "line_framing", "PS1823", "Framing error (1)", "帧错误（1）"},
    {"fanuc-0i", "dr_off", "PS0086", "DR off", "DR 信号断开"},
    {"fanuc-0i", "disconnected", "PS0086", "DR off", "DR 信号断开"},
    {"fanuc-0i", "", "PS0085", "Communication error", "通信错误"},
    {"gsk-", "", "032", "Communication error", "通信错误"},
    {"k2000tc", "th", "PS0001", "TH error", "TH 校验错误"},
    {"k2000tc", "tv", "PS0002", "TV check error", "TV 校验错误"},
    {"k2000tc", "buffer_overflow", "PS0087", "Buffer overflow", "缓冲区溢出"},
    {"k2000tc", "disconnected", "PS0086", "Input device not ready", "输入设备未就绪"},
    {"k2000tc", "", "PS0085", "Communication error", "通信错误"},
    {"", "", "HS0040", "Communication error on the line that feeds the program", "程序输入线路通信错误"},
};

constexpr std::string_view kFaults[] = {"line_parity",  "line_framing", "line_overrun",    "line_break",
                                        "disconnected", "dr_off",       "buffer_overflow", "th",
                                        "tv",           "no_start_mark"};

}  // namespace

MachineAlarm input_alarm(std::string_view profile, std::string_view fault) {
  bool of_the_line = false;
  for (const std::string_view known : kFaults) of_the_line |= known == fault;
  if (!of_the_line) return {};
  for (const Row& row : kRows)
    if (profile.starts_with(row.profile) && (row.fault.empty() || row.fault == fault))
      return {row.code, row.en, row.zh};
  return {};
}

}  // namespace headstock::operation

#include "command-line/client/output.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iterator>

#include <nlohmann/json.hpp>

namespace headstock::client {

namespace {

bool use_chinese = false;

char32_t next_code_point(std::string_view text, std::size_t& at) {
  const auto byte = static_cast<unsigned char>(text[at++]);
  const int more = byte >= 0xF0 ? 3 : byte >= 0xE0 ? 2 : byte >= 0xC0 ? 1 : 0;
  char32_t point = more == 3 ? byte & 7u : more == 2 ? byte & 15u : more == 1 ? byte & 31u : byte;
  for (int i = 0; i < more && at < text.size(); ++i) point = (point << 6) | (static_cast<unsigned char>(text[at++]) & 63u);
  return point;
}

bool is_wide(char32_t c) {
  return (c >= 0x1100 && c <= 0x115F) || (c >= 0x2E80 && c <= 0xA4CF) || (c >= 0xAC00 && c <= 0xD7A3) ||
         (c >= 0xF900 && c <= 0xFAFF) || (c >= 0xFE30 && c <= 0xFE6F) || (c >= 0xFF00 && c <= 0xFF60);
}

}  // namespace

void choose_language(const std::string& wanted) {
  std::string language = wanted;
  for (const char* name : {"LC_ALL", "LC_MESSAGES", "LANG"}) {
    if (!language.empty()) break;
    if (const char* value = std::getenv(name)) language = value;
  }
  use_chinese = language.starts_with("zh");
}

bool chinese() { return use_chinese; }

std::string say(std::string_view en, std::string_view zh) { return std::string(use_chinese ? zh : en); }

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  for (std::size_t at = 0; at < text.size();) width += is_wide(next_code_point(text, at)) ? 2 : 1;
  return width;
}

std::string table(const Line& heads, const std::vector<Line>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& head : heads) widths.push_back(display_width(head));
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size() && i < widths.size(); ++i) widths[i] = std::max(widths[i], display_width(row[i]));
  std::string out;
  const auto add = [&](const Line& row) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      out += row[i];
      if (i + 1 < row.size()) out.append(widths[i] - display_width(row[i]) + 2, ' ');
    }
    out += '\n';
  };
  add(heads);
  for (const auto& row : rows) add(row);
  return out;
}

std::string cell(const nlohmann::json& value) {
  if (value.is_null()) return "–";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? say("yes", "是") : say("no", "否");
  return value.dump();
}

std::string text_of(const nlohmann::json& both) {
  if (!both.is_object()) return cell(both);
  return both.value(use_chinese ? "zh" : "en", std::string());
}

std::string local_time(const nlohmann::json& iso) {
  if (!iso.is_string()) return "–";
  const auto text = iso.get<std::string>();
  std::tm parts{};
  if (std::sscanf(text.c_str(), "%d-%d-%dT%d:%d:%d", &parts.tm_year, &parts.tm_mon, &parts.tm_mday, &parts.tm_hour,
                  &parts.tm_min, &parts.tm_sec) != 6)
    return text;
  parts.tm_year -= 1900;
  parts.tm_mon -= 1;
  const std::time_t time = timegm(&parts);
  std::tm local{};
  localtime_r(&time, &local);
  std::array<char, 32> out{};
  std::strftime(out.data(), out.size(), "%Y-%m-%d %H:%M:%S", &local);
  return out.data();
}

std::string duration(const nlohmann::json& seconds) {
  if (!seconds.is_number()) return "–";
  const auto total = static_cast<long>(std::lround(seconds.get<double>()));
  std::array<char, 64> out{};
  if (total >= 3600)
    std::snprintf(out.data(), out.size(), "%ld h %02ld min %02ld s", total / 3600, total / 60 % 60, total % 60);
  else if (total >= 60)
    std::snprintf(out.data(), out.size(), "%ld min %02ld s", total / 60, total % 60);
  else
    std::snprintf(out.data(), out.size(), "%.1f s", seconds.get<double>());
  return out.data();
}

std::string state_word(const std::string& state) {
  struct Word {
    std::string_view state, en, zh;
  };
  static constexpr std::array<Word, 9> words = {{{"running", "running", "运行"},
                                                 {"hold", "feed hold", "进给保持"},
                                                 {"stopped", "stopped", "停止"},
                                                 {"idle", "idle", "空闲"},
                                                 {"alarm", "alarm", "报警"},
                                                 {"emergency_stop", "emergency stop", "急停"},
                                                 {"setup", "setup", "调整"},
                                                 {"off", "off", "关机"},
                                                 {"unknown", "unknown", "未知"}}};
  for (const auto& word : words)
    if (word.state == state) return say(word.en, word.zh);
  return state;
}

}  // namespace headstock::client

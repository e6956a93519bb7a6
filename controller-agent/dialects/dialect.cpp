#include "dialects/dialect.hpp"

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "dialects/build.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::dialects {
namespace {

[[noreturn]] void broken_table(const Dialect& dialect, std::string_view what) {
  std::fprintf(stderr, "%s/gcodes.tsv: %s\n", std::string(dialect.profile).c_str(),
               std::string(what).c_str());
  std::abort();
}

// "G54.1" → 541.
std::int16_t tenths_of(std::string_view code) {
  int whole = 0;
  const char* end = code.data() + code.size();
  const auto [point, error] = std::from_chars(code.data() + 1, end, whole);
  int tenth = 0;
  if (error != std::errc() || (point != end && std::from_chars(point + 1, end, tenth).ptr != end)) return -1;
  return static_cast<std::int16_t>(whole * 10 + tenth);
}

}  // namespace

void GTable::add(const GCode& code) {
  if (code.tenths < 0 || code.tenths >= kCodes || rows_.size() >= 255) std::abort();
  rows_.push_back(code);
  index_[static_cast<std::size_t>(code.tenths)] = static_cast<std::uint8_t>(rows_.size());
}

void add_g_codes(Dialect& dialect, std::span<const GRow> rows, std::span<const OwnHandler> own) {
  for (const GRow& row : rows) {
    GCode code;
    int group = 0;
    std::from_chars(row[3].data(), row[3].data() + row[3].size(), group);
    if (group < 0 || group >= 32) broken_table(dialect, row[3]);
    code.group = static_cast<std::uint8_t>(group);
    code.power_on = row[4] == "y";
    bool found = row[5] == "unavailable";
    for (const OwnHandler& handler : own) {
      if (handler.name != row[5]) continue;
      code.phase = handler.phase;
      code.handler = handler.handler;
      found = true;
    }
    if (const auto* common = interp::handlers::find(row[5]); !found && common != nullptr) {
      code.phase = common->phase;
      code.handler = common->handler;
      found = true;
    }
    if (!found) broken_table(dialect, row[5]);
    for (std::size_t system = 0; system < 3; ++system) {
      std::string_view names = row[system];
      if (names == "-") continue;
      code.name = names.substr(0, names.find('|'));
      bool alias = false;
      while (!names.empty()) {
        const std::string_view one = names.substr(0, names.find('|'));
        names.remove_prefix(std::min(names.size(), one.size() + 1));
        code.tenths = tenths_of(one);
        GCode entry = code;
        entry.power_on = code.power_on && !alias;
        dialect.systems[system].add(entry);
        alias = true;
      }
    }
  }
}

void set_alarm_codes(Dialect& dialect, std::string_view otherwise,
                     std::initializer_list<std::pair<AlarmReason, std::string_view>> codes) {
  dialect.alarm_codes.fill(otherwise);
  dialect.alarm_codes[static_cast<std::size_t>(AlarmReason::endless_loop)] = "HS0001";  // ours: see README
  for (const auto& [reason, code] : codes) dialect.alarm_codes[static_cast<std::size_t>(reason)] = code;
}

std::vector<MRule> usual_m_rules() {
  return {{0, MAction::program_stop}, {1, MAction::optional_stop}, {2, MAction::end_m02},
          {30, MAction::end_m30},     {3, MAction::spindle_cw},    {4, MAction::spindle_ccw},
          {5, MAction::spindle_stop}, {9, MAction::machine_after}, {98, MAction::call},
          {99, MAction::return_}};
}

namespace {

constexpr std::string_view kProfiles[] = {"fanuc-0i-t", "fanuc-0i-m", "gsk-2000tc",
                                          "gsk-218t",   "k2000tc",    "lathe-200t"};

}  // namespace

std::span<const std::string_view> dialect_names() {
  return kProfiles;
}

const Dialect* find(std::string_view profile) {
  static const std::array<Dialect, std::size(kProfiles)> dialects = [] {
    std::array<Dialect, std::size(kProfiles)> made = {make_fanuc_0i_t(), make_fanuc_0i_m(), make_gsk_2000tc(),
                                                      make_gsk_218t(),   make_k2000tc(),    make_lathe_200t()};
    for (Dialect& dialect : made) set_path_rules(dialect);
    return made;
  }();
  for (const Dialect& dialect : dialects) {
    if (dialect.profile == profile) return &dialect;
  }
  return nullptr;
}

}  // namespace headstock::dialects

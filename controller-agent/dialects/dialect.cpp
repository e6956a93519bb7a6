#include "dialects/dialect.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "cycles/handlers.hpp"
#include "dialects/build.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::dialects {
namespace {

[[noreturn]] void broken_table(const Dialect& dialect, std::string_view what) {
  std::fprintf(stderr, "%s/gcodes.tsv: %s\n", std::string(dialect.profile).c_str(),
               std::string(what).c_str());
  std::abort();
}

using R = AlarmReason;

// Reasons that only some controls print a number of their own for, and whose number the others print.
constexpr std::pair<R, R> kFinerReasons[] = {
    {AlarmReason::spindle_reversed, AlarmReason::illegal_m},
    {AlarmReason::spindle_gear, AlarmReason::value_range},
    {AlarmReason::surface_speed_gear, AlarmReason::value_range},
    {AlarmReason::gear_change, AlarmReason::illegal_m},
    {AlarmReason::life_format, AlarmReason::data_input},
    {AlarmReason::life_group_number, AlarmReason::data_input},
    {AlarmReason::life_group_missing, AlarmReason::offset_number},
    {AlarmReason::life_too_many_tools, AlarmReason::data_input},
    {AlarmReason::life_no_t, AlarmReason::data_input},
    {AlarmReason::life_not_in_use, AlarmReason::offset_number},
    {AlarmReason::life_wrong_t, AlarmReason::offset_number},
    {AlarmReason::life_no_p_l, AlarmReason::data_input},
    {AlarmReason::life_too_many_groups, AlarmReason::data_input},
    {AlarmReason::life_value, AlarmReason::data_value},
    {AlarmReason::life_data, AlarmReason::offset_number},
    {R::g_not_now, R::illegal_g},
    {R::scale_value, R::value_range},
    {R::scaling_code, R::illegal_g},
    {R::rotation_plane, R::arc_plane},
    {R::polar_axis, R::arc_plane},
    {R::polar_code, R::illegal_g},
    {R::cylinder_axis, R::arc_plane},
    {R::cylinder_code, R::illegal_g},
    {R::skip_not_allowed, R::illegal_g},
    {R::skip_format, R::value_range},
    {R::skip_number, R::value_range},
    {R::unit_change, R::illegal_g},
    {R::unit_change_place, R::illegal_g},
    {R::increment_limit, R::value_range},
    {R::look_ahead_format, R::value_range},
    {R::data_number, R::data_input},
    {R::parameter_format, R::data_input},
    {R::parameter_word_missing, R::data_input},
    {R::parameter_number, R::data_input},
    {R::parameter_axis, R::data_input},
    {R::parameter_axis_missing, R::data_input},
    {R::parameter_no_axis, R::data_input},
    {R::parameter_range, R::data_input},
    {R::parameter_sign, R::minus_sign},
    {R::surface_axis, R::value_range},
    {R::helix_axes, R::arc_plane},
    {R::arc_foreign_axis, R::arc_plane},
    {R::arc_in_rapid, R::feed_missing},
    {R::thread_lead_change, R::thread_lead},
    {R::setting_with_length, R::illegal_g},
    {R::too_many_axes, R::illegal_address},
    {R::single_direction_axis, R::illegal_address},
    {R::spindle_number, R::value_range},
    {R::polygon_again, R::illegal_g},
    {R::polygon_words, R::value_range},
    {R::polygon_alone, R::stand_alone},
    {R::polygon_axis, R::illegal_g},
    {R::m_combination, R::too_many_m},
    {R::position_overflow, R::value_range},
    {R::arc_increments, R::arc_plane},
    {R::h_code, R::value_range},
    {R::h_target, R::value_range},
    {R::h_operand, R::value_range},
    {R::mdi_jump, R::macro_dnc},
    {R::mdi_compensation, R::compensation_refused},
    {R::mdi_cycle, R::stand_alone},
    {R::external_in_mdi, R::external_not_found},
    {R::external_in_dnc, R::external_not_found},
    {R::interrupted_cycle, R::g_not_now},
    {R::interrupted_transform, R::g_not_now},
    {R::too_many_words, R::too_many_m},
    {R::macro_word_unknown, R::macro_syntax},
    {R::call_in_hole_cycle, R::macro_with_words},
    {R::arc_r_too_large, R::value_range},
    {R::surface_speed_zero, R::value_range},
    {R::computed_number, R::program_number},
    {R::call_p_value, R::call_count},
    {R::number_place, R::expression},
    {R::offset_name, R::macro_no_name},
    {R::transform_overflow, R::position_overflow},
    {R::compensated_overflow, R::position_overflow},
};

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
    if (const auto* cycle = cycles::find(row[5]); !found && cycle != nullptr) {
      code.phase = cycle->phase;
      code.handler = cycle->handler;
      code.cycle = found = true;
      code.lead = cycles::f_is_lead(cycle->handler);
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
  const auto given = [&codes](AlarmReason reason) {
    return std::any_of(codes.begin(), codes.end(),
                       [reason](const auto& code) { return code.first == reason; });
  };
  for (const auto& [fine, coarse] : kFinerReasons) {
    if (!given(fine)) dialect.set_alarm_code(fine, dialect.alarm_code(coarse));
  }
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
    std::array<Dialect, std::size(kProfiles)> made = {make_fanuc_0i_t(), make_fanuc_0i_m(),
                                                      make_gsk_2000tc(), make_gsk_218t(),
                                                      make_k2000tc(),    make_lathe_200t()};
    for (Dialect& dialect : made) set_path_rules(dialect);
    return made;
  }();
  for (const Dialect& dialect : dialects) {
    if (dialect.profile == profile) return &dialect;
  }
  return nullptr;
}

}  // namespace headstock::dialects

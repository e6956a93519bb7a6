#include "dialects/data_rules.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "dialects/catalogue.hpp"

namespace headstock::dialects {
namespace {

using interp::MachineData;
using interp::ValueKind;

/// What differs between the profiles. Parameter numbers as in dialects/*/parameters.tsv; empty: there is
/// none.
struct Rules {
  std::string_view profile;
  double largest_mm, largest_radius_mm;
  std::string_view fewer_numbers = {};  ///< bit: only `few` offset numbers (0i-D 8136#5)
  std::size_t few = 0;
  std::string_view no_wear = {};            ///< bit: no geometry/wear memory (0i-D 8136#6)
  std::string_view coarse = {}, fine = {};  ///< bits that move the decimal point of offsets (0i-D 5042#0, #1)
  std::string_view largest_wear = {};       ///< K2000TC P3220
  std::string_view wear_step = {};          ///< GSK 2000TC P140: of one input
  double default_wear_step = 0;
  std::string_view locked_from = {}, locked_count = {};     ///< offset numbers (GSK 2000TC P093, P094)
  std::string_view variables_from = {}, variables_to = {};  ///< protected common variables (0i-D 6031, 6032)
  bool while_running = false;  ///< lathe T and mill H take a new value at their next command (0i-D 5001#6)
  int extra_systems = 0, work_systems = 6;
  std::uint32_t first_variable = 100, last_volatile = 199, first_kept = 500, last_kept = 999;
};

/// @param few offset numbers while No. 8136#5 says fewer
constexpr Rules fanuc_0i(std::string_view profile, std::uint32_t few, int extra_systems) {
  return {.profile = profile,
          .largest_mm = 9'999.999,
          .largest_radius_mm = 9'999.999,
          .fewer_numbers = "8136#5",
          .few = few,
          .no_wear = "8136#6",
          .coarse = "5042#0",
          .fine = "5042#1",
          .variables_from = "6031",
          .variables_to = "6032",
          .while_running = true,
          .extra_systems = extra_systems};
}

constexpr Rules kRules[] = {
    fanuc_0i("fanuc-0i-t", 64, 0),
    fanuc_0i("fanuc-0i-m", 200, 48),
    {.profile = "gsk-2000tc",
     .largest_mm = 9'999.9999,
     .largest_radius_mm = 9'999.9999,
     .wear_step = "P140",
     .default_wear_step = 1,
     .locked_from = "P093",
     .locked_count = "P094"},
    // L3463: no change while a program runs.
    {.profile = "gsk-218t", .largest_mm = 9'999.999, .largest_radius_mm = 9'999.999, .last_kept = 531},
    {.profile = "k2000tc", .largest_mm = 10'000, .largest_radius_mm = 100, .largest_wear = "P3220"},
    {.profile = "lathe-200t",
     .largest_mm = 9'999.999,
     .largest_radius_mm = 9'999.999,
     .work_systems = 0,
     .first_variable = 200,
     .last_volatile = 229,
     .first_kept = 200,
     .last_kept = 209},
};

const Rules& rules_of(const Dialect& dialect) {
  const auto* found = std::ranges::find(kRules, dialect.profile, &Rules::profile);
  static constexpr Rules kOther{.profile = "", .largest_mm = 9'999.999, .largest_radius_mm = 9'999.999};
  return found != std::end(kRules) ? *found : kOther;
}

std::string refuse_tool(const Dialect& dialect, const MachineData& data, std::string_view what, double before,
                        double value) {
  const Rules& rules = rules_of(dialect);
  const OffsetPage page = offset_page(dialect, data);
  const std::uint32_t number = interp::number_of_value(what);
  const std::string_view field = interp::field_of_value(what);
  if (number == 0 || number > page.numbers) return "bad_place";
  const bool wear = field == "wear" || field == "radius_wear";
  if (wear && !page.wear) return "bad_place";
  if (!page.lathe) {
    const bool length = what.ends_with("/Z") && (field == "geometry" || field == "wear");
    const bool radius = field == "radius" || field == "radius_wear";
    if (!length && !(radius && page.memory == 'C')) return "bad_place";
  }
  const auto locked_from = static_cast<std::uint32_t>(std::max(0.0, data.parameter(rules.locked_from)));
  const auto locked = static_cast<std::uint32_t>(std::max(0.0, data.parameter(rules.locked_count)));
  if (locked != 0 && number >= locked_from && number - locked_from < locked) return "locked";
  if (field == "tip")
    return value == std::floor(value) && value >= 0 && value <= page.tips ? "" : "out_of_range";
  const double most = wear                ? page.largest_wear_mm
                      : field == "radius" ? std::min(rules.largest_radius_mm, page.largest_mm)
                                          : page.largest_mm;
  if (!(std::fabs(value) <= most)) return "out_of_range";
  if (wear && !rules.wear_step.empty()) {
    const double step = data.parameter(rules.wear_step, rules.default_wear_step);
    if (step > 0 && std::fabs(value - before) > step + 1e-9) return "wear_step";
  }
  return {};
}

std::string refuse_variable(const Dialect& dialect, const MachineData& data, std::uint32_t number,
                            std::optional<double> value) {
  const Rules& rules = rules_of(dialect);
  const bool kept = number >= rules.first_kept && number <= rules.last_kept;
  if (!kept && !(number >= rules.first_variable && number <= rules.last_volatile)) return "bad_place";
  const double from = data.parameter(rules.variables_from), to = data.parameter(rules.variables_to);
  if (from > 0 && number >= from && number <= to) return "locked";
  if (value && !(std::fabs(*value) <= 1e12)) return "out_of_range";
  return {};
}

std::string refuse_parameter(const Dialect& dialect, const MachineData& data, std::string_view what,
                             std::optional<double> value) {
  std::string_view key = what.substr(std::string_view("parameter/").size());
  const bool was_set = data.parameters.contains(key);
  Parameter row;
  if (!find_parameter(dialect.profile, key, row) &&
      !find_parameter(dialect.profile, key.substr(0, key.rfind('/')), row))
    return was_set ? "" : "bad_place";
  if (!value) return {};
  if (key.find('#') != key.npos && *value != 0 && *value != 1) return "out_of_range";
  if (const auto range = parameter_range(row.range);
      range && !(*value >= range->least && *value <= range->most))
    return "out_of_range";
  return {};
}

}  // namespace

OffsetPage offset_page(const Dialect& dialect, const MachineData& data) {
  const Rules& rules = rules_of(dialect);
  OffsetPage page;
  page.lathe = dialect.tools.lathe;
  page.numbers = dialect.tools.most_offsets;
  if (data.bit(rules.fewer_numbers)) page.numbers = std::min(page.numbers, rules.few);
  page.wear = !data.bit(rules.no_wear);
  page.memory = page.wear ? 'C' : 'A';
  page.largest_mm = rules.largest_mm;
  // 0i-D: 9999.999 mm; ten times the step has one digit less, a tenth of it one more.
  if (data.bit(rules.coarse)) page.largest_mm = 9'999.99;
  if (data.bit(rules.fine)) page.largest_mm = 9'999.9999;
  page.largest_wear_mm = page.largest_mm;
  if (!rules.largest_wear.empty()) page.largest_wear_mm = data.parameter(rules.largest_wear, page.largest_mm);
  page.extra_systems = rules.extra_systems;
  page.work_systems = rules.work_systems;
  page.first_variable = rules.first_variable;
  page.last_volatile = rules.last_volatile;
  page.first_kept = rules.first_kept;
  page.last_kept = rules.last_kept;
  return page;
}

std::string refuse_value(const Dialect& dialect, const MachineData& data, const std::vector<char>& axis_names,
                         std::string_view what, std::optional<double> value, const Situation& situation) {
  const interp::ValueRead now = interp::read_value(data, axis_names, what);
  if (!now.known) return "bad_place";
  if (value && !std::isfinite(*value)) return "out_of_range";
  const ValueKind kind = interp::kind_of_value(what);
  if ((kind == ValueKind::tool || kind == ValueKind::work) && !value) return "out_of_range";
  switch (kind) {
    case ValueKind::tool: {
      std::string why = refuse_tool(dialect, data, what, now.value.value_or(0), *value);
      if (!why.empty()) return why;
      // Lengths are taken up by the next T or H. A radius or a tip would bend the contour under way.
      const std::string_view field = interp::field_of_value(what);
      const bool taken_later = rules_of(dialect).while_running && (field == "wear" || field == "geometry");
      return situation.running && !taken_later ? "running" : "";
    }
    case ValueKind::work: {
      if (rules_of(dialect).work_systems == 0 && what.starts_with("work/G5")) return "bad_place";
      if (rules_of(dialect).extra_systems == 0 && what.starts_with("work/G54.1")) return "bad_place";
      if (!dialect.tools.lathe && what.starts_with("work/shift")) return "bad_place";
      if (!(std::fabs(*value) <= 99'999.999)) return "out_of_range";
      return situation.running ? "running" : "";
    }
    case ValueKind::variable: {
      std::string why = refuse_variable(dialect, data, interp::number_of_value(what), value);
      return !why.empty() ? why : situation.running ? "running" : "";
    }
    case ValueKind::parameter: {
      std::string why = refuse_parameter(dialect, data, what, value);
      if (!why.empty()) return why;
      if (situation.running) return "running";
      if (!situation.parameter_write) return "parameter_write_off";
      return situation.mdi_or_emergency ? "" : "not_mdi";
    }
    case ValueKind::tool_life:
      if (dialect.life.form == ToolLifeRules::Form::none) return "bad_place";
      return situation.running ? "running" : "";
    case ValueKind::none:
      break;
  }
  return "bad_place";
}

std::optional<NumberRange> parameter_range(std::string_view text) {
  // "500..999": from_chars alone would read the first dot as a decimal point.
  const auto take = [&text](double& into) {
    std::string_view digits = text;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    std::size_t length = digits.starts_with('-') ? 1 : 0;
    const auto whole = [&] {
      while (length < digits.size() && digits[length] >= '0' && digits[length] <= '9') ++length;
    };
    whole();
    if (length + 1 < digits.size() && digits[length] == '.' && digits[length + 1] != '.') {
      ++length;
      whole();
    }
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + length, into);
    if (error != std::errc{} || end != digits.data() + length) return false;
    text = digits.substr(length);
    return true;
  };
  NumberRange range;
  if (text.starts_with("+-") && (text.remove_prefix(2), take(range.most)) && (text.empty() || text[0] == ' '))
    return NumberRange{-range.most, range.most};
  if (!take(range.least)) return std::nullopt;
  static constexpr std::array<std::string_view, 4> kBetween = {"..", "-", "/", "~"};
  const auto* between =
      std::ranges::find_if(kBetween, [&](std::string_view one) { return text.starts_with(one); });
  if (between == kBetween.end()) return std::nullopt;
  text.remove_prefix(between->size());
  if (!take(range.most) || range.most < range.least) return std::nullopt;
  // "0-30000 (table: …)": the remark may say otherwise for one model, the range holds. Units and lists do
  // not.
  if (!text.empty() && !text.starts_with(" (") && !text.starts_with("(")) return std::nullopt;
  return range;
}

}  // namespace headstock::dialects

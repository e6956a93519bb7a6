#include "command-line/offline/coverage.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>
#include <utility>

#include "command-line/offline/off_panel.hpp"
#include "dialects/catalogue.hpp"
#include "dialects/dialect.hpp"
#include "interpreter/system_variables.hpp"
#include "macro/rules.hpp"
#include "tables/citations.hpp"
#include "tables/gcodes_fanuc_0i_m.hpp"
#include "tables/gcodes_fanuc_0i_t.hpp"
#include "tables/gcodes_gsk_2000tc.hpp"
#include "tables/gcodes_gsk_218t.hpp"
#include "tables/gcodes_k2000tc.hpp"
#include "tables/gcodes_lathe_200t.hpp"

namespace headstock::offline {
namespace {

using Rows = std::span<const std::array<std::string_view, 8>>;

struct Table {
  std::string_view profile;
  const Rows& rows;
};
constexpr Table kTables[] = {
    {"fanuc-0i-t", tables::gcodes_fanuc_0i_t}, {"fanuc-0i-m", tables::gcodes_fanuc_0i_m},
    {"gsk-2000tc", tables::gcodes_gsk_2000tc}, {"gsk-218t", tables::gcodes_gsk_218t},
    {"k2000tc", tables::gcodes_k2000tc},       {"lathe-200t", tables::gcodes_lathe_200t},
};

static_assert(std::size(tables::reason_raised) == dialects::kAlarmReasons);

std::string_view cell(std::string_view text) {
  return text == "-" ? std::string_view() : text;
}

std::optional<std::int32_t> whole(std::string_view digits) {
  std::int32_t number = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, number);
  return error == std::errc{} && stop == end ? std::optional(number) : std::nullopt;
}

// "gsk" means gsk-2000tc and gsk-218t, "fanuc-0i" both series.
bool begins(std::string_view profile, std::string_view controllers) {
  return profile == controllers || (profile.starts_with(controllers) && profile[controllers.size()] == '-');
}

// A file below dialects/ speaks for its own controllers only; everything else is shared.
bool speaks_for(std::string_view place, std::string_view profile) {
  constexpr std::string_view kDialects = "dialects/";
  if (!place.starts_with(kDialects) || place.find('/', kDialects.size()) == place.npos) return true;
  const std::string_view folder =
      place.substr(kDialects.size(), place.find('/', kDialects.size()) - kDialects.size());
  return begins(profile, folder);
}

// Where a number is read or raised; empty when nowhere.
std::string_view cited(std::string_view profile, std::string_view number, char kind) {
  for (const auto& one : tables::citations) {
    if (one.number == number && (one.kind == kind || one.kind == '?') && speaks_for(one.place, profile) &&
        (one.controllers.empty() || begins(profile, one.controllers)))
      return one.place;
  }
  return {};
}

void fill(CoverageOf& part, std::string_view profile) {
  for (Covered& item : part.items) {
    const OffPanel* row = off_panel(profile, part.kind, item.code);
    if (row != nullptr && (item.state != State::done || row->assumed)) {
      item.state = row->done ? State::done : State::off_panel;
      item.reason = row->reason;
    }
  }
}

CoverageOf gcodes(std::string_view profile) {
  CoverageOf part{"gcodes", {}};
  for (const GCodeState& g : gcode_states(profile))
    part.items.push_back(
        {g.name(), g.meaning, g.done ? State::done : State::missing, g.done ? g.handler : ""});
  return part;
}

// A code for the machine counts as done: the interpreter passes it on and the ladder answers. "M(No.5210)" is
// a code that a parameter chooses; "M51..M70" and "M9000-M9999" stand for all of them, "M(other)" for those that
// no rule names.
bool carried_out(std::string_view profile, std::string_view code) {
  constexpr std::string_view kByParameter = "M(No.";
  if (code.starts_with(kByParameter)) {
    const std::string_view number = code.substr(kByParameter.size());
    return !cited(profile, number.substr(0, number.find_first_of("-)")), 'p').empty();
  }
  const dialects::Dialect& dialect = *dialects::find(profile);
  if (code == "M(other)") return dialect.m_action(999) == dialects::MAction::own;
  if (code == "M198") return dialect.macros != nullptr && dialect.macros->external_call;
  const bool interrupts = dialect.macros != nullptr && dialect.macros->interruption;
  if (interrupts && (code == "M96" || code == "M97")) return true;
  const std::size_t between = std::min(code.find(".."), code.find('-'));
  const auto first = code.starts_with('M') ? whole(code.substr(1, between - 1)) : std::nullopt;
  auto last = first;
  if (between != code.npos) last = whole(code.substr(code.find_first_of("0123456789", between)));
  if (!first || !last) return false;
  for (std::int32_t number = *first; number <= *last; ++number)
    if (dialect.m_action(number) == dialects::MAction::unavailable) return false;
  return true;
}

CoverageOf mcodes(std::string_view profile) {
  CoverageOf part{"mcodes", {}};
  for (const auto& m : dialects::mcodes(profile))
    part.items.push_back(
        {m.code, m.meaning, carried_out(profile, m.code) ? State::done : State::missing, {}});
  return part;
}

// "PS3000-3999" is raised when its first number or any number is.
CoverageOf alarms(std::string_view profile) {
  CoverageOf part{"alarms", {}};
  const dialects::Dialect& dialect = *dialects::find(profile);
  for (const auto& alarm : dialects::alarms(profile)) {
    Covered item{alarm.code, alarm.en, State::missing, {}};
    for (std::size_t reason = 0; reason < dialects::kAlarmReasons; ++reason) {
      if (tables::reason_raised[reason] && dialect.alarm_codes[reason] == alarm.code) {
        item.state = State::done;
        item.reason = "interpreter";
      }
    }
    if (item.state != State::done) {
      item.reason = cited(profile, alarm.code, 'a');
      if (!item.reason.empty()) item.state = State::done;
    }
    part.items.push_back(item);
  }
  return part;
}

// Rows of parameters that are read by counting on from their first: "6050" stands for 6050 to 6059.
bool counted_on(std::string_view profile, std::string_view number) {
  const dialects::Dialect& dialect = *dialects::find(profile);
  const auto wanted = whole(number);
  if (!wanted) return false;
  const auto in_row = [&](std::string_view first, int count) {
    const auto from = whole(first);
    return from && *wanted >= *from && *wanted < *from + count;
  };
  if (in_row(dialect.look_ahead.held_m, dialect.look_ahead.held_m_count) ||
      in_row(dialect.look_ahead.held_m_ranges, dialect.look_ahead.held_m_range_count))
    return true;
  if (dialect.macros == nullptr) return false;
  const macro::Rules& rules = *dialect.macros;
  return in_row(rules.g_macros.first_parameter, rules.g_macros.count) ||
         in_row(rules.m_macros.first_parameter, rules.m_macros.count) ||
         in_row(rules.m_subs.first_parameter, rules.m_subs.count);
}

CoverageOf parameters(std::string_view profile) {
  CoverageOf part{"parameters", {}};
  for (const auto& parameter : dialects::parameters(profile)) {
    std::string_view place = cited(profile, parameter.number, 'p');
    // A row for several numbers, "6411-6490".
    if (place.empty()) place = cited(profile, parameter.number.substr(0, parameter.number.find('-')), 'p');
    if (place.empty()) place = cited(profile, parameter.number.substr(0, parameter.number.find('/')), 'p');
    if (place.empty() && counted_on(profile, parameter.number)) place = "macro::Rules, LookAheadRules";
    part.items.push_back({parameter.number, parameter.symbol.empty() ? parameter.meaning : parameter.symbol,
                          place.empty() ? State::missing : State::done, place});
  }
  return part;
}

// Whether programs may use this number: a local, a common, or a row of the dialect's system variables.
// @return the last number of the range it is in; nothing: no such variable.
std::optional<std::uint32_t> last_known(const dialects::Dialect& dialect, std::uint32_t number) {
  if (dialect.macros != nullptr) {
    const macro::Rules& rules = *dialect.macros;
    if (number <= rules.locals && (rules.locals > 0 || number > 0)) return rules.locals;
    for (const macro::CommonRange& range : rules.common)
      if (number >= range.first && number <= range.last) return range.last;
  }
  std::optional<std::uint32_t> last;
  for (const interp::SystemVariable& row : dialect.system_variables)
    if (number >= row.first && number <= row.last) last = std::max(last.value_or(0), row.last);
  return last;
}

// "#5001-#5005", "#200..#231", "#3003 bit0": every number of every range in it is a variable.
bool all_known(const dialects::Dialect& dialect, std::string_view row) {
  bool any = false;
  std::size_t at = 0;
  const auto number = [&](std::uint32_t& value) {
    const auto [stop, error] = std::from_chars(row.data() + at, row.data() + row.size(), value);
    at = static_cast<std::size_t>(stop - row.data());
    return error == std::errc{};
  };
  for (at = row.find('#'); at < row.size(); at = row.find('#', at)) {
    ++at;
    std::uint32_t first = 0;
    if (!number(first)) continue;
    std::uint32_t last = first;
    std::size_t next = at;
    while (next < row.size() && (row[next] == '-' || row[next] == '.')) ++next;
    if (next != at && next < row.size()) {
      if (row[next] == '#') ++next;
      const std::size_t before = std::exchange(at, next);
      if (!number(last)) at = before;
    }
    any = true;
    for (std::uint64_t one = first; one <= last;) {
      const auto known = last_known(dialect, static_cast<std::uint32_t>(one));
      if (!known) return false;
      one = std::uint64_t{*known} + 1;
    }
  }
  return any;
}

CoverageOf variables(std::string_view profile) {
  CoverageOf part{"variables", {}};
  const dialects::Dialect& dialect = *dialects::find(profile);
  for (const auto& variable : dialects::variables(profile)) {
    const bool done = all_known(dialect, variable.number);
    part.items.push_back({variable.number, variable.meaning, done ? State::done : State::missing,
                          done ? std::string_view("system variables") : std::string_view()});
  }
  return part;
}

}  // namespace

std::size_t CoverageOf::count(State state) const {
  return static_cast<std::size_t>(std::count_if(
      items.begin(), items.end(), [state](const Covered& item) { return item.state == state; }));
}

std::vector<GCodeState> gcode_states(std::string_view profile) {
  std::vector<GCodeState> out;
  for (const Table& table : kTables) {
    if (table.profile != profile) continue;
    // Columns: A B C group power_on handler meaning source
    for (const auto& row : table.rows)
      out.push_back(
          {cell(row[0]), cell(row[1]), cell(row[2]), row[3], row[5], row[6], row[5] != "unavailable"});
  }
  return out;
}

namespace {

std::vector<CoverageOf> derived(std::string_view profile) {
  if (dialects::find(profile) == nullptr) return {};
  return {gcodes(profile), mcodes(profile), alarms(profile), parameters(profile), variables(profile)};
}

}  // namespace

std::vector<CoverageOf> coverage(std::string_view profile) {
  std::vector<CoverageOf> parts = derived(profile);
  for (CoverageOf& part : parts) fill(part, profile);
  return parts;
}

std::vector<std::string> stale_reasons(std::string_view profile) {
  std::vector<std::string> out;
  const std::vector<CoverageOf> parts = derived(profile);
  for (const OffPanel& row : off_panel_rows(profile)) {
    const auto part = std::find_if(parts.begin(), parts.end(),
                                   [&row](const CoverageOf& one) { return one.kind == row.kind; });
    const std::string where = std::string(row.kind) + " " + std::string(row.codes);
    if (part == parts.end()) {
      out.push_back(where + ": no such kind");
      continue;
    }
    for_each_pattern(row.codes, [&](std::string_view pattern) {
      bool any = false;
      for (const Covered& item : part->items) {
        if (!matches(pattern, item.code)) continue;
        any = true;
        // A range may hold codes that are done; a row for one code says something that is no longer true.
        if (item.state == State::done && !row.done && pattern == item.code)
          out.push_back(where + ": " + std::string(item.code) + " is done (" + std::string(item.reason) +
                        ")");
      }
      if (!any) out.push_back(where + ": the catalogue has no " + std::string(pattern));
    });
  }
  return out;
}

}  // namespace headstock::offline

#include "command-line/offline/coverage.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>

#include "command-line/offline/off_panel.hpp"
#include "dialects/catalogue.hpp"
#include "dialects/dialect.hpp"
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

// A file below dialects/ speaks for its own controllers only; everything else is shared.
bool speaks_for(std::string_view place, std::string_view profile) {
  constexpr std::string_view kDialects = "dialects/";
  if (!place.starts_with(kDialects) || place.find('/', kDialects.size()) == place.npos) return true;
  const std::string_view folder =
      place.substr(kDialects.size(), place.find('/', kDialects.size()) - kDialects.size());
  return profile == folder || (profile.starts_with(folder) && profile.size() == folder.size() + 2);
}

// Where a number is read or raised; empty when nowhere.
std::string_view cited(std::string_view profile, std::string_view number, char kind) {
  for (const auto& one : tables::citations) {
    if (one.number == number && (one.kind == kind || one.kind == '?') && speaks_for(one.place, profile))
      return one.place;
  }
  return {};
}

void fill(CoverageOf& part, std::string_view profile) {
  for (Covered& item : part.items) {
    if (item.state == State::done) continue;
    if (const OffPanel* row = off_panel(profile, part.kind, item.code)) {
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
// a code that a parameter chooses; "M51..M70" stands for all of them.
bool carried_out(std::string_view profile, std::string_view code) {
  constexpr std::string_view kByParameter = "M(No.";
  if (code.starts_with(kByParameter)) {
    const std::string_view number = code.substr(kByParameter.size());
    return !cited(profile, number.substr(0, number.find_first_of("-)")), 'p').empty();
  }
  const dialects::Dialect& dialect = *dialects::find(profile);
  const std::size_t between = code.find("..");
  const auto first = code.starts_with('M') ? whole(code.substr(1, between - 1)) : std::nullopt;
  const auto last = between == code.npos ? first : whole(code.substr(between + 3));
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

CoverageOf parameters(std::string_view profile) {
  CoverageOf part{"parameters", {}};
  for (const auto& parameter : dialects::parameters(profile)) {
    std::string_view place = cited(profile, parameter.number, 'p');
    // A row for several numbers, "6411-6490".
    if (place.empty()) place = cited(profile, parameter.number.substr(0, parameter.number.find('-')), 'p');
    part.items.push_back({parameter.number, parameter.symbol.empty() ? parameter.meaning : parameter.symbol,
                          place.empty() ? State::missing : State::done, place});
  }
  return part;
}

CoverageOf variables(std::string_view profile) {
  CoverageOf part{"variables", {}};
  for (const auto& variable : dialects::variables(profile))
    part.items.push_back({variable.number, variable.meaning, State::missing, {}});
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

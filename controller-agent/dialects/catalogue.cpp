#include "dialects/catalogue.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>

#include "tables/alarms_fanuc_0i.hpp"
#include "tables/alarms_gsk_2000tc.hpp"
#include "tables/alarms_gsk_218t.hpp"
#include "tables/alarms_k2000tc.hpp"
#include "tables/alarms_lathe_200t.hpp"
#include "tables/mcodes_fanuc_0i.hpp"
#include "tables/mcodes_gsk_2000tc.hpp"
#include "tables/mcodes_gsk_218t.hpp"
#include "tables/mcodes_k2000tc.hpp"
#include "tables/mcodes_lathe_200t.hpp"
#include "tables/parameters_fanuc_0i.hpp"
#include "tables/parameters_gsk_2000tc.hpp"
#include "tables/parameters_gsk_218t.hpp"
#include "tables/parameters_k2000tc.hpp"
#include "tables/parameters_lathe_200t.hpp"
#include "tables/signals_fanuc_0i.hpp"
#include "tables/signals_gsk_2000tc.hpp"
#include "tables/signals_gsk_218t.hpp"
#include "tables/signals_k2000tc.hpp"
#include "tables/signals_lathe_200t.hpp"
#include "tables/variables_fanuc_0i.hpp"
#include "tables/variables_gsk_2000tc.hpp"
#include "tables/variables_gsk_218t.hpp"
#include "tables/variables_k2000tc.hpp"
#include "tables/variables_lathe_200t.hpp"

namespace headstock::dialects {
namespace {

template <std::size_t Columns>
using Rows = std::span<const std::array<std::string_view, Columns>>;

// References, because the tables are constants of other translation units.
struct Catalogue {
  std::string_view profile;
  std::string_view series;
  const Rows<7>& alarms;
  const Rows<10>& parameters;
  const Rows<4>& mcodes;
  const Rows<5>& signals;
  const Rows<4>& variables;
};

#define HEADSTOCK_TABLES(controller)                                                         \
  tables::alarms_##controller, tables::parameters_##controller, tables::mcodes_##controller, \
      tables::signals_##controller, tables::variables_##controller

constexpr Catalogue kCatalogues[] = {
    {"fanuc-0i-t", "T", HEADSTOCK_TABLES(fanuc_0i)},  {"fanuc-0i-m", "M", HEADSTOCK_TABLES(fanuc_0i)},
    {"gsk-2000tc", "", HEADSTOCK_TABLES(gsk_2000tc)}, {"gsk-218t", "", HEADSTOCK_TABLES(gsk_218t)},
    {"k2000tc", "", HEADSTOCK_TABLES(k2000tc)},       {"lathe-200t", "", HEADSTOCK_TABLES(lathe_200t)},
};
#undef HEADSTOCK_TABLES

const Catalogue* catalogue_of(std::string_view profile) {
  const auto found = std::find_if(std::begin(kCatalogues), std::end(kCatalogues),
                                  [&](const Catalogue& candidate) { return candidate.profile == profile; });
  return found == std::end(kCatalogues) ? nullptr : &*found;
}

Alarm to(const std::array<std::string_view, 7>& r, Alarm*) {
  return {r[0], r[1], r[2], r[3], r[4], r[5], r[6]};
}
Parameter to(const std::array<std::string_view, 10>& r, Parameter*) {
  return {r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8], r[9]};
}
MCode to(const std::array<std::string_view, 4>& r, MCode*) {
  return {r[0], r[1], r[2], r[3]};
}
Signal to(const std::array<std::string_view, 5>& r, Signal*) {
  return {r[0], r[1], r[2], r[3], r[4]};
}
Variable to(const std::array<std::string_view, 4>& r, Variable*) {
  return {r[0], r[1], r[2], r[3]};
}

// Rows of the other series of a shared table do not exist for this profile.
bool has_series(std::string_view row_series, const Catalogue& catalogue) {
  return row_series.empty() || catalogue.series.empty() || row_series == catalogue.series;
}
template <typename T>
bool belongs(const T& entry, const Catalogue& catalogue) {
  if constexpr (requires { entry.series; })
    return has_series(entry.series, catalogue);
  else
    return true;
}

template <typename T, std::size_t Columns>
std::vector<T> listed(std::string_view profile, const Rows<Columns>& (*rows)(const Catalogue&)) {
  std::vector<T> out;
  const Catalogue* catalogue = catalogue_of(profile);
  if (catalogue == nullptr) return out;
  for (const auto& row : rows(*catalogue)) {
    const T entry = to(row, static_cast<T*>(nullptr));
    if (belongs(entry, *catalogue)) out.push_back(entry);
  }
  return out;
}

struct Numbered {
  std::string_view prefix;
  unsigned number;
};

std::optional<Numbered> numbered(std::string_view code) {
  const auto digits = std::min(code.find_first_of("0123456789"), code.size());
  unsigned number = 0;
  const char* const end = code.data() + code.size();
  const auto [stop, error] = std::from_chars(code.data() + digits, end, number);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return Numbered{code.substr(0, digits), number};
}

// A row "PS3000-3999" stands for every user alarm of that range.
bool in_range(std::string_view row_code, std::string_view code) {
  const auto dash = row_code.find('-');
  if (dash == std::string_view::npos) return false;
  const auto first = numbered(row_code.substr(0, dash));
  const auto last = numbered(row_code.substr(dash + 1));
  const auto wanted = numbered(code);
  return first && last && wanted && wanted->prefix == first->prefix && wanted->number >= first->number &&
         wanted->number <= last->number;
}

}  // namespace

namespace {

enum class Series { own, any };

bool find_row(const Catalogue& catalogue, std::string_view code, Series series, Alarm& found) {
  const auto search = [&](auto&& matches) {
    for (const auto& row : catalogue.alarms) {
      if (!matches(row[0]) || (series == Series::own && !has_series(row[1], catalogue))) continue;
      found = to(row, static_cast<Alarm*>(nullptr));
      return true;
    }
    return false;
  };
  return search([&](std::string_view row_code) { return row_code == code; }) ||
         search([&](std::string_view row_code) { return in_range(row_code, code); });
}

}  // namespace

bool find_alarm(std::string_view profile, std::string_view code, Alarm& found) {
  const Catalogue* catalogue = catalogue_of(profile);
  return catalogue != nullptr && find_row(*catalogue, code, Series::own, found);
}

Alarm alarm_text(std::string_view profile, std::string_view code) {
  const Catalogue* catalogue = catalogue_of(profile);
  Alarm alarm;
  // A text of the sister series says more than a bare number.
  if (catalogue == nullptr ||
      !(find_row(*catalogue, code, Series::own, alarm) || find_row(*catalogue, code, Series::any, alarm)))
    alarm.en = alarm.zh = code;
  alarm.code = code;
  return alarm;
}

bool find_parameter(std::string_view profile, std::string_view number, Parameter& found) {
  const Catalogue* catalogue = catalogue_of(profile);
  if (catalogue == nullptr) return false;
  for (const auto& row : catalogue->parameters) {
    if (row[0] != number || !has_series(row[1], *catalogue)) continue;
    found = to(row, static_cast<Parameter*>(nullptr));
    return true;
  }
  return false;
}

std::vector<Alarm> alarms(std::string_view profile) {
  return listed<Alarm, 7>(profile, [](const Catalogue& c) -> const Rows<7>& { return c.alarms; });
}
std::vector<Parameter> parameters(std::string_view profile) {
  return listed<Parameter, 10>(profile, [](const Catalogue& c) -> const Rows<10>& { return c.parameters; });
}
std::vector<MCode> mcodes(std::string_view profile) {
  return listed<MCode, 4>(profile, [](const Catalogue& c) -> const Rows<4>& { return c.mcodes; });
}
std::vector<Signal> signals(std::string_view profile) {
  return listed<Signal, 5>(profile, [](const Catalogue& c) -> const Rows<5>& { return c.signals; });
}
std::vector<Variable> variables(std::string_view profile) {
  return listed<Variable, 4>(profile, [](const Catalogue& c) -> const Rows<4>& { return c.variables; });
}

std::vector<std::string_view> profiles() {
  std::vector<std::string_view> out;
  for (const auto& catalogue : kCatalogues) out.push_back(catalogue.profile);
  return out;
}

}  // namespace headstock::dialects

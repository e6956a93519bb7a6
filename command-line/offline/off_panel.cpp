#include "command-line/offline/off_panel.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>

#include "tables/off_panel_fanuc_0i.hpp"
#include "tables/off_panel_gsk_2000tc.hpp"
#include "tables/off_panel_gsk_218t.hpp"
#include "tables/off_panel_k2000tc.hpp"
#include "tables/off_panel_lathe_200t.hpp"

namespace headstock::offline {
namespace {

using Rows = std::span<const std::array<std::string_view, 5>>;

struct Table {
  std::string_view profile, series;
  const Rows& rows;
};
constexpr Table kTables[] = {
    {"fanuc-0i-t", "T", tables::off_panel_fanuc_0i},  {"fanuc-0i-m", "M", tables::off_panel_fanuc_0i},
    {"gsk-2000tc", "", tables::off_panel_gsk_2000tc}, {"gsk-218t", "", tables::off_panel_gsk_218t},
    {"k2000tc", "", tables::off_panel_k2000tc},       {"lathe-200t", "", tables::off_panel_lathe_200t},
};

struct Number {
  std::string_view letters;
  std::uint32_t value = 0;
};

// The letters and the first number of a code: "PS0010" → PS, 10; "6411-6490" → "", 6411; "3402#4" → "", 3402.
std::optional<Number> number_of(std::string_view code) {
  const std::size_t digits = std::min(code.find_first_of("0123456789"), code.size());
  Number number{code.substr(0, digits), 0};
  const auto [stop, error] = std::from_chars(code.data() + digits, code.data() + code.size(), number.value);
  return error == std::errc{} ? std::optional(number) : std::nullopt;
}

}  // namespace

std::vector<OffPanel> off_panel_rows(std::string_view profile) {
  std::vector<OffPanel> out;
  for (const Table& table : kTables) {
    if (table.profile != profile) continue;
    for (const auto& row : table.rows) {
      if (row[1].empty() || row[1] == table.series)
        out.push_back({row[0], row[2], row[3] != "off-panel", row[3] == "assumed", row[4]});
    }
  }
  return out;
}

bool matches(std::string_view pattern, std::string_view code) {
  if (pattern == code) return true;
  if (pattern.ends_with('*')) return code.starts_with(pattern.substr(0, pattern.size() - 1));
  const std::size_t dots = pattern.find("..");
  if (dots == pattern.npos) return false;
  const auto first = number_of(pattern.substr(0, dots));
  const auto last = number_of(pattern.substr(dots + 2));
  const auto wanted = number_of(code);
  return first && last && wanted && wanted->letters == first->letters && wanted->value >= first->value &&
         wanted->value <= last->value;
}

const OffPanel* off_panel(std::string_view profile, std::string_view kind, std::string_view code) {
  static const auto all = [] {
    std::array<std::vector<OffPanel>, std::size(kTables)> rows;
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = off_panel_rows(kTables[i].profile);
    return rows;
  }();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (kTables[i].profile != profile) continue;
    for (const OffPanel& row : all[i]) {
      bool found = false;
      if (row.kind == kind)
        for_each_pattern(row.codes,
                         [&](std::string_view pattern) { found = found || matches(pattern, code); });
      if (found) return &row;
    }
  }
  return nullptr;
}

}  // namespace headstock::offline

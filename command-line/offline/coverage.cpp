#include "command-line/offline/coverage.hpp"

#include <array>
#include <charconv>
#include <optional>
#include <span>

#include "dialects/catalogue.hpp"
#include "dialects/dialect.hpp"
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

std::string_view cell(std::string_view text) {
  return text == "-" ? std::string_view() : text;
}

std::optional<std::int32_t> number_of(std::string_view m_code) {
  std::int32_t number = 0;
  const char* const end = m_code.data() + m_code.size();
  if (!m_code.starts_with('M')) return std::nullopt;
  const auto [stop, error] = std::from_chars(m_code.data() + 1, end, number);
  return error == std::errc{} && stop == end ? std::optional(number) : std::nullopt;
}

}  // namespace

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

std::vector<MCodeState> mcode_states(std::string_view profile) {
  std::vector<MCodeState> out;
  const dialects::Dialect* dialect = dialects::find(profile);
  if (dialect == nullptr) return out;
  for (const auto& row : dialects::mcodes(profile))
    if (const auto number = number_of(row.code))
      out.push_back({row.code, dialect->m_action(*number) != dialects::MAction::unavailable});
  return out;
}

}  // namespace headstock::offline

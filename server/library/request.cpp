#include "server/library/request.hpp"

#include <charconv>
#include <optional>

#include "db/page.hpp"
#include "db/program_store.hpp"

namespace headstock::library {
namespace {

constexpr std::int64_t kMostLooked = 1'000;

/// "O1234", "o01234.nc" → 1234.
std::optional<std::uint32_t> o_number(std::string_view name) {
  if (name.size() < 2 || (name[0] != 'O' && name[0] != 'o')) return std::nullopt;
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(name.data() + 1, name.data() + name.size(), number);
  if (error != std::errc()) return std::nullopt;
  const std::string_view rest(end, static_cast<std::size_t>(name.data() + name.size() - end));
  return rest.empty() || (rest[0] == '.' && rest.size() <= 5) ? std::optional(number) : std::nullopt;
}

}  // namespace

RequestedProgram find_requested(db::Database& db, const std::string& name) {
  const auto number = o_number(name);
  db::ProgramFilter filter;
  filter.text = number ? std::to_string(*number) : name;
  RequestedProgram found;
  found.reason = "not_found";
  for (const db::ProgramRow& row : db::programs(db, filter, {0, kMostLooked}).items) {
    if (row.name != name && (!number || o_number(row.name) != number)) continue;
    if (!row.released) {
      if (found.program == 0) found.reason = "not_released";
      continue;
    }
    if (found.program != 0) return {"ambiguous", 0, 0};
    found = {"", row.id, row.released->number};
  }
  return found;
}

}  // namespace headstock::library

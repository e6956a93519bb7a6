#include "link/program_name.hpp"

#include <charconv>

#include "program/characters.hpp"

namespace headstock::link {
namespace {

using program::is_digit;

}  // namespace

std::optional<std::uint32_t> number_in_name(std::string_view name) {
  if (name.size() < 2 || (name[0] != 'O' && name[0] != 'o')) return std::nullopt;
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(name.data() + 1, name.data() + name.size(), number);
  if (error != std::errc{}) return std::nullopt;
  const std::string_view rest(end, static_cast<std::size_t>(name.data() + name.size() - end));
  // "O1001" or "O1001.nc"; "O1001B" is somebody else's name.
  return rest.empty() || (rest[0] == '.' && rest.size() <= 5) ? std::optional(number) : std::nullopt;
}

std::optional<std::uint32_t> number_in_text(std::string_view head) {
  bool in_comment = false;
  for (std::size_t at = 0; at < head.size(); ++at) {
    const char c = head[at];
    if (in_comment) {
      in_comment = c != ')';
    } else if (c == '(') {
      in_comment = true;
    } else if (c == '%') {
      // Whatever stands on the line of the % is a label for people, not program.
      while (at + 1 < head.size() && head[at + 1] != '\n' && head[at + 1] != '\r') ++at;
    } else if (c == 'O' || c == 'o' || c == ':') {
      std::uint32_t number = 0;
      const char* first = head.data() + at + 1;
      const auto [end, error] = std::from_chars(first, head.data() + head.size(), number);
      if (error == std::errc{} && end != first && is_digit(*first)) return number;
      return std::nullopt;
    } else if (c != ' ' && c != '\t' && c != '\r' && c != '\n' && c != '\0') {
      return std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace headstock::link

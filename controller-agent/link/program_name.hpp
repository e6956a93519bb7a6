// O numbers as they stand in names and texts.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace headstock::link {

/// O number of a name: "O1001", "o01001.nc" → 1001.
std::optional<std::uint32_t> number_in_name(std::string_view name);
/// O number at the head of a text (after %, blank lines and comments).
std::optional<std::uint32_t> number_in_text(std::string_view head);

}  // namespace headstock::link

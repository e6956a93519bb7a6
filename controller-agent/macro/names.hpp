// Names of system variables: [#_ABSIO[n]], [#_DATE], [#_M_SBK] (0i-D 14.2 L13675-14460).
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace headstock::macro {

struct SystemName {
  std::string_view name;         ///< without the underscore
  std::uint32_t number = 0;      ///< of index 1 (or 0 when from_zero)
  std::uint16_t most = 0;        ///< indices; 0: takes none
  std::uint16_t step = 1;
  bool from_zero = false;
  std::int8_t bit = -1;          ///< a bit of #number; −1: the whole
};

/// @return nothing when the control has no such name. `_WZP1` … `_WZP48` included.
/// @param lathe the T series' names; otherwise the M series'.
std::optional<SystemName> system_name(std::string_view name, bool lathe);

}  // namespace headstock::macro

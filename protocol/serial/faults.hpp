// What can go wrong on a line, by the names people and messages know it by.
#pragma once

#include <cstdint>
#include <string_view>

namespace headstock::serial {

enum class Fault : std::uint8_t {
  parity,       ///< a character with the wrong parity bit
  framing,      ///< no stop bit: wrong speed or wrong frame
  overrun,      ///< characters came faster than the device took them
  line_break,   ///< the line was held at 0: cable off, control off
  disconnected  ///< the port is gone: unplugged, server closed the connection
};
inline constexpr std::size_t fault_kinds = 5;

/// "line_parity", "line_framing", "line_overrun", "line_break", "disconnected": message keys.
constexpr std::string_view name_of(Fault fault) {
  constexpr std::string_view names[fault_kinds] = {"line_parity", "line_framing", "line_overrun",
                                                   "line_break", "disconnected"};
  return names[static_cast<std::size_t>(fault)];
}

}  // namespace headstock::serial

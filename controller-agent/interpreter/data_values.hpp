// Every value of MachineData under the name that changes of it are reported with (DataChange::what), so that
// pages, histories, imports and comparisons speak of one value in one way.
//
//   tool/3/geometry/X  tool/3/wear/X  tool/3/radius  tool/3/radius_wear  tool/3/tip
//   work/G54/X  work/G54.1P7/X  work/EXT/X  work/shift/X
//   parameter/3402#0  parameter/1241/X  variable/500
//   tool_life/2/unit (0 uses, 1 seconds)  /life  /current  /tool/0  /offset/0  /h/0  /d/0  /used/0 /skipped/0
//
// mm (X as the page shows it), uses or seconds; parameters and variables in their own unit. A parameter that
// is not set, an empty variable and a tool life entry that is not registered have no value; offsets always
// have one. No thread of its own: whoever holds the MachineData.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "interpreter/machine_data.hpp"

namespace headstock::interp {

enum class ValueKind : std::uint8_t { none, tool, work, parameter, variable, tool_life };
/// By the form of the name alone; none: no such value.
ValueKind kind_of_value(std::string_view what);
/// Its number: tool 3, variable 500, tool life group 2; 0 where it has none.
std::uint32_t number_of_value(std::string_view what);
/// "geometry" "wear" "radius" "radius_wear" "tip" of a tool; otherwise empty.
std::string_view field_of_value(std::string_view what);

struct ValueRead {
  bool known = false;           ///< the machine has a value of this name
  std::optional<double> value;  ///< nothing: not set
};
ValueRead read_value(const MachineData& data, const std::vector<char>& axis_names, std::string_view what);

/// Writes one value; nothing erases it (parameters, variables, a whole tool life group by its `life`).
/// @param most_tools offset numbers the machine has @return false when it has no value of this name, or not
/// such a one (a tip of 10, half a tool number); `data` is then as it was.
bool write_value(MachineData& data, const std::vector<char>& axis_names, std::string_view what,
                 std::optional<double> value, std::size_t most_tools);

/// Everything that is set and not 0 (variables and parameters also when 0), in the order of the pages.
void each_value(const MachineData& data, const std::vector<char>& axis_names,
                const std::function<void(const std::string& what, double value)>& row);

}  // namespace headstock::interp

// Machine data as a control punches them, as single values: "P1 X geometry", "No.1320 A1", "#100", "group 3
// tool 2". For showing and comparing two sets; the text stays what it was. The formats' sources are those of
// punch.hpp.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace headstock::tape {

struct DataEntry {
  std::string item;   ///< what it is, unique in its set
  std::string value;  ///< as punched, without spaces
  bool operator==(const DataEntry&) const = default;
};
/// Every value of the text in its order; lines that are none of the known forms become one entry of their
/// text. A value that comes twice counts as it came last.
std::vector<DataEntry> machine_data(std::string_view text);

struct DataChange {
  std::string item;
  std::optional<std::string> before, after;  ///< nothing: was not there
};
std::vector<DataChange> changes(const std::vector<DataEntry>& before, const std::vector<DataEntry>& after);

/// A value under the name by which the rest of Headstock knows it
/// (controller-agent/interpreter/data_values.hpp).
struct NamedValue {
  std::string what;  ///< tool/3/wear/X, tool/3/radius, work/G54/Z, variable/500 …
  double value = 0;  ///< in the control's own unit
  bool operator==(const NamedValue&) const = default;
};
/// Offsets, work offsets and macro variables of a punch; values of other forms are left out (parameters come
/// in bits and pieces that only their own control can put together). Lathe: P1 is wear and, where there is
/// geometry, P10001 its geometry; mill: L10 length, L11 its wear, L12 radius, L13 its wear.
std::vector<NamedValue> named_values(std::string_view text);

}  // namespace headstock::tape

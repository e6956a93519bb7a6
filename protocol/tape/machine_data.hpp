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

/// A tool offset as the lathe and mill punches name it.
struct PunchedOffset {
  std::uint32_t number = 0;
  char axis = 0;  ///< X Z Y R Q (tip) H (length) D (radius)
  bool wear = false;
  double value = 0;  ///< in the control's own unit
};
/// The tool offsets of a `tool_offsets` punch. Lathe: P1…, geometry from P10001; mill: L10 H geometry, L11 H
/// wear, L12 D geometry, L13 D wear.
std::vector<PunchedOffset> punched_offsets(std::string_view text);

}  // namespace headstock::tape

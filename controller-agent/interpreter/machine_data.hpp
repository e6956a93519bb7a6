// What a controller remembers between programs and an operator edits: offsets, parameters, common variables.
// The interpreter reads it and, by G10 and system variables, writes it; every write is reported so that it
// can be stored.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "machine/axes.hpp"
#include "tools/tool_life.hpp"

namespace headstock::interp {

using machine::AxisVector;

/// One row of the tool offset page. Lathe: geometry and wear per axis, nose radius and tip. Mill: length and
/// radius.
struct ToolOffset {
  AxisVector geometry{};   ///< mm, X as the page shows it (diameter where the axis is diameter-programmed)
  AxisVector wear{};       ///< mm
  double radius = 0;       ///< nose or cutter radius, geometry [mm]
  double radius_wear = 0;  ///< mm
  int tip = 0;             ///< imaginary tool nose 0…9
};

struct MachineData {
  std::vector<ToolOffset> tools;  ///< index = offset number; [0] is always zero
  /// Zero offsets as the page shows them: mm, X as a diameter where the axis is diameter-programmed.
  std::array<AxisVector, 6> work{};         ///< G54…G59
  std::array<AxisVector, 48> work_extra{};  ///< G54.1 P1…P48
  AxisVector work_external{};               ///< EXT; added to all of them
  AxisVector work_shift{};                  ///< lathe: moves the origin of all of them
  /// By the manual's number: "1401", "1401#1" for bits, "1241/X" for one axis; absent = default.
  std::map<std::string, double, std::less<>> parameters;
  std::map<std::uint32_t, double> common_variables;  ///< #100…#199, #500…#999; absent = null
  std::map<std::uint32_t, std::string> variable_names;  ///< #500…#549, given by SETVN
  tools::LifeTable tool_life;                        ///< groups of tools that replace each other
  std::uint64_t version = 0;                         ///< grows with every change

  /// A parameter, or `otherwise` when it is not set.
  double parameter(std::string_view number, double otherwise = 0) const;
  bool bit(std::string_view number) const { return !number.empty() && parameter(number) != 0; }
};

/// Something a program changed (G10, a system variable, a cycle's write-back).
struct DataChange {
  std::string what;  ///< "tool/3/geometry/X", "work/G54/Z", "parameter/3402#0", "variable/500"
  double before = 0;
  double after = 0;
  std::string_view source = "program";  ///< a constant: "G10", "measurement" (G36, G37 …), otherwise "program"
};
using DataChanged = std::function<void(const DataChange&)>;

/// Offsets and parameters in JSON (`--offsets`, `--params`; the format is described in
/// interpreter/README.md).
/// @return empty on success, otherwise what is wrong and where.
std::string load_offsets(const std::string& json_text, const std::vector<char>& axis_names,
                         MachineData& into);
std::string load_parameters(const std::string& json_text, MachineData& into);
std::string offsets_to_json(const MachineData& data, const std::vector<char>& axis_names);

}  // namespace headstock::interp

// Writing offsets, tool life, parameters and variables by hand, at the panel or over the network.
//
// A request names every value it changes, with the value the person saw. It is written as a whole or not at
// all: when one of them has changed meanwhile (a G10, a measurement, another person) nothing is written and
// the one who asked is told the value it has now. What the controller's rules forbid is refused with their
// reason.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace headstock::operation {

struct DataEdit {
  std::string what;              ///< see interpreter/data_values.hpp
  std::optional<double> before;  ///< what the person saw; nothing: not set
  std::optional<double> after;   ///< nothing: erase it
};

struct EditRequest {
  std::vector<DataEdit> values;
  std::string origin;            ///< "panel" "measurement" "person" "import" "copy" "restore" "compensation"
  std::string by;                ///< the person
  std::uint64_t request = 0;     ///< the server's number of it, 0: none
  bool parameter_write = false;  ///< parameters may be written: switched on at the machine
};

/// Direct input of a measured value: the tool touches a place and somebody says what that place is called.
///
///   tool/3/geometry/X   the offset of tool 3, so that the page shows `place` there; its wear becomes 0
///   work/G54/Z          the zero point, likewise: the system in force, or EXT, or a lathe's shift
///
/// Refused while anything moves, and while the offset of another tool, or another system, is in force: the
/// number would then belong to that one.
struct TouchRequest {
  std::string what;
  double place = 0;  ///< mm, X as a diameter where the axis is diameter-programmed
  std::string by;
};

struct EditResult {
  bool accepted = false;
  std::string reason;         ///< key of protocol/wire/reasons; empty when accepted
  std::string where;          ///< the value that was refused
  std::uint64_t version = 0;  ///< of the data that hold the change
};

}  // namespace headstock::operation

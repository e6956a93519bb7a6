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

struct EditResult {
  bool accepted = false;
  std::string reason;         ///< key of protocol/wire/reasons; empty when accepted
  std::string where;          ///< the value that was refused
  std::uint64_t version = 0;  ///< of the data that hold the change
};

}  // namespace headstock::operation

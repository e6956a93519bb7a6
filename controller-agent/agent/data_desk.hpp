// Where offsets, tool life, parameters and variables are written by hand: from the server over the link, and
// at the machine's own panel. A write is done when it is on the disk and was read back from there. Network
// thread.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "link/spool.hpp"
#include "operation/controller.hpp"
#include "operation/data_edit.hpp"

namespace headstock::agent {

class DataDesk {
 public:
  using Done = std::function<void(nlohmann::json)>;

  /// Both must outlive the desk.
  DataDesk(operation::Controller& controller, link::Spool& spool);
  ~DataDesk();

  /// A data_write of the server; `done` gets the data_result without its id, at once when refused, otherwise
  /// when it is on the disk (protocol/wire/README.md).
  void write(const nlohmann::json& request, Done done);
  /// At the panel: "tool/3/wear/X=0.02", "tool/3/wear/X+=0.02", "variable/500=" (erases).
  operation::EditResult write_here(const std::string& assignment, const std::string& origin);
  /// At the panel: "tool/3/geometry/X=42.5": the tool touches a diameter of 42.5; see operation/data_edit.hpp.
  operation::EditResult touch_here(const std::string& assignment);
  /// As the controller has it now; nothing inside: not set; nothing at all: the machine has no such value.
  std::optional<std::optional<double>> value_here(const std::string& what) const;
  /// The switch at the machine that lets parameters be written; off after every start. While it is on the control is in
  /// its alarm for that. Refused: "running".
  operation::CommandResult parameter_write(bool on);
  bool parameter_write() const { return parameter_write_; }

  /// Something was committed to the spool.
  void committed();
  /// The body of a data_report.
  nlohmann::json report() const;

 private:
  struct Waiting;

  operation::Controller& controller_;
  link::Spool& spool_;
  std::vector<char> axis_names_;
  std::vector<Waiting> waiting_;
  bool parameter_write_ = false;
};

}  // namespace headstock::agent

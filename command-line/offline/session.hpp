// What the offline tools share: the options that describe a controller, and the controller they describe.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "machine/machine.hpp"
#include "program/library.hpp"

namespace headstock::options {
class Command;
}

namespace headstock::offline {

/// `--profile --machine --offsets --params --set --lib`, as given.
struct Options {
  std::string profile, machine_file, offsets_file, params_file;
  std::vector<std::string> settings;   ///< key=value
  std::vector<std::string> libraries;  ///< folders
};

/// Adds the options; `options` must outlive the application.
void add_options(options::Command command, Options& options);

/// A controller as the options describe it.
struct Session {
  const dialects::Dialect* dialect = nullptr;
  machine::Machine machine;
  interp::MachineData data;
  interp::Switches switches;
  program::FilePrograms programs;

  std::vector<char> axis_names() const;
  /// Where the axes stand when a program starts: the reference point.
  machine::AxisVector start_position() const;
};

/// @param error what is wrong with the options or a file, for the person who gave them.
std::unique_ptr<Session> make_session(const Options& options, std::string& error);

/// Opens FILE, or stdin for `-` (read as a stream: jumps backwards are alarms). @return nullptr when it
/// cannot be read.
std::unique_ptr<program::Source> open_program(const std::string& file);

}  // namespace headstock::offline

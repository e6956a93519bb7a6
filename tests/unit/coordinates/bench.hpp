// A control with further axes and parameters, and what it makes of a program.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "program/library.hpp"

namespace headstock::interp {

inline machine::Machine with_axes(std::string_view profile, std::string_view further) {
  machine::Machine machine = *machine::default_machine(profile);
  for (const char name : further) {
    machine::Axis axis;
    axis.name = name;
    axis.rotary = name <= 'C';
    machine.axes.push_back(axis);
  }
  return machine;
}

struct Bench {
  explicit Bench(std::string_view profile, std::string_view further = {})
      : machine(with_axes(profile, further)), interpreter(*dialects::find(profile), machine, data, nullptr) {}
  machine::Machine machine;
  MachineData data;
  std::string text_of_program;  // being run: the source reads it where it is
  Interpreter interpreter;

  void start(std::string text, const AxisVector& from = {}) {
    text_of_program = std::move(text);
    interpreter.start(program::source_from_text(text_of_program), from);
  }
  std::vector<Operation> rest() {
    std::vector<Operation> made;
    Operation operation;
    while (interpreter.next(operation) == Pull::operation && made.size() < 200'000) made.push_back(operation);
    return made;
  }
  std::vector<Operation> run(std::string text, const AxisVector& from = {}) {
    start(std::move(text), from);
    return rest();
  }
};

inline const Motion* motion_of(const Operation& operation) {
  if (const auto* rapid = std::get_if<Rapid>(&operation)) return rapid;
  if (const auto* feed = std::get_if<Feed>(&operation)) return feed;
  return std::get_if<Arc>(&operation);
}

inline std::string alarm_of(const std::vector<Operation>& made) {
  for (const Operation& operation : made) {
    if (const auto* alarm = std::get_if<Alarm>(&operation)) return alarm->code;
  }
  return {};
}

}  // namespace headstock::interp

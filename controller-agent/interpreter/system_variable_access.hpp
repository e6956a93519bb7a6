// What the functions behind system variables share. For system_variables*.cpp only.
#pragma once

#include <string>

#include "interpreter/executor.hpp"
#include "interpreter/system_variables.hpp"

namespace headstock::interp::system_variables {

using macro::Result;
using Row = SystemVariable;

inline bool must_stand_still(const Executor& ex) {
  return !ex.at_standstill && ex.macros->environment->takes_time();
}

// What waiting loops look at counts as a change: with a running machine it may come any time.
inline void looked_at_machine(Executor& ex) {
  if (!ex.macros->environment->takes_time()) return;
  ++ex.macros->variables.writes;
  ex.jumps = 0;
}

inline double unit_of(const Executor& ex, std::size_t axis) {
  return ex.axes[axis].rotary ? 1 : ex.unit_mm;
}

inline Result checked_axis(const Executor& ex, std::size_t axis) {
  return axis < ex.axes.size() ? Result{} : Result::failed(AlarmReason::macro_variable);
}

inline std::string axis_text(const Executor& ex, std::size_t axis) {
  return std::string(1, ex.axes[axis].name);
}

inline void store(Executor& ex, double& cell, double value, const std::string& what) {
  const double before = cell;
  cell = value;
  if (before != value) ex.report_change(what, before, value);
}

}  // namespace headstock::interp::system_variables

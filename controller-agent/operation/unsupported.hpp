// Operations that this machine has no hardware for. They stop the program by an alarm: a probing move without
// its signal, or an index table that nobody turns, must not pass for done.
#pragma once

#include <optional>

#include "interpreter/canonical.hpp"
#include "machine/machine.hpp"
#include "operation/overtravel_alarm.hpp"

namespace headstock::operation {

/// @return the alarm when `operation` must be refused. What the machine has is said in its file: skip_input,
/// second_auxiliary, polygon_axis.
/// @param skip_input the machine has a skip input (also ControllerOptions)
std::optional<MachineAlarm> unsupported_alarm(const interp::Operation& operation,
                                              const machine::Machine& machine, bool skip_input);

/// M96 asks for an interruption signal, and this machine has no input for it (`interruption_input`): a program that
/// counts on being interrupted must not run as if nothing were missing.
MachineAlarm interruption_alarm();

}  // namespace headstock::operation

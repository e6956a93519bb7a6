// Operations that a program asks for and the machine side does not carry out yet. They stop the program by an
// alarm: a probing move without its signal, or a forbidden zone that nobody watches, must not pass for done.
#pragma once

#include <optional>

#include "interpreter/canonical.hpp"
#include "operation/overtravel_alarm.hpp"

namespace headstock::operation {

/// @return the alarm when `operation` must be refused. Whoever teaches the machine side one of these removes
/// its row.
/// @param skip_input the machine has a skip input (ControllerOptions)
std::optional<MachineAlarm> unsupported_alarm(const interp::Operation& operation, bool skip_input);

}  // namespace headstock::operation

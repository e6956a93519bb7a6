// Why the program that is fed into the machine broke off, as the alarm of that controller.
#pragma once

#include <string_view>

#include "operation/overtravel_alarm.hpp"

namespace headstock::operation {

/// @param fault message key of what went wrong where the program comes in: line_parity, line_framing,
/// line_overrun, line_break, disconnected, dr_off, buffer_overflow, th, tv, no_start_mark. An empty code for
/// any other: the dialect's own input alarm is right then.
MachineAlarm input_alarm(std::string_view profile, std::string_view fault);

}  // namespace headstock::operation

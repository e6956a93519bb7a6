// Which alarm a controller shows when the supervision of axes and spindle stops the machine.
#pragma once

#include "axes/supervision.hpp"
#include "operation/overtravel_alarm.hpp"

namespace headstock::operation {

/// @param axis address letter of the axis concerned
MachineAlarm fault_alarm(std::string_view profile, const axes::Fault& fault, char axis);

}  // namespace headstock::operation

// Alarms that the machine side raises by itself, in the words of each controller.
#pragma once

#include <string>
#include <string_view>

namespace headstock::operation {

/// An alarm by its code; the texts serve where the profile's catalogue has none of its own.
struct MachineAlarm {
  std::string_view code;
  std::string_view en, zh;
};

/// Stored stroke check 1 has stopped an axis at its limit.
/// @param axis address letter. The code is as that controller prints it.
MachineAlarm overtravel_alarm(std::string_view profile, char axis, bool positive);

/// A drip-feed has run out of data in the middle of a program; the axes are in feed hold. A message, not an
/// alarm: the controllers themselves just stand still here and leave the operator guessing.
MachineAlarm starved_message();

/// The last tool of a tool life group is spent (signal TLCH). A message: the part under way is finished with
/// it.
MachineAlarm tool_life_message();

/// An M code that waits for an input port, or acts after a delay or at a position, on a machine whose PLC
/// cannot do that: never answered as if it had been done.
MachineAlarm port_code_alarm();

}  // namespace headstock::operation

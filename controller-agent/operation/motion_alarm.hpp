// What is refused before an axis moves because the axes could not carry it out as it is meant.
#pragma once

#include <optional>

#include "machine/machine.hpp"
#include "motion/kernel.hpp"
#include "operation/overtravel_alarm.hpp"

namespace headstock::operation {

/// A thread that the axes cannot follow at this spindle speed: lead × speed above the feed of an axis
/// (HS0003), or a thread shorter than the way the axes need to reach that speed (HS0004). The controllers'
/// manuals leave both to the programmer; what comes out is a wrong lead or a broken tap.
/// @param rpm commanded spindle speed, ≥ 0; at 0 the thread waits for the spindle and nothing is said
std::optional<MachineAlarm> thread_alarm(const machine::Machine& machine, const machine::AxisVector& start,
                                         const motion::Move& move, const motion::ThreadFeed& thread,
                                         double rpm);

/// Stored stroke check 2: OT0502, OT0503 (0i-D L73422).
MachineAlarm zone_alarm(bool positive);

}  // namespace headstock::operation

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
/// @param run_up_mm what the move is a chord of, see interp::Thread
/// @param bell_s in which the acceleration rises and falls
std::optional<MachineAlarm> thread_alarm(const machine::Machine& machine, const machine::AxisVector& start,
                                         const motion::Move& move, const motion::ThreadFeed& thread,
                                         double rpm, double run_up_mm = 0, double bell_s = 0);

/// Stored stroke checks 2 and 3: OT0502…OT0505 (0i-D L73422, L73432). @param check 2 or 3
MachineAlarm zone_alarm(std::size_t check, bool positive);
/// Stroke check before move: OT0510, OT0511 (0i-D L73457).
MachineAlarm before_move_alarm(bool positive);

/// An axis that no program may move now: without a reference point (0i-D PS0224), a synchronous slave
/// (PS0213), one of the ladder (PS0130), the Cs axis while the spindle is under speed control (PS0197).
std::optional<MachineAlarm> axis_alarm(const machine::Machine& machine, std::size_t axis, bool homed,
                                       bool contour);

/// A tap that spindle or axis cannot follow: speed above the spindle's in tapping (0i-D PS0200, GSK 2000TC
/// 182), lead × speed above the feed of the axis (GSK 2000TC 011, K2000TC SV3), no speed at all.
std::optional<MachineAlarm> tap_alarm(const machine::Machine& machine, std::size_t axis, double pitch_mm,
                                      double rpm, bool rigid);
/// Reference return has found no safe zero mark (0i-D PS0090).
MachineAlarm homing_alarm();
/// Dry run with a rate (No.1410) of nothing: the axes would stand for ever.
MachineAlarm dry_run_alarm();
/// Polygon turning faster than the tool axis turns (0i-D PS5018).
MachineAlarm polygon_alarm();
/// HS0031: parameters that ask for an acceleration that is not done; their names follow. A message, not an alarm.
MachineAlarm acceleration_message();
/// A tap along more than one axis.
MachineAlarm tap_across_alarm();

}  // namespace headstock::operation

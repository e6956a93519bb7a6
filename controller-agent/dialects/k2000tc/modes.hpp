// Codes of the K2000TC that set or leave a mode of its own.
#pragma once

namespace headstock::interp {
struct Executor;
}

namespace headstock::dialects::k2000tc {

using interp::Executor;

bool modify_parameters(Executor& ex);        // G05
bool hypothetical_axis(Executor& ex);        // G07
bool spindle_thread(Executor& ex);           // G07.2
bool diameter_or_radius(Executor& ex);       // G10.9
bool machine_move(Executor& ex);             // G53
bool fast_machine_move(Executor& ex);        // G153
bool assign_axes(Executor& ex);              // G54.9
bool mirror_x_on(Executor& ex);              // G68
bool mirror_x_off(Executor& ex);             // G69
bool cylinder(Executor& ex);                 // G07.1
bool polar_interpolation_on(Executor& ex);   // G12.1
bool polar_interpolation_off(Executor& ex);  // G13.1
bool dwell(Executor& ex);                    // G04
bool rotation_on(Executor& ex);              // G68.1
bool rotation_off(Executor& ex);             // G69.1
bool polar_on(Executor& ex);                 // G16
bool skip(Executor& ex);                     // G31
bool inch(Executor& ex);                     // G20
bool metric(Executor& ex);                   // G21
bool data_input(Executor& ex);               // G10

}  // namespace headstock::dialects::k2000tc

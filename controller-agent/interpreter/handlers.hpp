// The handlers of G codes that several dialects share, and their names in gcodes.tsv.
#pragma once

#include <string_view>

#include "dialects/dialect.hpp"

namespace headstock::interp::handlers {

/// What gcodes.tsv means by a handler's name.
struct Named {
  std::string_view name;
  dialects::Phase phase;
  dialects::Handler handler;  ///< nullptr: the code only changes the modal display
};

/// @return nullptr when there is no such handler.
const Named* find(std::string_view name);

// The handlers themselves, by the file they stand in. Each carries out its code of the block in `ex`; false after an
// alarm.
// coordinates.cpp
bool set_coordinates(Executor& ex);  // G50, G92
bool preset_coordinates(Executor& ex);
bool local(Executor& ex);         // G52
bool machine_move(Executor& ex);  // G53
bool work_select(Executor& ex);   // G54-G59, G54.1
// reference.cpp
bool reference_return(Executor& ex);    // G28
bool reference_return_n(Executor& ex);  // G30
bool reference_from(Executor& ex);      // G29
bool reference_check(Executor& ex);     // G27
// data_input.cpp, parameter_input.cpp
bool data_input(Executor& ex);       // G10
bool data_input_end(Executor& ex);   // G11
bool parameter_input(Executor& ex);  // G10 L52
bool pitch_input(Executor& ex);      // G10 L50
// compensation_codes.cpp, tool_offset.cpp, tool_step.cpp, normal_direction.cpp
bool compensation_cancel(Executor& ex);  // G40
bool compensation_left(Executor& ex);    // G41
bool compensation_right(Executor& ex);   // G42
bool corner_arc(Executor& ex);           // G39
bool length_offset(Executor& ex);        // G43 G44 G49
bool tool_step(Executor& ex);            // G45-G48
bool normal_direction_on(Executor& ex);
bool normal_direction_off(Executor& ex);
// transform.cpp, polar_command.cpp, surface.cpp
bool mirror_on(Executor& ex);
bool mirror_off(Executor& ex);
bool scaling_on(Executor& ex);
bool scaling_off(Executor& ex);
bool rotation_on(Executor& ex);
bool rotation_off(Executor& ex);
bool polar_on(Executor& ex);   // G16
bool polar_off(Executor& ex);  // G15
bool cylinder(Executor& ex);   // G07.1
bool polar_interpolation_on(Executor& ex);
bool polar_interpolation_off(Executor& ex);
bool enter_polar(Executor& ex, int linear, int rotary);  // the same, of these two axes
// supervision.cpp
bool stroke_check_on(Executor& ex);
bool stroke_check_off(Executor& ex);
bool spindle_watch_on(Executor& ex);
bool spindle_watch_off(Executor& ex);
bool contour_by_p(Executor& ex);  // G08
bool contour_by_q(Executor& ex);  // G05.1
bool increment_limit(Executor& ex);
bool polygon_on(Executor& ex);
bool polygon_off(Executor& ex);
bool servo_mode(Executor& ex);
// each in a file of its own
bool dwell(Executor& ex);             // G04
bool skip(Executor& ex);              // G31
bool single_direction(Executor& ex);  // G60
bool measure(Executor& ex);           // G36 G37
bool thread(Executor& ex);            // G32, G33
bool thread_variable(Executor& ex);   // G34
bool surface_speed_on(Executor& ex);  // G96 (spindle.cpp)
bool surface_speed_off(Executor& ex);
bool select_unit(Executor& ex, bool inch);  // units.cpp

}  // namespace headstock::interp::handlers

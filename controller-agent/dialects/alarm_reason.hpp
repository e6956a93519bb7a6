// Everything the interpreter can object to. Each dialect has the number its controller prints for it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace headstock::dialects {

enum class AlarmReason : std::uint8_t {
  // ---- text of a block
  no_address,     ///< a number without an address
  no_data,        ///< an address without a number
  minus_sign,     ///< a minus sign where none may be
  decimal_point,  ///< a decimal point where none may be
  too_many_digits,
  value_range,               ///< a value outside the address's range
  illegal_address,           ///< an address or character that this control or machine does not have
  duplicate_word,            ///< an address twice in a block
  absolute_and_incremental,  ///< X with U, Z with W
  block_too_long,
  slash_position,         ///< block skip not at the head of the block
  program_number,         ///< O or N wrong
  end_of_record,          ///< the text ends without M02, M30 or M99
  input_failed,           ///< the source of the program broke
  expression,             ///< a macro expression is wrong
  statement_unavailable,  ///< a macro statement this version does not carry out
  // ---- codes
  illegal_g,      ///< not in the control's table
  g_unavailable,  ///< in the table, not carried out by this version
  m_unavailable,
  g_same_group,           ///< two codes of one group in a block
  g_one_shot_and_motion,  ///< group 00 with group 01 in a block
  too_many_m,
  illegal_m,
  t_not_allowed,  ///< T in a block that may not have it
  stand_alone,    ///< a code that must be alone in its block
  // ---- feed, motion
  feed_missing,
  arc_radius,     ///< start and end radius differ
  arc_no_center,  ///< neither R nor I J K
  arc_negative_r,
  arc_r_too_small,   ///< the end cannot be reached with this R
  arc_r_and_center,  ///< R together with I K
  arc_plane,         ///< axis outside the plane
  thread_lead,
  thread_f_and_i,
  reference_check,      ///< G27: not at the reference point
  reference_number,     ///< G30 P
  no_intermediate,      ///< G29 without G28
  no_start_point,       ///< return to start point without G50
  machine_incremental,  ///< G53 with an incremental word
  length_axis,          ///< G43 without a usable axis
  // ---- data
  offset_number,
  work_number,  ///< G54.1 P
  data_input,   ///< G10 form
  data_value,   ///< G10 value
  dwell_words,  ///< P and X together
  // ---- spindle
  spindle_reversed,     ///< M03 and M04 without M05 between them: as illegal_m
  spindle_gear,         ///< S that is no gear: as value_range
  surface_speed_gear,   ///< G96 on a spindle with gears only: as value_range
  gear_change,          ///< M41-M44 on a spindle that changes no gears: as illegal_m
  // ---- tool life
  life_format,           ///< G10 L3: a word that may not be there: as data_input
  life_group_number,     ///< above the most: as data_input
  life_group_missing,    ///< not registered: as offset_number
  life_too_many_tools,   ///< in a group: as data_input
  life_no_t,             ///< T missing: as data_input
  life_not_in_use,       ///< H99 or D99 without a tool of a group: as offset_number
  life_wrong_t,          ///< not the group in use: as offset_number
  life_no_p_l,           ///< P or L missing: as data_input
  life_too_many_groups,  ///< as data_input
  life_value,            ///< life 0 or too large: as data_value
  life_data,             ///< a group without tools: as offset_number
  // ---- calls
  call_without_p,
  program_not_found,
  sequence_not_found,
  nesting,
  call_count,
  // ---- macros
  macro_syntax,          ///< neither a word nor a statement
  macro_integer,         ///< AND, OR, XOR of a number that does not fit into 32 bits
  macro_overflow,        ///< a result outside the range of numbers
  macro_divide,          ///< by zero
  macro_variable,        ///< no variable has this number
  macro_protected,       ///< may not be written
  macro_write_only,      ///< may not be read
  macro_brackets,        ///< nested too deep
  macro_argument,        ///< outside what the function takes
  macro_digits,          ///< a constant with too many digits
  macro_two_arguments,   ///< ATAN, POW: wrong arguments
  macro_expression,      ///< wrong form of an expression
  macro_open_bracket,    ///< missing
  macro_close_bracket,   ///< missing
  macro_equals,          ///< missing
  macro_comma,           ///< missing
  macro_if_form,
  macro_while_form,
  macro_loop_number,     ///< DO and END take 1 to 3
  macro_loop_end,        ///< DO without END, or crossing
  macro_loop_begin,      ///< END without DO
  macro_goto_range,      ///< GOTO 0, GOTO 100000
  macro_goto_target,     ///< GOTO: no such sequence number
  macro_dnc,             ///< GOTO, WHILE in a program that cannot be searched
  macro_with_words,      ///< statement or call together with other commands
  macro_g_argument,      ///< G as an argument
  macro_groups,          ///< more than 10 groups of I J K
  macro_nesting,         ///< calls too deep
  macro_call_twice,      ///< two macro calls in a block
  sub_call_twice,        ///< two sub-program calls in a block
  macro_m99_with_words,  ///< M99 with other words under G66
  macro_cancel,          ///< G67 without G66
  macro_no_name,         ///< [#NAME] that nobody named
  macro_name_long,
  macro_subscript,
  macro_names_form,      ///< SETVN
  macro_name_character,  ///< SETVN
  macro_set_name_long,   ///< SETVN
  macro_print_form,      ///< DPRNT, BPRNT
  external_not_found,    ///< M198: no such file
  external_twice,        ///< M198 in a program called by M198
  external_in_dnc,       ///< M198 while the main program is fed from outside
  endless_loop,  ///< jumps without end and without motion: ours, controllers just hang
  // ---- chamfers, corner rounds, drawing dimensions
  corner_words,         ///< more than one of I J K R, or chamfer and round together
  corner_thread,        ///< in a thread block
  corner_no_move,       ///< the next block has no move
  corner_not_feed,      ///< the next block is no G01, or leads another way
  corner_taper,         ///< both axes move in a block with I K R
  corner_axis,          ///< I with X, K with Z
  corner_too_large,     ///< the move is shorter than the chamfer or round
  corner_comma,         ///< a comma where there is none, or in a block that cannot have it
  corner_profile_end,   ///< the last block of a cycle's profile has one
  corner_unavailable,   ///< switched off by parameter
  drawing_no_end,       ///< no end point and angle after a block with an angle only
  drawing_no_solution,  ///< the end point cannot be computed
  drawing_parallel,     ///< the two lines do not meet
  drawing_blocks,       ///< too many blocks without motion inside
  drawing_incremental,  ///< the second block of an open line is not absolute
  // ---- radius compensation
  compensation_no_crossing,
  compensation_start_arc,   ///< G02/G03 in a start-up or cancel block
  compensation_side,        ///< the side changes right after the start-up block
  compensation_number,      ///< G41/G42 with offset number 0
  compensation_plane,       ///< the plane changes
  compensation_arc_centre,  ///< an inside arc exactly as large as the tool
  compensation_overcut,     ///< an inside arc smaller than the tool
  compensation_corner,      ///< chamfer or round together with start-up, cancel or side change
  compensation_interference,
  compensation_quiet_blocks,  ///< too many blocks without motion
  compensation_refused,       ///< a function that needs G40
  compensation_call,          ///< M98/M99 needs G40
  corner_arc_with_move,       ///< G39 with a move
  // ---- modes: coordinates, skip, data input. A dialect without a number for one of these uses that of the
  // reason named behind it (see dialect.cpp).
  g_not_now,               ///< a code that another mode forbids: as illegal_g
  scale_value,             ///< magnification 0 or too large: as value_range
  scaling_code,            ///< a code that scaling forbids: as illegal_g
  rotation_plane,          ///< arc in another plane than the rotation's: as arc_plane
  polar_axis,              ///< polar interpolation: axes wrong: as arc_plane
  polar_code,              ///< polar interpolation: code not allowed: as illegal_g
  cylinder_axis,           ///< cylindrical interpolation: axis wrong: as arc_plane
  cylinder_code,           ///< cylindrical interpolation: code not allowed: as illegal_g
  skip_not_allowed,        ///< G31 under compensation: as illegal_g
  skip_format,             ///< G31 P98/P99 needs exactly one axis: as value_range
  skip_number,             ///< G31 P, G04 Q: as value_range
  unit_change,             ///< G20/G21 in a state that forbids it: as illegal_g
  unit_change_place,       ///< G20/G21 away from the reference point: as illegal_g
  increment_limit,         ///< G91.1: as value_range
  look_ahead_format,       ///< G08 P: as value_range
  data_number,             ///< G10 P: as data_input
  parameter_format,        ///< G10 L52: as data_input
  parameter_word_missing,  ///< N or R: as data_input
  parameter_number,        ///< no such parameter: as data_input
  parameter_axis,          ///< no such axis: as data_input
  parameter_axis_missing,  ///< P missing: as data_input
  parameter_no_axis,       ///< P where none may be: as data_input
  parameter_range,         ///< R: as data_input
  parameter_sign,          ///< R: as minus_sign
  surface_axis,            ///< G96 P: as value_range
  helix_axes,              ///< more than two axes beside the arc: as arc_plane
  arc_foreign_axis,        ///< an axis parallel to one of the plane: as arc_plane
  arc_in_rapid,            ///< F0 with G02/G03: as feed_missing
  thread_lead_change,      ///< the lead becomes negative or too large: as thread_lead
  setting_with_length,     ///< G92 while the length offset changes: as illegal_g
  too_many_axes,           ///< more axes at once than the control interpolates: as illegal_address
  single_direction_axis,   ///< G60
  spindle_number,          ///< P of S or G96.1: as value_range
  polygon_again,           ///< polygon turning commanded in its own mode: as illegal_g
  polygon_words,           ///< P or Q missing or out of range: as value_range
  polygon_alone,           ///< polygon codes stand alone: as stand_alone
  polygon_axis,            ///< no tool axis set: as illegal_g
  m_combination,           ///< M codes that must stand alone: as too_many_m
  position_overflow,       ///< a position beyond what the control can count: as value_range
  arc_increments,          ///< axes of the plane with different increment systems: as arc_plane
  too_many_words,       ///< in a block: as too_many_m
  macro_word_unknown,   ///< a word of letters that is no statement: as macro_syntax
  call_in_hole_cycle,   ///< M98 with other words while a hole cycle is in force: as macro_with_words
  // ---- G65 H
  h_code,     ///< no such operation: as value_range
  h_target,   ///< P is no variable: as value_range
  h_operand,  ///< Q or R is not what the operation takes: as value_range
  // ---- where a program comes from
  mdi_jump,          ///< GOTO, WHILE in MDI: as macro_dnc
  mdi_compensation,  ///< G41, G42 in MDI: as compensation_refused
  mdi_cycle,         ///< a cycle with a profile in MDI: as stand_alone
  external_in_mdi,   ///< M198: as external_not_found
  // ---- interruption macros
  interrupted_transform,  ///< G51.1, G51, G68 in a program that broke into one of them: as g_not_now
  interrupted_cycle,  ///< the signal inside a cycle with a profile: as g_not_now
  // ---- tool offsets and measuring
  length_axes,                ///< G43/G44 type C on a second axis, or on two
  step_in_compensation,       ///< G45-G48 needs G40
  measure_signal,             ///< G36/G37: no signal, or at the wrong place
  measure_number,             ///< …: no offset number in force
  measure_with_offset,        ///< …: together with H or T
  measure_axis,               ///< …: not one absolute axis word
  reference_in_cycle,         ///< G27-G30 in a canned cycle
  compensation_no_avoidance,  ///< interference, and the neighbours do not meet either
  compensation_danger,        ///< …, where they meet the block between would be cut
  compensation_again,         ///< …, interference again behind it
  rigid_tap_move,             ///< a move (or S) between M29 and its tapping cycle
  rigid_tap_plane,            ///< the plane changes there or in the cycle
  rigid_tap_axis,             ///< another tapping axis while rigid tapping is in force: as rigid_tap_again
  rigid_tap_again,            ///< M29 while a tapping cycle is in force
  drawing_unit,               ///< G20/G21 between an angle block and the next
  drawing_polar,              ///< G12.1/G13.1 there
  drawing_mirror,             ///< a mirror image there
  drawing_plane,              ///< another plane there
  // ---- ranges and places that only some controls print a number for
  arc_r_too_large,      ///< as value_range
  surface_speed_zero,   ///< S0 under G96: as value_range
  computed_number,      ///< O or N by a variable: as program_number
  call_p_value,         ///< M98 P negative or not whole: as call_count
  number_place,         ///< O or N behind a macro statement: as expression
  offset_name,          ///< [#_OFS…] of another kind of offset memory: as macro_no_name
  transform_overflow,   ///< scaling, rotation or a cylinder leads too far: as position_overflow
  compensated_overflow, ///< a crossing of compensation lies too far away: as position_overflow
  // ---- finer reasons of offsets, compensation and corners (see dialect.cpp for those that share a number)
  measure_no_length,       ///< G36/G37: the axis takes no length offset: as measure_axis
  offset_value,            ///< an offset larger than the control takes: as offset_number
  corner_chamfer_size,     ///< a chamfer longer than what it cuts off: as corner_too_large
  corner_short_line,       ///< a chamfer or round that ends beyond its line: as corner_too_large
  compensation_groove,     ///< a straight block between two walls nearer than the tool: as compensation_interference
  compensation_arc_end,    ///< an arc under compensation that ends beside itself: as arc_radius
  compensation_arc_again,  ///< G41/G42 in a block with G02/G03: as compensation_start_arc
  call_with_cycle,         ///< M98/M99 in the block of a cycle: as compensation_call
  two_cycles,              ///< two multiple repetitive cycles in a block: as g_same_group
  normal_direction,        ///< G41.1/G42.1: parameters missing or wrong
  normal_direction_axis,   ///< …: the axis that is turned is commanded: as illegal_address
  count_                   // number of reasons
};

inline constexpr std::size_t kAlarmReasons = static_cast<std::size_t>(AlarmReason::count_);

}  // namespace headstock::dialects

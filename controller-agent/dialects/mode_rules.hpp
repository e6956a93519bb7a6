// Where a dialect keeps what its modes need: parameter numbers and limits of coordinate modes, skip, dwell,
// data input and supervision. An empty number means "this control has no such parameter". FANUC's are set in
// fanuc-0i/dialect.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace headstock::dialects {

/// Numbers first…last of the parameter table.
struct ParameterRange {
  std::int64_t first = 0, last = 0;
};

/// F1…F9 (M series): each digit has its feed in a parameter.
struct OneDigitFeed {
  std::string_view enable;                    ///< bit
  std::int64_t first = 0;                     ///< parameter of F1
  std::string_view most_1_to_4, most_5_to_9;  ///< upper limits
};

/// G codes of a function that a parameter takes away.
struct Option {
  std::string_view absent_parameter;  ///< bit: the control does not have it
  std::int16_t first = 0, last = 0;   ///< codes [tenths]
};

struct ModeRules {
  std::span<const Option> options;
  std::string_view system_b_parameter, system_c_parameter;  ///< bits: G-code system B, C
  std::string_view tenfold_unit_parameter;  ///< bit: 1 without a point is ten least increments
  std::string_view axis_decimal_parameter;  ///< bit an axis: 1 without a point is 1 mm
  std::string_view fine_feed_per_minute_parameter,
      fine_feed_per_revolution_parameter;   ///< bits: F counts in 0.001
  bool flow_codes_alone = false;            ///< M00 M01 M02 M30 M98 M99 share a block with no other M code
  std::string_view polygon_axis_parameter;  ///< tool axis of polygon turning; 0: alarm
  OneDigitFeed one_digit_feed;

  // ---- compensation: modes that refuse each other ask for it
  std::uint8_t compensation_group = 0;  ///< of G40/G41/G42; 0: not asked
  std::int16_t compensation_off = 400;

  // ---- RESET; group numbers, 0: the control has no such group
  std::uint8_t unit_group = 0, stroke_group = 0, work_group = 0;
  std::uint8_t rotation_group = 0, scaling_group = 0, mirror_group = 0, polar_group = 0;
  std::array<std::string_view, 4> kept_group_parameters{};  ///< bytes whose bit n keeps group n through RESET
  std::string_view reset_work_parameter;   ///< bit: RESET returns to G54 without clear state too
  std::string_view reset_local_parameter;  ///< bit: RESET cancels G52

  // ---- axes: bits and values an axis ("1006#3" is read as "1006#3/X")
  std::string_view diameter_parameter, rotary_parameter;
  std::string_view roll_over_parameter, roll_over_by_sign_parameter, turn_parameter;

  /// Places of the 2nd, 3rd and 4th reference point, one value an axis; empty: there is no such point.
  /// Of G30 P2…P4, one value an axis; or "X:P122 Z:P123" where every axis has a number of its own.
  std::array<std::string_view, 3> reference_parameters = {"1241", "1242", "1243"};
  std::string_view first_reference_parameter;  ///< of the 1st point; empty or not set: the machine file's

  int most_axes_at_once = 0;                    ///< interpolated in one block; 0: not limited
  std::string_view imaginary_circle_parameter;  ///< bit an axis: F of a rotary axis counts on a circle …
  std::string_view imaginary_radius_parameter;  ///< … of this radius [mm]

  /// G07.1 and G12.1 may begin under G00, and arcs on a cylinder may be written with I J K (K2000TC L3598).
  bool free_surfaces = false;
  // ---- polar coordinate interpolation
  std::string_view polar_linear_parameter, polar_rotary_parameter;  ///< axis numbers from 1; 0: X and C
  std::array<std::string_view, 2> polar_unsupported{};              ///< must be 0: refused by alarm

  // ---- scaling and rotation
  std::string_view scale_unit_parameter;            ///< bit: magnifications count in 0.001 instead of 0.00001
  std::string_view scale_each_parameter;            ///< bit: I J K, one for each axis
  bool scale_in_thousandths = false;                ///< magnifications always count in 0.001
  bool scale_by_words = false;                      ///< I J K, one for each axis, when one of them is written
  std::string_view scale_parameter;                 ///< magnification when P is left out
  std::string_view scale_axis_parameter;            ///< …, one for each axis
  std::string_view rotation_parameter;              ///< angle when R is left out [0.001°]
  std::string_view rotation_incremental_parameter;  ///< bit: R adds up under G91

  std::string_view scale_enable_parameter;  ///< bit an axis, set unless it is 0: the axis is scaled
  std::string_view fine_angle_parameter;    ///< bit: R of the rotation counts in 0.00001°
  /// MDI: with the first bit set, the second one says absolute (1) or incremental, whatever G90 and G91 say.
  std::string_view mdi_form_parameter, mdi_absolute_parameter;

  std::string_view approach_parameter;  ///< G60: direction and length of the last way, one for each axis
  std::string_view approach_modal_parameter;  ///< bit: G60 is modal, of group 01

  // ---- skip and dwell
  std::array<std::string_view, 5> skip_signals{};  ///< byte of signals for P1…P4/Q1…Q4, and for every dwell
  std::string_view skip_feed_parameter;            ///< bit: G31 moves at No.6281
  std::string_view skip_step_feed_parameter;       ///< bit: G31 P1…P4 move at No.6282…
  std::string_view skip_override_parameter;        ///< bit: override, dry run and acceleration act on G31
  std::string_view skip_off_parameter;             ///< bit: SKIP does nothing in G31
  std::string_view skip_low_parameter;             ///< bit: the skip signals act while they are 0
  bool dwell_p_scales = false;                     ///< P of G04 counts in the increment system
  std::string_view dwell_ms_parameter;             ///< bit: after all in 0.001 s

  std::string_view rotary_linear_parameter;  ///< bit an axis: a rotary axis that runs on, never rounded to a turn

  // ---- units
  std::string_view inch_parameter;      ///< bit, a setting: inch input
  std::string_view x_radius_parameter;  ///< bit: X is written as a radius
  std::string_view
      unit_at_reference_parameter;  ///< bit: G20/G21 only where every axis stands at its reference point
  std::string_view unit_anywhere_parameter;  ///< bit: G20/G21 anywhere, coordinate systems are converted
  std::string_view
      unit_clears_shift_parameter;  ///< bit: G20/G21 drops G92 and G52 shifts instead of an alarm

  // ---- spindle, M S T B
  std::string_view highest_speed_parameter;  ///< clamp of every speed [1/min]
  std::array<std::string_view, 3>
      gear_speeds{};  ///< highest speed of gears 1…3; empty: no gears of the control
  std::string_view gears_by_machine_parameter;  ///< bit: the machine chooses the gear after all
  std::string_view surface_letter_parameter;    ///< axis of G96 where P is no word of it: 0 X, 1 Z, 2 Y
  std::string_view surface_axis_parameter;      ///< axis number of G96; 0: X. Empty: P is not a word of G96
  std::string_view spindle_digits_parameter, tool_digits_parameter, auxiliary_digits_parameter;
  std::string_view auxiliary_enable_parameter;   ///< bit: there is a second auxiliary function
  std::string_view auxiliary_address_parameter;  ///< its letter as ASCII code; otherwise B
  std::string_view auxiliary_decimal_parameter;  ///< bit: with decimal point and sign
  std::string_view auxiliary_inch_parameter;     ///< bit: ten times the factor under inch input
  std::string_view auxiliary_unit_parameter;     ///< bit: as the argument of a call, its units without that function too
  /// Both bits: P beside S names the spindle, by the number in the third; the fourth bit takes that away.
  std::string_view several_spindles_parameter, spindle_by_p_parameter, spindle_p_parameter,
      one_spindle_parameter;

  std::string_view mirror_setting_parameter;  ///< bit an axis: motions of programs go the other way

  // ---- supervision
  std::string_view stroke_2_most, stroke_2_least;  ///< limits an axis, "1322" and "1323"
  std::string_view stroke_2_outside_parameter;     ///< bit: the outside is forbidden
  std::string_view watch_delay_parameter, watch_reached_parameter, watch_ratio_parameter,
      watch_width_parameter;
  std::string_view watch_fine_parameter;  ///< bit: percent numbers count in 0.1 %

  // ---- data input
  bool parameter_input = false;                        ///< G10 L50 and L52 exist
  double largest_offset = 1e9;                         ///< of G10's values, and of an offset taken up [mm, inch]
  bool surface_speed_zero_refused = false;             ///< G96 S0 and below
  std::span<const ParameterRange> axis_parameters;     ///< take P: one value an axis
  std::span<const ParameterRange> spindle_parameters;  ///< may take P
};

}  // namespace headstock::dialects

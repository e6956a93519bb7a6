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

struct ModeRules {
  OneDigitFeed one_digit_feed;

  // ---- compensation: modes that refuse each other ask for it
  std::uint8_t compensation_group = 0;  ///< of G40/G41/G42; 0: not asked
  std::int16_t compensation_off = 400;

  // ---- axes: bits and values an axis ("1006#3" is read as "1006#3/X")
  std::string_view diameter_parameter, rotary_parameter;
  std::string_view roll_over_parameter, roll_over_by_sign_parameter, turn_parameter;

  /// Places of the 2nd, 3rd and 4th reference point, one value an axis; empty: there is no such point.
  std::array<std::string_view, 3> reference_parameters = {"1241", "1242", "1243"};

  // ---- scaling and rotation
  std::string_view scale_unit_parameter;            ///< bit: magnifications count in 0.001 instead of 0.00001
  std::string_view scale_each_parameter;            ///< bit: I J K, one for each axis
  bool scale_in_thousandths = false;                ///< magnifications always count in 0.001
  bool scale_by_words = false;                      ///< I J K, one for each axis, when one of them is written
  std::string_view scale_parameter;                 ///< magnification when P is left out
  std::string_view scale_axis_parameter;            ///< …, one for each axis
  std::string_view rotation_parameter;              ///< angle when R is left out [0.001°]
  std::string_view rotation_incremental_parameter;  ///< bit: R adds up under G91

  std::string_view approach_parameter;  ///< G60: direction and length of the last way, one for each axis
  std::string_view approach_modal_parameter;  ///< bit: G60 is modal, of group 01

  // ---- skip and dwell
  std::array<std::string_view, 5> skip_signals{};  ///< byte of signals for P1…P4/Q1…Q4, and for every dwell
  std::string_view skip_feed_parameter;            ///< bit: G31 moves at No.6281
  std::string_view skip_step_feed_parameter;       ///< bit: G31 P1…P4 move at No.6282…
  std::string_view skip_override_parameter;        ///< bit: override, dry run and acceleration act on G31
  bool dwell_p_scales = false;                     ///< P of G04 counts in the increment system
  std::string_view dwell_ms_parameter;             ///< bit: after all in 0.001 s

  // ---- supervision
  std::string_view stroke_2_most, stroke_2_least;  ///< limits an axis, "1322" and "1323"
  std::string_view stroke_2_outside_parameter;     ///< bit: the outside is forbidden
  std::string_view watch_delay_parameter, watch_reached_parameter, watch_ratio_parameter,
      watch_width_parameter;
  std::string_view watch_fine_parameter;  ///< bit: percent numbers count in 0.1 %

  // ---- data input
  bool parameter_input = false;                        ///< G10 L50 and L52 exist
  double largest_offset = 1e9;                         ///< of G10's values [mm, inch]
  std::span<const ParameterRange> axis_parameters;     ///< take P: one value an axis
  std::span<const ParameterRange> spindle_parameters;  ///< may take P
};

}  // namespace headstock::dialects

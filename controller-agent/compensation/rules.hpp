// What makes one controller's chamfers, corner rounds, radius compensation and tool offsets differ from
// another's: data of a dialect. Parameters by the manual's number; an empty one does not exist there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "compensation/corner.hpp"
#include "compensation/offset.hpp"

namespace headstock::comp {

/// Chamfers, corner rounds and angles in straight moves (and between arcs).
struct CornerRules {
  std::uint32_t comma_letters = 0;    ///< `,C` `,R` `,A` that exist here; see program::letters
  std::uint32_t named_letters = 0;    ///< `NC` `NR` `NA`
  std::string_view enable_parameter;  ///< bit that must not be 0; absent counts as 1
  std::string_view angle_parameter;   ///< bit: angles likewise
  std::string_view comma_parameter;   ///< bit: commas are understood only when it is 1
  /// Bit: C R A are written without a comma, and a comma is an alarm (0i-T CCR). I J K R are no corners then.
  std::string_view bare_parameter;
  /// I J K (chamfer) and R (round) in G01, along one axis, with the sign of the next block's move (0i-T).
  bool perpendicular_words = false;
  std::string_view chamfer_ijk_parameter;  ///< bit: chamfers by I J K instead of C (K2000TC)
  std::string_view round_r_parameter;      ///< bit: rounds by R instead of marked R (K2000TC)
  char chamfer_word = 0, round_word = 0;   ///< words of their own (GSK2000TC L, D)
  double ignored_above_mm = 0;             ///< sizes above it, or below 0, are ignored; 0: they are alarms
  ChamferSize chamfer_size = ChamferSize::cut_back;
  bool arcs = false;                ///< also in and before G02/G03
  double parallel_deg = 0.01;       ///< angles nearer than this give no end point
  std::string_view stop_parameter;  ///< bit: single block stops before the chamfer or round
  int most_between = 1;             ///< blocks without motion between the two; more are an alarm
  bool any() const {
    return (comma_letters | named_letters) != 0 || perpendicular_words || chamfer_word != 0;
  }
};

/// What I J K mean in straight moves under G41/G42.
enum class VectorWords : std::uint8_t {
  none,
  cancel,  ///< with G40: the direction of a wall that the contour goes on along
  all      ///< …, and otherwise: the vector at the block's end is square to them
};

/// G40 G41 G42.
struct CompensationRules {
  VectorWords vector_words = VectorWords::none;
  bool by_d = false;                          ///< the offset number is D (mill); otherwise that of the T word
  std::string_view off_parameter;             ///< bit: the machine does not have it
  std::string_view mdi_alarm_parameter = {};  ///< bit: G41 and G42 are an alarm in MDI ("5008#4")
  std::string_view enable_parameter;          ///< bit that must not be 0; absent counts as 1
  std::string_view type_b_parameter;          ///< bit: start-up and cancel by type B
  std::string_view type_c_parameter;  ///< bit: a start-up or cancel block without a move moves by the vector
  StartType start = StartType::a;
  bool start_by_normal = false;           ///< see OffsetRules
  std::string_view circular_parameter;    ///< bit: circles at outside corners
  std::string_view diameter_parameter;    ///< bit: the offset value is a diameter
  std::string_view read_ahead_parameter;  ///< blocks read ahead, 3…8
  std::string_view near_parameter;        ///< vectors nearer than this [mm] count once
  std::string_view check_parameter;       ///< bit: 0 switches the interference check off; absent counts as 1
  std::string_view no_check_parameter = {};   ///< bit: 1 switches it off
  std::string_view arcs_only_parameter = {};  ///< bit: only the angle of arcs is checked
  std::string_view avoid_parameter;           ///< bit: interference is avoided where it can be
  std::string_view stop_parameter;            ///< bit: single block stops at the moves that compensation adds
  bool calls_refused = false;                 ///< M98 and M99 need G40
  bool tips_in_all_planes = true;             ///< otherwise the nose direction counts in G18 only
  bool zero_number_is_alarm = false;          ///< G41 with offset number 0
  bool again_is_perpendicular = false;  ///< the same G41/G42 again: the vector normal to the block before
  bool side_change_after_start_is_alarm = false;
  bool threads_refused = false;  ///< G32… while compensating; otherwise the vector is dropped for them
  bool keeps_to_intermediate = false;  ///< G28: the vector is dropped after the intermediate point
  std::string_view to_intermediate_parameter = {};  ///< bit: 0 keeps it likewise; absent counts as 1
  int most_quiet_blocks = 0;  ///< so many blocks without motion in a row are an alarm; 0: never
};

}  // namespace headstock::comp

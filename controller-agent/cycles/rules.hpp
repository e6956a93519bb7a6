// What differs between the controllers in their canned cycles, as data: alarm numbers, parameters that keep a
// cycle's values, and the readings each manual asks for. The algorithms ask these tables, never the
// controller's name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace headstock::dialects {
struct Dialect;
}

namespace headstock::cycles {

/// Everything cycles can object to.
enum class Fault : std::uint8_t {
  // ---- profiles of G70-G73
  no_range,          ///< P or Q missing
  range_number,      ///< P or Q is no sequence number
  range_order,       ///< P not before Q, or not a number
  not_found,         ///< no block with that number
  not_following,     ///< the profile does not follow the cycle's block
  not_stored,        ///< the program cannot be read back (drip-feed)
  too_long,          ///< more blocks than the control takes
  first_block,       ///< without G00/G01
  first_block_axis,  ///< moves the wrong axis
  last_block,        ///< ends inside a chamfer
  last_open,         ///< ends inside a drawing dimension
  modal_state,       ///< commanded in a mode that forbids it
  radius_side,       ///< G41/G42 put the tool on the work's side of the profile
  forbidden,         ///< a code that no profile may have
  forbidden_call,    ///< M98, M99, an end
  not_monotonic_along,
  not_monotonic_across,
  above_start,  ///< the profile rises above the start point
  wrong_plane,
  // ---- values
  depth,        ///< depth of cut missing or not positive
  passes,       ///< G73 count
  value,        ///< a word that is missing, negative or out of range
  peck,         ///< G74/G75 steps
  peck_step,    ///< … missing where the end point needs one
  peck_relief,  ///< … Δd with a sign though the direction is given
  taper,        ///< R against U, W
  box_axis,     ///< an axis that the cycle does not have
  thread_lead,
  thread_height,       ///< G76 height missing or not positive
  thread_first_depth,  ///< first depth missing or not positive
  thread_depths,       ///< finishing allowance or least depth against the height
  thread_angle,
  thread_finish,   ///< finishing allowance negative
  thread_clear,    ///< the tool would go in and out the same way
  tap_lead,        ///< tapping without F
  tap_block,       ///< tapping with another axis, or the wrong way
  thread_in_vain,  ///< no depth: inside or outside unknown
  // ---- holes
  hole_depth,  ///< bottom and R on the wrong sides
  hole_peck,   ///< Q missing
  hole_k,      ///< K other than it may be
  hole_axis,
  rigid_speed,
  rigid_feed,
  rigid_program,
  rigid_move,
  rigid_distance,
  tap_word,  ///< L, P or Q in a tapping block: none of its words
  count_
};

/// Names of the parameters that hold a cycle's values; empty: the control has none.
struct Parameters {
  std::string_view depth, retract;                       ///< G71, G72 [mm]
  std::string_view relief_across, relief_along, passes;  ///< G73
  std::string_view peck_retract;                         ///< G74, G75
  std::string_view peck_full_retract;                    ///< bit: back to the start after every peck
  std::string_view runout;                               ///< thread run-out, 0.1 lead
  std::string_view runout_angle;                         ///< degrees
  std::string_view finish_passes, tip_angle, least_depth, finish_allowance;  ///< G76
  std::string_view thread_start, thread_method;                              ///< G76 E s n
  std::string_view thread_arc_in{}, thread_arc_out{};  ///< G76 NB NE: factors on the arcs' width
  std::string_view tolerance_along, tolerance_across;  ///< of the monotonic check [mm]
  std::string_view no_contour_1, no_contour_2;         ///< bits: no contour pass, type I and II
  std::string_view peck_clearance, peck_back;          ///< G83 (return to R), G73 (high speed) [mm]
};

/// Where single block stops inside a cycle.
enum class Stops : std::uint8_t { whole, passes, traverses };

enum class Shapes : std::uint8_t {
  parallel,        ///< type I only
  by_first_block,  ///< type II when the first block moves both axes
  pockets          ///< always
};
/// Whose hole cycles: the tables are in hole_cycles.cpp.
enum class HoleFamily : std::uint8_t { none, mill, turning, k2000, lathe_200t };
/// How the run-out of a thread cycle is given.
enum class RunoutForm : std::uint8_t {
  parameter,  ///< 0.1 lead and an angle, by parameters
  lengths,    ///< J across, K along, otherwise a parameter
  position,   ///< P 0.1 lead before the end, J across (200T)
  width       ///< P or r in 0.1 lead (K2000TC)
};
enum class Check : std::uint8_t { always, by_k_word, unless_parameter };

struct Rules {
  std::string_view profile;
  std::int64_t most_sequence = 99'999'999;  ///< largest N that P and Q of a profile may name
  std::array<std::string_view, static_cast<std::size_t>(Fault::count_)> alarms{};
  Parameters parameters;
  Stops stops = Stops::passes;  ///< of single block inside G71-G75
  // ---- roughing
  Shapes shapes = Shapes::parallel;
  Check check = Check::always;
  std::string_view check_off_parameter;  ///< for Check::unless_parameter
  bool level_cut_at_start = true;
  bool contour_pass = true;
  bool return_by_allowance = false;
  std::string_view contour_out_parameter;  ///< bit; empty: always out along the contour
  std::size_t most_blocks = 0;             ///< of a profile; 0: no limit but ours
  bool must_follow = false;                ///< the profile stands right behind the cycle's block
  std::int64_t least_passes = 1;           ///< of G73
  bool one_block_form = false;             ///< Series 10/11: D in one block
  std::string_view one_block_parameter;    ///< bit that chooses it
  bool radius_in_roughing = false;         ///< G71-G73 under G41/G42 rough beside the profile
  bool radius_in_boxes = false;            ///< G90 and G94 under G41/G42 cut beside their legs
  bool tip_in_boxes = true;                ///< … with the imaginary tip of the offset; otherwise as tip 0
  bool refused_in_mdi = false;             ///< G70-G73 under MDI
  bool one_shot_in_profile = false;  ///< only G00-G04 and feed, speed, compensation modes may stand in it
  // ---- pecks
  bool peck_across_diameter = false;  ///< P of G74/G75 follows diameter programming
  double peck_unit_mm = 0.001;        ///< of P and Q without a point; 0: as other lengths
  bool peck_needed = false;           ///< Q of G74, P of G75 must be written
  // ---- threads
  double runout_default = 0;          ///< 0.1 lead
  bool starts_word = false;           ///< L: number of starts
  std::string_view starts_parameter;  ///< bit that allows L and Q; empty: always
  RunoutForm runout_form = RunoutForm::parameter;
  bool half_runout_is_45 = false;           ///< J or K alone: the same length both ways (218T)
  std::string_view runout_width_parameter;  ///< bit that makes the width P work (K2000TC)
  bool steps_from_last_end = false;         ///< U, W of a repeated cycle count from the last cut's end
  bool angle_word = false;                  ///< Q: start angle
  double depth_unit_mm = 0.001;             ///< of P and Q of G76 without a point; 0: as other lengths
  bool least_from_root = false;  ///< the least cut counts from Δd·√(n-1), not from the last depth
  const std::int64_t* tip_angles = nullptr;  ///< allowed, ends with -1; nullptr: any up to 99
  bool infer_angle_60 = false;               ///< another angle counts as 60 (200T)

  // ---- holes
  HoleFamily holes = HoleFamily::none;
  bool r_from_initial = false;  ///< R is always a distance from the initial level
  bool r_as_axis = false;       ///< R counts as words of the drilling axis do (diameter)
  bool taps_down_only = false;  ///< a tapping block of its own needs its axis word, toward minus
  std::int32_t driven_m = 0;    ///< M code that turns a driven tool cw; the next two: ccw, stop. 0: not known
  std::string_view rigid_tap_parameter;  ///< bit: G84 of the 2000TC is rigid

  std::string_view code(Fault fault) const { return alarms[static_cast<std::size_t>(fault)]; }
};

/// Any thread; constants.
const Rules& rules_of(const dialects::Dialect& dialect);

}  // namespace headstock::cycles

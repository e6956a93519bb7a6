// What one machine is: its axes with their limits, its spindle and its drives. Read from a TOML file that a person
// writes; the defaults of a profile are a small lathe or mill, so that a program can be checked without a file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "machine/axes.hpp"

namespace headstock::machine {

/// How an axis' words are understood when a program gives its position.
enum class Designation { radius, diameter };

/// How an axis finds out where it stands after power on.
enum class Homing {
  absolute,  ///< its encoder knows
  dog        ///< it has to be driven over the deceleration dog to the next zero mark once
};

/// One point of an axis' pitch-error table: what the measured screw is off at a machine position.
struct PitchError {
  double position_mm = 0;
  double error_um = 0;                      ///< measured minus commanded, −1000…1000
};

/// `[axis.X]`. Positions are slide positions in machine coordinates: mm (radius on a lathe's X) or degrees.
struct Axis {
  char name = 'X';                          ///< address letter: X Y Z A B C U V W
  bool rotary = false;                      ///< degrees instead of mm
  Designation designation = Designation::radius;
  double rapid_mm_min = 10'000;             ///< > 0
  double max_feed_mm_min = 8'000;           ///< > 0; also the clamp of the cutting feed on this axis
  double max_acceleration_mm_s2 = 1'000;    ///< > 0
  double max_jerk_mm_s3 = 50'000;           ///< > 0; 1e9 and above means "not limited"
  double min_mm = -1'000;                   ///< stored stroke check 1, negative side
  double max_mm = 1'000;                    ///< stored stroke check 1, positive side
  double reference_mm = 0;                  ///< machine coordinate of reference point 1
  double backlash_um = 0;                   ///< 0…1000
  std::vector<PitchError> pitch_error;      ///< `[[position_mm, error_um], …]`, positions ascending; linear between
  /// The same, measured while moving in the negative direction (bidirectional compensation). Empty: pitch_error holds
  /// both ways and the screw's play is `backlash_um`.
  std::vector<PitchError> pitch_error_negative;
  double emergency_deceleration_mm_s2 = 0;  ///< of an emergency stop, before the drives go off; 0: twice max_acceleration
  Homing homing = Homing::absolute;
  double dog_mm = 0;                        ///< machine coordinate of the middle of the deceleration dog
  double dog_width_mm = 10;                 ///< > 0
  double grid_mm = 5;                       ///< distance of the encoder's zero marks, > 0
  bool home_negative = false;               ///< the search for the dog goes in the negative direction
  double creep_mm_min = 300;                ///< behind the dog, to the zero mark (FANUC No. 1425), > 0
  double in_position_um = 20;               ///< FANUC No. 1826, > 0
  double following_error_mm = 0;            ///< most while moving (No. 1828); 0: 1.5 × what the rapid rate makes, + 1 mm
  double following_error_stopped_mm = 0.5;  ///< most at rest (No. 1829), > 0
  // ---- the servo of the simulated drive
  double position_gain_per_s = 50;          ///< following error [mm] = speed [mm/s] / this; > 0
  double torque_reserve = 2.5;              ///< greatest acceleration of motor and load over max_acceleration, > 0
  double friction_mm_s2 = 0;                ///< Coulomb friction, as the acceleration it eats
  double inertia_ratio = 1;                 ///< load and motor over what the servo was tuned for, > 0
  double encoder_um = 0;                    ///< what the encoder resolves; 0: no rounding
  // ---- electronic gear: pulses to the drive = position × numerator / denominator × 1000 (GSK 2000TC P015, P016)
  int gear_numerator = 0;                   ///< 0: none, the drive takes positions
  int gear_denominator = 1;
  // ---- axes that are coupled
  char follows = 0;                         ///< synchronous axis: does what this axis does; no program commands it
  double synchronous_error_mm = 0.1;        ///< most that it may be away from its master (FANUC No. 8314), > 0
  double inclined_deg = 0;                  ///< angular axis: leans this far towards `inclined_to` (No. 8210), −85…85
  char inclined_to = 0;                     ///< the perpendicular axis (No. 8212); 0: none
  bool plc = false;                         ///< moved by the machine's ladder, not by programs
};

struct Spindle {
  double max_rpm = 4'000;                   ///< > 0
  double min_rpm = 0;
  double acceleration_rpm_s = 2'000;        ///< > 0, of the simulated spindle
  int encoder_lines = 1'024;                ///< pulses a revolution before the fourfold count
  double tap_rpm = 0;                       ///< most in rigid tapping (FANUC No. 5241); 0: max_rpm
  double tap_acceleration_rpm_s = 0;        ///< in rigid tapping; 0: acceleration_rpm_s
  double position_error_deg = 20;           ///< most the spindle may lag in rigid tapping and on Cs (No. 5311), > 0
  int orient_m = 19;                        ///< M code that turns it to orient_deg and keeps it there; 0: none
  double orient_deg = 0;                    ///< from the encoder's zero mark, 0…360
  double orient_rpm = 200;                  ///< > 0
  char contour_axis = 0;                    ///< rotary axis that is this spindle (Cs contour control); 0: none
  int contour_on_m = 0, contour_off_m = 0;  ///< M codes that switch it; 0: none
};

enum class Kind { lathe, mill };

struct Machine {
  std::string name = "machine";
  std::string profile;                      ///< `fanuc-0i-t` … as in the contract of the offline tools
  Kind kind = Kind::lathe;                  ///< from the profile unless `[machine] kind` says otherwise
  int period_us = 1'000;                    ///< interpolation period, 250…8000
  double tolerance_mm = 0.01;               ///< `[path] tolerance_mm`: corners are rounded by at most this
  double tolerance_deg = 0.01;              ///< `[path] tolerance_deg`: the same of each rotary axis; not given: the number of mm
  std::vector<Axis> axes;                   ///< in the order X Y Z A B C U V W; at most kMaxAxes
  Spindle spindle;
  std::string drive = "simulated";          ///< `[drive] type`: simulated, or ideal (follows without any error)
  bool second_auxiliary = false;            ///< B codes are wired to something that acts on them
  bool skip_input = false;                  ///< there is a skip input; without one G31 is an alarm
  bool interruption_input = false;          ///< there is an interruption signal (UINT); without one M96 is an alarm
  char polygon_axis = 0;                    ///< rotary axis that drives the tool of polygon turning; 0: none
  std::size_t program_memory_bytes = 2u << 20;  ///< what the agent keeps of programs (`[memory] programs_kb`)

  /// Degrees that count in tolerances as much as 1 mm.
  double degrees_per_mm() const { return tolerance_deg / tolerance_mm; }
  /// What counts of this axis as much as so many mm where a tolerance is meant [mm or degrees].
  double allowance(std::size_t axis, double tolerance) const {
    return axes[axis].rotary ? tolerance * degrees_per_mm() : tolerance;
  }

  /// Index of the axis with this address letter, if the machine has it.
  std::optional<std::size_t> axis_index(char name) const;
};

/// Why a machine file cannot be used: where and what, for the person who wrote it.
struct MachineError {
  std::string message;   ///< e.g. `lathe.toml:14: [axis.X] max_mm must be greater than min_mm`
};

using MachineOrError = std::variant<Machine, MachineError>;

/// The machine a profile describes when no file is given (limits of a small machine of that kind).
/// @return nullopt when the profile is not one of the six.
std::optional<Machine> default_machine(std::string_view profile);

/// Reads a machine file over the defaults of its profile. Unknown keys are errors: a misspelt limit must not be ignored.
/// @param profile overrides `[machine] profile` when not empty.
MachineOrError load_machine(const std::filesystem::path& file, std::string_view profile = {});

/// The same from text; `where` names it in messages.
MachineOrError parse_machine(std::string_view toml, std::string_view where, std::string_view profile = {});

/// The machine as TOML, so that an agent can show and keep what it runs with.
std::string to_toml(const Machine& machine);

}  // namespace headstock::machine

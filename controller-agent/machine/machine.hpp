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
};

struct Spindle {
  double max_rpm = 4'000;                   ///< > 0
  double min_rpm = 0;
  double acceleration_rpm_s = 2'000;        ///< > 0, of the simulated spindle
  int encoder_lines = 1'024;                ///< pulses a revolution before the fourfold count
};

enum class Kind { lathe, mill };

struct Machine {
  std::string name = "machine";
  std::string profile;                      ///< `fanuc-0i-t` … as in the contract of the offline tools
  Kind kind = Kind::lathe;                  ///< from the profile unless `[machine] kind` says otherwise
  int period_us = 1'000;                    ///< interpolation period, 250…8000
  double tolerance_mm = 0.01;               ///< `[path] tolerance_mm`: corners are rounded by at most this
  std::vector<Axis> axes;                   ///< in the order X Y Z A B C U V W; at most kMaxAxes
  Spindle spindle;
  std::string drive = "simulated";          ///< `[drive] type`
  std::size_t program_memory_bytes = 2u << 20;  ///< what the agent keeps of programs (`[memory] programs_kb`)

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

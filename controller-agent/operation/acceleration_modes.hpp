// The controllers' acceleration modes as one table: which parameter makes which kind of motion speed up how,
// before interpolation or after it. Read by AccelerationRules, printed by `headstock profile P
// --acceleration`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace headstock::operation {

/// What a move's acceleration is chosen by. `retreat`: a positioning away from a thread; a control that has nothing of its
/// own for it goes as in any positioning.
enum class MotionKind : std::uint8_t { rapid, cutting, cutting_ahead, thread, retreat, jog, handle };
inline constexpr std::size_t kMotionKinds = 7, kProgramKinds = 5;  // those of programs come first

/// What the value of a parameter means.
enum class AccelerationUnit : std::uint8_t {
  // ---- before interpolation: the path stays as programmed
  acceleration,     ///< mm/s² of an axis
  time_to_rapid,    ///< ms from standing to the axis' rapid rate
  time_to_feed,     ///< ms from standing to the feed of the move
  time_to_highest,  ///< ms from standing to the axis' highest cutting feed
  mean,             ///< (m/min)/s along the path
  s_to_rapid,       ///< ms as time_to_rapid, half of it with growing and half with shrinking acceleration
  s_to_highest,     ///< the same to the highest cutting feed
  bell,             ///< ms in which the acceleration itself rises and falls
  // ---- after interpolation: each axis lags, corners are cut
  after_linear,      ///< ms from one speed to another
  after_bell,        ///< the same, half of it with growing and half with shrinking acceleration
  after_exponential  ///< ms until 63 % of a change of speed is done
};
enum class Ramp : std::uint8_t { both, up, down };

/// A bit that has to stand so for a row to count; an empty one always counts.
struct ModeBit {
  std::string_view bit;  ///< ends in '/': one for each axis
  bool on = true;
  bool unset = false;  ///< what it is when nobody has set it
};

struct AccelerationRow {
  std::string_view profile;  ///< beginning of its name
  MotionKind kind;
  Ramp ramp;
  std::string_view parameter;  ///< ends in '/': one for each axis
  char axis;                   ///< otherwise the axis it is for; 0: all
  AccelerationUnit unit;
  ModeBit first = {}, second = {};
};
std::span<const AccelerationRow> acceleration_rows();

/// A setting that asks for what is not done: said when a program starts, never passed over in silence.
struct AccelerationGap {
  std::string_view profile, parameter;
  std::string_view instead;
};
std::span<const AccelerationGap> acceleration_gaps();

// ---- in words, for people
std::string_view name_of(MotionKind kind);
std::string_view curve_of(AccelerationUnit unit);
/// "before", "after" (interpolation)
std::string_view place_of(AccelerationUnit unit);
std::string_view value_of(AccelerationUnit unit);

}  // namespace headstock::operation

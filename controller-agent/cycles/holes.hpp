// Hole cycles: drilling, pecking, boring, tapping, as lists of moves along the drilling axis.
#pragma once

#include <cstdint>

#include "cycles/generator.hpp"
#include "interpreter/canonical.hpp"

namespace headstock::cycles {

enum class HoleIn : std::uint8_t {
  once,
  pecks_back,      ///< after each peck a little back (high-speed pecking)
  pecks_out,       ///< after each peck out to R, then rapidly to a clearance above the last depth
  pecks_out_feed,  ///< after each peck out to R and fed down again from there (200T)
  up               ///< back boring: fed from the bottom toward the spindle
};
enum class HoleBottom : std::uint8_t { nothing, dwell, spindle_stop, orient_shift, operator_out };
enum class HoleOut : std::uint8_t { rapid, feed };
enum class HoleTap : std::uint8_t { none, right, left };

/// What one code does; see the tables in hole_codes.cpp.
struct HoleKind {
  HoleIn in = HoleIn::once;
  HoleBottom bottom = HoleBottom::nothing;
  HoleOut out = HoleOut::rapid;
  HoleTap tap = HoleTap::none;
};

struct Hole {
  HoleKind kind;
  double initial = 0, reference = 0, bottom = 0;  ///< levels along the drilling axis, slide mm
  bool to_reference = false;                      ///< ends at R (G99), otherwise at the initial level
  double peck = 0;                                ///< Q > 0
  double clearance = 0;                           ///< d: back after a peck, or above the last depth
  double dwell_s = 0;
  double shift_u = 0, shift_v = 0;  ///< away from the wall at the bottom (G76, G87)
  interp::SpindleDirection turning = interp::SpindleDirection::cw;  ///< before the cycle
  bool main_turns = true;     ///< otherwise the ladder alone is told: the main spindle may be clamped
  std::int32_t driven_m = 0;  ///< M code that started the driven tool (two in a row: cw, ccw, stop); 0: none
  bool dwell_at_reference = true;    ///< of a floating tap, before it turns forward again
  bool stop_before_reversal = true;  ///< M05 goes out before M03/M04 of a tap
  // ---- tapping synchronised with the spindle
  bool synchronous = false;
  bool stands_after = false;  ///< the spindle is stopped when the tap is out (2000TC)
  bool follows = false;       ///< the axis follows the encoder of a free spindle
  double pitch_mm = 0;
  bool pecks_from_retract = false;  ///< the next peck counts from where the tap came out to (200T)
  double tap_out_ratio = 1;         ///< spindle and feed on the way out, against the way in
  double out_ratio = 1;             ///< feed on the way out of a bore, against F
  bool tap_pecks_out = false;       ///< pecks of a tap go back to R, otherwise by `clearance`
};

struct HoleMove {
  enum class Kind : std::uint8_t {
    rapid,
    feed,
    dwell,
    spindle,
    orient,
    shift,
    tap,
    speed,  ///< of the spindle, against S
    operator_stop,
    refused  ///< the overload signal does not go away: an alarm
  } kind = Kind::rapid;
  double to = 0;            ///< along the drilling axis; of a tap: where it comes out to
  double bottom = 0;        ///< of a tap
  double seconds = 0;       ///< of a dwell, of a tap's bottom
  double feed_ratio = 1;    ///< of a feed, against F
  double feed_mm_min = 0;   ///< of a feed that has its own; 0: F
  double speed_ratio = 1;   ///< of a speed
  bool senses = false;      ///< of a feed: the overload signal ends it (small holes)
  bool retracts = false;    ///< of a feed: out of a small hole, to be counted
  bool overloaded = false;  ///< … for the overload signal
  double u = 0, v = 0;      ///< of a shift: from the hole's centre, slide mm
  interp::SpindleDirection direction =
      interp::SpindleDirection::stop;  ///< of a spindle command; of a tap: inward
};

using HoleMoves = Generator<HoleMove>;

/// From the hole's position at the initial level. Bound: 4 moves a peck + 12.
HoleMoves drill(Hole job);

}  // namespace headstock::cycles

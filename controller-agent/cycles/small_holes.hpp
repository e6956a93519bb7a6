// Small-hole pecking of the 0i-M (G83 behind the M code of No.5163, bit SPK 8132#4): a peck ends at its depth
// or when the arbor's overload signal (the skip input) comes; the tool goes out, feed and spindle speed are
// changed, and the hole is taken up again where it was left. The signal is an input like any other: it can be
// simulated.
#pragma once

#include <cstdint>
#include <optional>

#include "cycles/holes.hpp"
#include "interpreter/executor.hpp"

namespace headstock::cycles {

/// By how much feed and spindle speed change from one peck to the next: ratios, > 0.
struct PeckChange {
  double feed = 1, speed = 1;
};

struct SmallHole {
  double initial = 0, reference = 0, bottom = 0;  ///< levels along the drilling axis, slide mm
  bool to_reference = false;
  double peck = 0;       ///< Q > 0
  double clearance = 0;  ///< No.5174: so far above the last depth the peck begins
  double dwell_s = 0;
  double advance_mm_min = 0, retract_mm_min = 0;  ///< I, otherwise No.5173 and No.5172; 0: F
  PeckChange overloaded, clean;                   ///< behind a peck with the signal, without it
  double least_feed = 0;                          ///< No.5168: below this ratio nothing is changed any more
};

/// What the machine answered to the last peck.
struct Overload {
  bool came = false;
  double at = 0;  ///< where along the drilling axis, slide mm
};

/// Retractions without any progress before the cycle gives up: the signal does not go away.
inline constexpr int kMostInVain = 20;

/// @param seen outlives the moves; set before the move after one with `HoleMove::senses` is taken
HoleMoves small_hole(SmallHole job, const Overload* seen);

/// The job of a G83 from its words and parameters. @return nullopt after an alarm.
std::optional<SmallHole> small_hole_job(interp::Executor& ex, const Hole& hole);

}  // namespace headstock::cycles

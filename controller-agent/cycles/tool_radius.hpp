// The tool's radius inside turning cycles, where a control counts it there (0i-D K.49: G70-G73 always; GSK:
// G90 and G94). Elsewhere the vector is dropped on the way to the cycle's start, see compensation/README.md.
#pragma once

#include "cycles/profile.hpp"
#include "cycles/single.hpp"
#include "interpreter/pipeline.hpp"

namespace headstock::cycles {

/// Roughing follows the path that the tip takes beside the profile: a start-up in the first block, square to
/// the contour's first and last block. @return false after the alarm of compensation.
bool offset_profile(interp::Executor& ex, const Rules& rules, const interp::CompensationMode& mode,
                    Profile& profile);

/// The cut of G90 or G94 with the nose's centre beside both of its legs, on the side of the start point
/// whatever G41 or G42 says (GSK218T L8187, GSK2000TC L6862).
struct BesideBox {
  double radius = 0;  ///< mm, > 0
  Point tip;          ///< from the nose's centre to the imaginary tip
};
/// 4 moves, as box_cut.
Moves box_cut_beside(Box job, BesideBox tool);

}  // namespace headstock::cycles

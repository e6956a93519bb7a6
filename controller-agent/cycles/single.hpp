// One-pass turning cycles: G90, G94 (boxes), G92 (one thread pass), G74, G75 (pecking).
#pragma once

#include <cstdint>

#include "cycles/move.hpp"

namespace headstock::cycles {

struct Box {
  Point start, end;
  double taper = 0;     ///< start of the cut minus its end: radius in turning, along u in facing [mm]
  bool facing = false;  ///< G94
};

/// 4 moves: rapid to the start of the cut, cut, out at feed, rapid back.
Moves box_cut(Box job);

/// How a thread ends before its end point: the tool leaves over `length` along the long axis and `height`
/// across.
struct Runout {
  double length = 0, height = 0;  ///< mm, ≥ 0; length 0: none
};

struct ThreadPass {
  Point start;              ///< where the tool stands and comes back to
  Point end;                ///< root at the end
  double taper = 0;         ///< radius at the start minus radius at the end
  double lead_mm = 0;       ///< along the longer axis
  double angle_deg = 0;     ///< spindle angle of the first start
  std::int64_t starts = 1;  ///< ≥ 1: the pass is made once for each, evenly around the spindle
  Runout runout;
  double shift = 0;   ///< the thread begins this much further along than the start point (flank infeed)
  double run_in = 0;  ///< 200T K: the tool goes in obliquely from this height [mm, radius]
  /// K2000TC G76: quarter circles of this radius lead onto the thread and off it, in place of the run-out; 0: none.
  double arc_in = 0, arc_out = 0;
};

/// How far the path on an arc at a thread's end may depart from the circle.
inline constexpr double kThreadChord_mm = 0.002;
/// Where an arc begins (`onto`) or ends, across: the tool must stand further out. On cones a little more than the radius.
double arc_height(const ThreadPass& job, bool onto);

/// At most 6 moves a start, and the chords of its arcs.
Moves thread_pass(ThreadPass job);

struct Pecking {
  Point start, end;
  double step = 0;            ///< across, > 0 when start and end differ across
  double peck = 0;            ///< along the pecks; 0: in one go
  double back = 0;            ///< e: retract after a peck
  double relief = 0;          ///< Δd: away at the bottom, before the way out
  double relief_sign = 0;     ///< direction of the relief where nothing steps; 0: toward plus
  bool across_first = false;  ///< G75: pecks along the second axis
  bool full_retract = false;  ///< back to the start point after every peck (K2000TC G74S)
};

/// Bound: columns × (2 × pecks + 4).
Moves pecking(Pecking job);

}  // namespace headstock::cycles

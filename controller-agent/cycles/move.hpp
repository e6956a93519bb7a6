// What planners make: moves of a cycle in plane coordinates, before offsets, feeds and records. A planner is
// a pure function of its inputs; the number of its moves has a bound that is known before the first one.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cycles/generator.hpp"
#include "cycles/geometry.hpp"

namespace headstock::cycles {

enum class MoveKind : std::uint8_t { rapid, feed, arc, thread, dwell };

/// One move of a turning cycle.
struct Move {
  MoveKind kind = MoveKind::rapid;
  bool along_u = false, along_v = false;  ///< axes that move; the others stay
  Point to{};                             ///< mm from the work zero, slide
  Point center{};                         ///< of an arc
  double sweep = 0;                       ///< of an arc, radians, > 0 counter-clockwise from u to v
  double lead_mm = 0;                     ///< of a thread, along its longer axis
  double angle_deg = 0;                   ///< of a thread: spindle angle at its start
  double run_up_mm = 0;                   ///< of a thread, see interp::Thread
  double seconds = 0;                     ///< of a dwell
  bool ends_pass = false;                 ///< the tool is back for the next cut
};

using Moves = Generator<Move>;

inline Move move_both(MoveKind kind, Point to) {
  return {.kind = kind, .along_u = true, .along_v = true, .to = to};
}
inline Move move_u(MoveKind kind, double u) {
  return {.kind = kind, .along_u = true, .to = {u, 0}};
}
inline Move move_v(MoveKind kind, double v) {
  return {.kind = kind, .along_v = true, .to = {0, v}};
}
inline Move ending_pass(Move move) {
  move.ends_pass = true;
  return move;
}
/// A segment of a contour at cutting feed.
Move along(const Segment& s);
Move back(const View& view, Move seen);

}  // namespace headstock::cycles

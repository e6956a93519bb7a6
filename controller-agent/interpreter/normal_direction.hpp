// G41.1 G42.1: a rotary axis about Z keeps a tool (knife, scraper) square to the path in the XY plane. The
// angle is that of the path as it is really run, so the moves are turned where they leave the interpreter,
// behind chamfers and cutter compensation. The mode rides on every move (its modal group); no state of the
// blocks is needed.
//
// Before a move whose first direction is another one the axis turns alone, the shorter way, at the feed of
// No.5481 (at rapid before a rapid); along an arc it turns with it. Moves shorter than No.5483, and arcs of a
// smaller diameter, keep the angle of the move before. G41.1: 90 degrees ahead (counter-clockwise) of the
// direction of travel, G42.1: 90 degrees behind it; 0 is the direction of +X. Source: 0i-D d1 4.14, PS1470;
// the angle is the manual's figure L69586.
//
// One object a path, the interpreter's thread.
#pragma once

#include <cstddef>

#include "interpreter/canonical.hpp"
#include "interpreter/interpreter.hpp"

namespace headstock::interp {

struct Executor;

class NormalDirection {
 public:
  /// G41.1 and G42.1: reads the parameters. @return false after the controller's alarm.
  bool begin(Executor& ex);
  /// G40.1: the program goes on from the angle where the axis stands. @return false after an alarm.
  bool end(Executor& ex);
  bool on() const { return on_; }
  /// Whether a block may not command the axis now.
  bool holds(std::size_t axis) const { return on_ && axis == axis_; }
  /// Takes what the interpreter made; the move it wants turned may become two operations.
  Pull pull(Executor& ex, Operation& out);
  /// The axes were brought elsewhere: cycle start, RESET, a skip.
  void stand(const Executor& ex);

 private:
  /// @return whether `alone_` must go out before `move`
  bool turn(const Executor& ex, Operation& move);
  void show(const Executor& ex, Motion& motion) const;
  bool on_ = false;       ///< G41.1 or G42.1 is in force
  bool known_ = false;    ///< it has been: what follows is set
  bool waiting_ = false;  ///< `next_` is to go out
  Operation next_, alone_;
  std::size_t axis_ = 0;
  double feed_deg_min_ = 0, least_mm_ = 0;
  AxisVector last_machine_{}, last_work_{};  ///< end of the last move
  double angle_deg_ = 0;                     ///< of the axis, machine coordinates
};

}  // namespace headstock::interp

// The motion kernel of one path: moves go in, a set-point for every axis comes out each period. It knows nothing of
// G code. Two threads use it: the look-ahead thread pushes and plans, the real-time thread steps; in virtual time one
// thread does both, with the same result bit for bit.
#pragma once

#include <cstdint>
#include <memory>
#include <variant>

#include "machine/machine.hpp"

namespace headstock::motion {

using machine::AxisVector;

/// Straight in all axes.
struct Line { AxisVector end{}; };

/// Circle, helix or spiral in the plane of two axes; the others move linearly with the angle.
struct Arc {
  AxisVector end{};
  std::uint8_t axis_1 = 0;     ///< first axis of the plane
  std::uint8_t axis_2 = 1;     ///< second axis of the plane
  double center_1 = 0;         ///< mm, machine coordinates
  double center_2 = 0;
  double angle_rad = 0;        ///< signed sweep: > 0 turns axis_1 toward axis_2
};

/// The path feed a move asks for.
struct PathFeed { double mm_s = 0; };
/// Feed bound to the spindle's actual speed (G99/G95).
struct RevolutionFeed { double mm_rev = 0; };
/// Each axis at its rapid rate at most; straight.
struct RapidFeed {};
/// Thread: position along the move bound to the spindle's phase.
struct ThreadFeed { double lead_mm = 0; double lead_change_mm = 0; double start_angle_rad = 0; };

struct Move {
  std::uint64_t tag = 0;       ///< rides on the move; Sample::tag says whose geometry is being traced
  std::variant<Line, Arc> geometry;
  std::variant<PathFeed, RevolutionFeed, RapidFeed, ThreadFeed> feed;
  bool exact_stop = false;     ///< stop at the end; no rounding there
  double tolerance_mm = 0.01;  ///< how far the corner at the end may be rounded
};

/// What the operator's panel does, taken over at the next period.
struct Overrides {
  double feed = 1;             ///< 0…2.54
  double rapid = 1;            ///< 0…1
  bool hold = false;           ///< feed hold: shortest stop inside the limits, path kept
  bool dry_run = false;
};

/// One period's result.
struct Sample {
  AxisVector position{};       ///< commanded, machine coordinates [mm, degrees]
  AxisVector velocity{};       ///< mm/s
  std::uint64_t tag = 0;       ///< of the move being traced; the last one when standing
  double path_speed_mm_s = 0;
  AxisVector distance_to_go{}; ///< to the end of the move being traced
  bool moving = false;         ///< false: at rest
  bool queue_empty = false;    ///< nothing left to trace
};

class Kernel {
 public:
  explicit Kernel(const machine::Machine& machine);
  ~Kernel();
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;

  /// Standing at this position with an empty queue.
  void set_position(const AxisVector& position);

  // ---- look-ahead thread
  /// Room for one more move? Look-ahead holds at least 2,000.
  bool can_push() const;
  /// Appends a move that starts where the last one ended. Precondition: can_push().
  void push(const Move& move);
  /// Nothing more comes for now (dwell, M code, end): the last move pushed ends at rest.
  void finish();
  /// Does a bounded piece of planning. @return true when there may be more to do at once.
  bool plan();

  // ---- real-time thread: no allocation, lock, system call or exception
  Sample step(const Overrides& overrides, double spindle_phase_rad, double spindle_rpm);
  /// Ramp down inside the limits, then drop everything queued. `aborted()` tells when the axes stand.
  void abort();
  bool aborted() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace headstock::motion

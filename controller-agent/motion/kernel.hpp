// The motion kernel of one path: moves go in, a set-point for every axis comes out each period. It knows
// nothing of G code. Two threads use it: the look-ahead thread pushes and plans, the real-time thread steps;
// in virtual time one thread does both, with the same result bit for bit. README.md explains how it works and
// what it guarantees.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <variant>

#include "machine/machine.hpp"
#include "motion/axis_filter.hpp"

namespace headstock::motion {

using machine::AxisVector;

/// Straight in all axes.
struct Line {
  AxisVector end{};
};

/// Circle, helix or spiral in the plane of two axes; the others move linearly with the angle.
struct Arc {
  AxisVector end{};         ///< in the plane: its distance from the centre gives the end radius (spiral)
  std::uint8_t axis_1 = 0;  ///< first axis of the plane
  std::uint8_t axis_2 = 1;  ///< second axis of the plane
  double center_1 = 0;      ///< mm, machine coordinates
  double center_2 = 0;
  double angle_rad = 0;  ///< signed sweep: > 0 turns axis_1 toward axis_2; |angle| > 2π: several turns
};

/// The path feed a move asks for, over all its axes [mm/s, degrees counted like mm]. > 0.
struct PathFeed {
  double mm_s = 0;
};
/// Feed bound to the spindle's actual speed (G99/G95).
struct RevolutionFeed {
  double mm_rev = 0;  ///< > 0
  /// The speed the spindle is meant to have; what is ahead is planned for it. The feed follows the actual
  /// speed up to kMaxOverride times this. 0: the machine's highest.
  double reference_rpm = 0;
};
/// Each axis at its rapid rate at most; straight.
struct RapidFeed {};
/// Thread: position along the move bound to the spindle's phase. Overrides and feed hold do not act in a
/// thread; abort does. Threads that follow one another without exact stop form one chain with one start.
struct ThreadFeed {
  double lead_mm = 0;          ///< > 0, along the axis that moves most
  double lead_change_mm = 0;   ///< per revolution (G34)
  double start_angle_rad = 0;  ///< spindle phase at which the tool would leave the start point at full speed
};

struct Move {
  std::uint64_t tag = 0;  ///< rides on the move; Sample::tag says whose geometry is being traced
  std::variant<Line, Arc> geometry;
  std::variant<PathFeed, RevolutionFeed, RapidFeed, ThreadFeed> feed;
  bool exact_stop = false;     ///< stop at the end; no rounding there
  double tolerance_mm = 0.01;  ///< how far the corner at the end may be rounded; 0 is an exact stop
  bool block_end = true;       ///< the program's block ends with this move: single block may stop here
  bool skip = false;           ///< the skip signal ends this move (G31); give it an exact stop
  double highest_mm_s = 0;     ///< along the path, at any override; 0: only what the axes can do. Not for threads
  double corner_mm_s = 0;      ///< where it meets the next move, at any override; 0: only what the axes can do
  double speed_up_mm_s2 = 0;   ///< acceleration along the path at most; 0: only what the axes can do
  double slow_down_mm_s2 = 0;  ///< the same when braking, whatever for
  bool free_path = false;      ///< non-interpolated positioning: how the axes get there is not programmed
  std::uint8_t shape = 0;      ///< of Kernel::set_shapes(); between moves of different shapes the axes stop
};

/// The feed is never raised above this, whatever the switch says (0…254 % is the widest of the controllers'
/// ranges).
inline constexpr double kMaxOverride = 2.54;

/// What the operator's panel does, taken over at the next period.
struct Overrides {
  double feed = 1;    ///< 0…kMaxOverride
  double rapid = 1;   ///< 0…1
  bool hold = false;  ///< feed hold: stop inside the limits, path kept; released: goes on
  /// Stop where the block being traced ends; in the first block end the axes can still stop at where that one
  /// is too near. The path is kept: at a rounded corner they stand on the rounding.
  bool single_block = false;
  std::uint32_t go = 0;      ///< each change lets one single-block stop go on
  bool skip_signal = false;  ///< latches the position and ends a move that has `skip`
  /// The drives have come to what they were commanded: only then goes it on behind an exact stop.
  bool in_position = true;
};

/// One period's result.
struct Sample {
  AxisVector position{};        ///< commanded, machine coordinates [mm, degrees]
  AxisVector velocity{};        ///< mm/s, over the last period
  std::uint64_t tag = 0;        ///< of the move being traced; the last one when standing
  double path_speed_mm_s = 0;   ///< along the path, over the last period
  AxisVector distance_to_go{};  ///< to the end of the move being traced
  bool moving = false;          ///< false: at rest
  bool queue_empty = false;     ///< nothing planned is left to trace
  bool starved = false;         ///< standing or braking because no more moves came, without finish()
  bool block_stopped = false;   ///< standing at a block end because of single block, until `go` changes
  bool skipped = false;         ///< the skip signal came; the axes brake, then everything queued is dropped
  AxisVector skip_position{};   ///< commanded position in the period it came
  bool threading = false;       ///< bound to the spindle's phase
  double thread_error_mm = 0;   ///< threading: how far ahead (+) of the spindle the tool is, along the path
};

class Kernel {
 public:
  /// Moves the queue takes before can_push() says no.
  static constexpr std::size_t kQueueMoves = 4096;

  static constexpr std::size_t kShapes = 5;
  using Shapes = std::array<AccelerationShape, kShapes>;

  explicit Kernel(const machine::Machine& machine);
  ~Kernel();
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;

  // ---- look-ahead thread
  /// What Move::shape is about, from the next set_position() on.
  void set_shapes(const Shapes& shapes);
  /// Standing at this position with an empty queue; also what ends an abort. Precondition: at rest.
  void set_position(const AxisVector& position);
  /// Room for one more move?
  bool can_push() const;
  std::size_t room() const;
  /// Appends a move that starts where the last one ended. Precondition: can_push(); a move too many is an abort(),
  /// so that nothing is ever traced that was not programmed. After an abort call set_position() first; a move of no
  /// length is kept for its tag and exact stop only.
  void push(const Move& move);
  /// Nothing more comes for now (dwell, M code, end): the last move pushed ends at rest. Without it the axes
  /// wait short of that end, because its corner with the next move is not known yet.
  void finish();
  /// Does a bounded piece of planning. @return true when there may be more to do at once.
  bool plan();

  // ---- real-time thread: no allocation, lock, system call or exception
  /// One period. @param spindle_phase_rad grows without wrapping while the spindle turns forward.
  Sample step(const Overrides& overrides, double spindle_phase_rad, double spindle_rpm);

  // ---- any thread
  /// Ramp down inside the limits, then drop everything queued. `aborted()` tells when the axes stand. A skip
  /// does the same by itself.
  void abort();
  bool aborted() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace headstock::motion

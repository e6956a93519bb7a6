// From canonical motion to the kernel's moves: geometry, feed, corners, and the check of the travel limits
// before a move is handed over. Look-ahead thread only.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "axes/travel_limits.hpp"
#include "interpreter/canonical.hpp"
#include "machine/machine.hpp"
#include "motion/kernel.hpp"
#include "operation/acceleration.hpp"
#include "operation/corner_override.hpp"
#include "operation/free_path.hpp"
#include "operation/retrace.hpp"
#include "operation/speed_limits.hpp"
#include "operation/tag_ring.hpp"
#include "operation/zone_clearance.hpp"

namespace headstock::operation {

/// Switches that change how a move is made, fixed for one run.
struct FeedRules {
  bool dry_run = false;
  double dry_run_mm_min = 1'000;  ///< FANUC No. 1410
  SpeedLimits speeds;
  CornerOverrideRules inner_corners;
  AccelerationRules accelerations;
};

/// Is it one of Rapid, Feed, Arc, Thread?
bool is_motion(const interp::Operation& operation);
const interp::Motion& motion_of(const interp::Operation& operation);
/// Do these come from different blocks of the program?
bool blocks_differ(const interp::SourcePosition& a, const interp::SourcePosition& b);
/// The kernel's geometry of a canonical arc.
motion::Arc arc_geometry(const machine::Machine& machine, const interp::Arc& arc);

class MotionFeed {
 public:
  MotionFeed(const machine::Machine& machine, motion::Kernel& kernel, TagRing& tags)
      : machine_(machine),
        kernel_(kernel),
        tags_(tags),
        clearance_(machine),
        inner_corners_(machine.axes.size(), [this](const AxisVector& start, const motion::Move& move) {
          kernel_.push(move);
          if (history_ != nullptr) history_->record(start, move);
          if (observer_) observer_(move);
        }) {}
  MotionFeed(const MotionFeed&) = delete;
  MotionFeed& operator=(const MotionFeed&) = delete;

  /// The axes stand here and nothing is queued.
  void set_position(const AxisVector& position);
  void set_rules(const FeedRules& rules) {
    rules_ = rules;
    inner_corners_.set_rules(rules.inner_corners);
    look_ahead_ = false;
  }
  /// G08, G05.1: what follows is under look-ahead control, or not.
  void set_look_ahead(bool on) { look_ahead_ = on; }

  /// Stored stroke checks 2 and 3 that are in force for what follows.
  void set_zones(std::vector<axes::Zone> zones) { clearance_.set(std::move(zones)); }

  /// Room for one more operation? `traced`: tag being traced.
  bool has_room(std::uint64_t traced) const {
    // Before the first move since the position was set nothing is traced, and nothing older is needed.
    // One operation is several moves, and what was held back goes before them.
    return kernel_.room() > kMostFreePieces + 2 * inner_corners_.kept() &&
           tags_.has_room(std::max(traced, tag_when_set_));
  }

  /// PS0148: G62 needs its parameters (No. 1711, 1712).
  std::optional<MachineAlarm> corner_override_refusal(const interp::Operation& operation) const;

  /// The kernel's move for an operation; nothing is handed over. Precondition: is_motion().
  motion::Move make(const interp::Operation& operation) const;
  /// In which time the acceleration of a move rises and falls, by the parameters of the controller [s].
  double bell_s(const motion::Move& move) const { return rules_.accelerations.shapes()[move.shape].bell_s; }
  /// Its acceleration by the parameters of the controller.
  /// @param away a positioning: from a thread, with this share of the acceleration; 0: not from a thread
  void limit_acceleration(motion::Move& move, const interp::ModalSnapshot& modal, double away = 0) const;
  /// The moves of an operation: several for a positioning that is not interpolated (0i-D No. 1401#1 = 0),
  /// where every axis goes at its own rapid rate until it is there; otherwise one.
  std::vector<motion::Move> moves(const interp::Operation& operation) const;
  /// Hands a move to the kernel. Precondition: has_room(), is_motion().
  /// @return what limit it would pass: then only the part before the limit has been handed over, with a stop
  /// at its end.
  std::optional<axes::Overtravel> add(const interp::Operation& operation, std::uint64_t main_offset);

  /// The next move is not known yet (data are waited for): what is held back goes to the kernel.
  void flush();
  /// Something else than a move comes next: the last move ends at rest.
  void finish();

  /// What the kernel gets is kept here, for retracing it.
  void set_history(Retrace* history) { history_ = history; }
  /// Called with every move as the kernel gets it. For virtual time: judging the commanded path.
  void on_move(std::function<void(const motion::Move&)> observer) { observer_ = std::move(observer); }

  /// What rides on a tap, which the kernel does not carry out. Precondition: has_room().
  std::uint64_t add_tag(const interp::Motion& motion, std::uint64_t main_offset);

  /// Tag of the last move handed over; 0 when none since set_position().
  std::uint64_t last_tag() const { return last_tag_; }
  /// Where the last move ends.
  const AxisVector& position() const { return position_; }

 private:
  CuttingSide side_of(const interp::Motion& motion) const;
  /// Near a forbidden zone: at the programmed corners exactly, at both ends.
  void keep_clear(motion::Move& move);
  /// The move held back goes on; inner corners may keep it back longer.
  void pass_on();
  /// Limits the held-back move and this one by the parameters of the controller.
  void limit_speed(motion::Move& move, bool cutting);

  const machine::Machine& machine_;
  motion::Kernel& kernel_;
  TagRing& tags_;
  FeedRules rules_;
  AxisVector position_{};
  std::uint64_t last_tag_ = 0, tag_when_set_ = 0;
  // A positioning does not begin before the cut has stopped (0i-D: deceleration at the end of the block
  // before G00), so the end of a move is known only when the next one is.
  std::optional<motion::Move> held_back_;
  std::function<void(const motion::Move&)> observer_;
  AxisVector held_start_{};
  CuttingSide held_side_;
  ZoneClearance clearance_;
  CornerOverride inner_corners_;
  bool look_ahead_ = false;
  bool after_thread_ = false;  // the last move was one
  Retrace* history_ = nullptr;
  interp::SourcePosition held_block_;  // of held_back_
};

}  // namespace headstock::operation

// One interpolation period: the kernel's set-points to the drives, the spindle, and what has to happen
// between moves (dwell, M, S and T functions). Everything the other threads want comes in through atomics,
// everything they may know goes out through a triple buffer.
//
// Between moves: the look-ahead posts one `Interlude` at a time after it has ended the moves before it
// (Kernel::finish). The period that finds the axes at rest and in position there begins it; the look-ahead
// goes on when it is done.
//
// What the drives get in a period:
//   kernel (program) or tap run → + hand (jog, ladder) → emergency ramp → locks → mechanics → drives
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "axes/drive.hpp"
#include "axes/emergency_ramp.hpp"
#include "axes/mechanics.hpp"
#include "axes/polygon.hpp"
#include "axes/supervision.hpp"
#include "axes/tap_run.hpp"
#include "machine/machine.hpp"
#include "motion/kernel.hpp"
#include "operation/hand.hpp"
#include "operation/spindle_control.hpp"
#include "operation/tag_ring.hpp"
#include "operation/triple_buffer.hpp"
#include "plc/auxiliary.hpp"

namespace headstock::operation {

/// What happens between two moves.
struct Interlude {
  enum class Kind : std::uint8_t {
    meeting,   ///< nothing: only the point where everything before is done
    dwell,     ///< for `seconds` and `revolutions`
    function,  ///< `request` to the machine until it is finished
    tap,       ///< `tap`, in and out
    watch,     ///< `watch` from now on
    polygon    ///< coupled or let go
  };
  Kind kind = Kind::meeting;
  double seconds = 0, revolutions = 0;
  plc::Request request;
  std::uint64_t after_tag = 0;     ///< last move before it; 0: none since the axes were set
  bool new_block = false;          ///< the first of its block: single block stops before it
  std::uint16_t skip_signals = 0;  ///< dwell: any of these ends it early
  axes::TapOrder tap;
  std::uint64_t tag = 0;  ///< tap: what rides on it
  axes::SpindleWatch::Order watch;
  axes::Polygon::Order polygon;
  // What #3003 and #3004 say in this block.
  bool not_held = false;     ///< feed hold does not keep it from beginning
  bool not_awaited = false;  ///< the program does not wait for the function to be finished
};

/// One period's outcome, for screens and for the look-ahead.
struct RealtimeState {
  motion::Sample sample;  ///< what the axes are commanded, whoever moves them
  AxisVector base{};      ///< where the kernel is, without what moves beside it
  bool kernel_moving = false;
  AxisVector actual{};                                ///< measured by the drives, compensation left out
  double spindle_rpm = 0, spindle_commanded_rpm = 0;  ///< signed
  plc::Outputs machine;
  bool block_stopped = false;  ///< standing at a block's end because of single block
  std::uint32_t go = 0;        ///< value of Realtime::go in this period
  std::uint64_t periods = 0;
  std::uint64_t run_periods = 0;      ///< automatic operation under way, not counting stop and hold
  std::uint64_t cutting_periods = 0;  ///< of these: moving at a cutting feed
  bool drives_at_rest = true;         ///< and no ramp of an emergency stop is under way
  bool in_position = true;
  std::uint32_t hand_busy = 0;  ///< axes that are moved by hand or by the ladder; bit: axis
  bool second_moving = false;   ///< the second kernel
  bool second_done = true;      ///< it has nothing more to trace
  AxisVector second_position{};
  std::uint64_t second_tag = 0;
  std::uint64_t hand_orders = 0;  ///< taken up
  AxisVector hand_offset{};       ///< what hands and ladder have added to `base`
  std::uint32_t marks_found = 0;  ///< axes that stand on their zero mark after reference return, to be set
  std::uint32_t home_failed = 0;  ///< axes whose search for the zero mark has failed
  bool tap_in_hole = false;       ///< a tap was stopped in its hole
  bool contour = false;           ///< the spindle is the Cs axis
  axes::Fault fault;
  std::uint32_t faults = 0;  ///< grows with each fault
};

class Realtime {
 public:
  Realtime(const machine::Machine& machine, motion::Kernel& kernel, const TagRing& tags,
           std::unique_ptr<axes::Drive> drive, std::unique_ptr<plc::Auxiliary> machine_functions);

  // ---- switches, any thread
  std::atomic<double> feed_override{1}, rapid_override{1}, spindle_override{1};
  std::atomic<double> rapid_f0{0};   ///< of the rapid rate, at a rapid override of 0 (F0)
  std::atomic<bool> hold{false};     ///< feed hold
  std::atomic<bool> brake{false};    ///< stops the moves like feed hold; the controller's own, not the operator's
  std::atomic<bool> running{false};  ///< counts run time
  std::atomic<bool> single_block{false};
  std::atomic<std::uint32_t> go{0};            ///< one more: a single-block stop goes on
  std::atomic<std::uint16_t> skip_signals{0};  ///< SKIP, SKIP2 … as they are now
  std::atomic<bool> machine_lock{false};       ///< drives keep their place
  std::atomic<std::uint32_t> axis_lock{0};     ///< the same for single axes; bit: axis
  std::atomic<std::uint32_t> homed{~0u};       ///< axes whose coordinates are true: stroke limits hold
  /// Every axis brakes by its own deceleration, then the drives go off; the spindle runs down.
  std::atomic<bool> emergency_stop{false};
  std::atomic<std::uint64_t> overruns{0};  ///< periods that came too late, counted by the caller of step()

  // ---- look-ahead thread
  /// Precondition: idle().
  void post(const Interlude& interlude);
  /// Nothing posted, or what was posted is done.
  bool idle() const {
    return done_.load(std::memory_order_acquire) == posted_.load(std::memory_order_relaxed);
  }
  /// The kernel has planned everything before the posted interlude.
  void planned() { planned_.store(posted_.load(std::memory_order_relaxed), std::memory_order_release); }

  /// Brings the axes to rest inside their limits, drops the interlude, stops spindle and coolant.
  void request_abort();
  /// The axes stand after request_abort(); the kernel is not stepped until abort_over().
  bool aborted() const {
    return stopped_.load(std::memory_order_acquire) == abort_.load(std::memory_order_relaxed);
  }
  /// The kernel has got its new position (Kernel::set_position).
  void abort_over();

  /// Keeps the kernel from being stepped, everything standing, so that it can be given a new position.
  void request_park();
  bool parked() const {
    return parked_.load(std::memory_order_acquire) == park_.load(std::memory_order_relaxed);
  }
  /// The kernel has got `position`. @param taken_over axes whose offset by hand is part of it now
  /// @param marks axes that stand on their zero mark and are called `position` from now on
  void unpark(const AxisVector& position, std::uint32_t taken_over, std::uint32_t marks = 0);
  /// The kernel keeps its position after all; what is beside it stays beside it.
  void cancel_park();
  /// A second kernel that moves all axes while the program's stands; nullptr: none. It begins where that
  /// stands.
  std::atomic<motion::Kernel*> second_kernel{nullptr};
  Hand& hand() { return hand_; }

  /// One reader at a time (the controller's lock). A copy: what is behind the buffer's reference changes with the next
  /// call, and whoever holds one state may call somebody who asks for another.
  RealtimeState state() { return buffer_.read(); }

  // ---- real-time thread
  void step() noexcept;
  axes::SimulatedSpindle& spindle() { return spindle_.spindle(); }
  axes::Drive& drive() { return *drive_; }
  /// The period just made; real-time thread or a single-threaded caller.
  const RealtimeState& now() const { return state_; }

 private:
  void step_interlude() noexcept;
  void step_kernel(bool set_anew) noexcept;
  void take_new_position() noexcept;
  void step_beside(bool emergency) noexcept;
  void step_second() noexcept;
  void step_spindle(bool emergency) noexcept;
  void step_drives(bool locked, bool emergency) noexcept;
  void step_abort() noexcept;
  void supervise() noexcept;
  void raise(const axes::Fault& fault) noexcept;
  void end_beside() noexcept;
  bool guard_travel() noexcept;
  void begin(const Interlude& interlude) noexcept;
  bool finished() noexcept;
  motion::Overrides overrides() const noexcept;
  /// Does single block keep the posted interlude from beginning?
  bool stands_before(std::uint64_t posted) noexcept;

  const std::size_t axes_;
  const double period_s_;
  const machine::Machine& machine_;
  const std::size_t surface_axis_;  // whose distance from the centre makes surface speed, where none is named
  const int contour_axis_;          // index, -1: none
  std::uint32_t ladder_axes_ = 0;   // bit: axis
  motion::Kernel& kernel_;
  const TagRing& tags_;
  std::unique_ptr<axes::Drive> drive_;
  std::unique_ptr<plc::Auxiliary> functions_;
  SpindleControl spindle_;
  axes::Mechanics mechanics_;
  axes::AxisSupervision supervision_;
  axes::SpindleWatch watch_;
  axes::EmergencyRamp ramp_;
  axes::TapRun tap_;
  axes::Polygon polygon_;
  Hand hand_;

  Interlude posted_interlude_;
  std::atomic<std::uint64_t> posted_{0}, planned_{0}, done_{0};
  std::atomic<std::uint64_t> abort_{0}, stopped_{0}, released_{0};
  std::atomic<std::uint64_t> park_{0}, parked_{0}, unparked_{0};
  AxisVector park_position_{};
  std::uint32_t park_marks_ = 0, park_taken_over_ = 0;
  bool park_cancelled_ = false;

  // real-time thread only
  RealtimeState state_;
  std::uint64_t begun_ = 0, abort_seen_ = 0, release_seen_ = 0, unpark_seen_ = 0;
  double tap_from_ = 0;
  bool tap_shown_ = false;  // the tap's axis stands where the tap has left it
  bool drives_on_ = true, tripped_ = false, in_fault_ = false;
  AxisVector commanded_{}, velocity_{};
  bool standing_ = false;  // before an interlude, because of single block
  std::uint32_t standing_go_ = 0;
  std::uint64_t let_through_ = 0;  // interlude that the operator let begin
  double remaining_s_ = 0, remaining_rad_ = 0, last_phase_rad_ = 0;
  AxisVector drive_command_{};
  TripleBuffer<RealtimeState> buffer_;
};

}  // namespace headstock::operation

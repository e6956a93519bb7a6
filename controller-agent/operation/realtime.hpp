// One interpolation period: the kernel's set-points to the drives, the spindle, and what has to happen
// between moves (dwell, M, S and T functions). Everything the other threads want comes in through atomics,
// everything they may know goes out through a triple buffer.
//
// Between moves: the look-ahead posts one `Interlude` at a time after it has ended the moves before it
// (Kernel::finish). The period that finds the axes at rest and in position there begins it; the look-ahead
// goes on when it is done.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "axes/drive.hpp"
#include "axes/spindle.hpp"
#include "machine/machine.hpp"
#include "motion/kernel.hpp"
#include "operation/tag_ring.hpp"
#include "operation/triple_buffer.hpp"
#include "plc/auxiliary.hpp"

namespace headstock::operation {

/// What happens between two moves.
struct Interlude {
  enum class Kind : std::uint8_t {
    meeting,  ///< nothing: only the point where everything before is done
    dwell,    ///< for `seconds` and `revolutions`
    function  ///< `request` to the machine until it is finished
  };
  Kind kind = Kind::meeting;
  double seconds = 0, revolutions = 0;
  plc::Request request;
  std::uint64_t after_tag = 0;     ///< last move before it; 0: none since the axes were set
  bool new_block = false;          ///< the first of its block: single block stops before it
  std::uint16_t skip_signals = 0;  ///< dwell: any of these ends it early
};

/// One period's outcome, for screens and for the look-ahead.
struct RealtimeState {
  motion::Sample sample;
  AxisVector actual{};                                ///< measured by the drives
  double spindle_rpm = 0, spindle_commanded_rpm = 0;  ///< signed
  plc::Outputs machine;
  bool block_stopped = false;  ///< standing at a block's end because of single block
  std::uint32_t go = 0;        ///< value of Realtime::go in this period
  std::uint64_t periods = 0;
  std::uint64_t run_periods = 0;      ///< automatic operation under way, not counting stop and hold
  std::uint64_t cutting_periods = 0;  ///< of these: moving at a cutting feed
  bool drives_at_rest = true;
  bool in_position = true;
};

class Realtime {
 public:
  Realtime(const machine::Machine& machine, motion::Kernel& kernel, const TagRing& tags,
           std::unique_ptr<axes::Drive> drive, std::unique_ptr<plc::Auxiliary> machine_functions);

  // ---- switches, any thread
  std::atomic<double> feed_override{1}, rapid_override{1}, spindle_override{1};
  std::atomic<bool> hold{false};     ///< feed hold
  std::atomic<bool> running{false};  ///< counts run time
  std::atomic<bool> single_block{false};
  std::atomic<std::uint32_t> go{0};            ///< one more: a single-block stop goes on
  std::atomic<std::uint16_t> skip_signals{0};  ///< SKIP, SKIP2 … as they are now
  std::atomic<bool> machine_lock{false};       ///< drives keep their place
  std::atomic<bool> emergency_stop{false};     ///< drives off, spindle off
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

  /// One reader at a time (the controller's lock).
  const RealtimeState& state() { return buffer_.read(); }

  // ---- real-time thread
  void step() noexcept;
  /// The period just made; real-time thread or a single-threaded caller.
  const RealtimeState& now() const { return state_; }

 private:
  void step_interlude() noexcept;
  void step_spindle() noexcept;
  void step_drives(bool locked) noexcept;
  void begin(const Interlude& interlude) noexcept;
  bool finished() noexcept;
  motion::Overrides overrides() const noexcept;
  /// Does single block keep the posted interlude from beginning?
  bool stands_before(std::uint64_t posted) noexcept;

  const std::size_t axes_;
  const double period_s_;
  const double max_rpm_;
  const std::size_t surface_axis_;  // whose distance from the centre makes surface speed
  motion::Kernel& kernel_;
  const TagRing& tags_;
  std::unique_ptr<axes::Drive> drive_;
  std::unique_ptr<plc::Auxiliary> functions_;
  axes::SimulatedSpindle spindle_;

  Interlude posted_interlude_;
  std::atomic<std::uint64_t> posted_{0}, planned_{0}, done_{0};
  std::atomic<std::uint64_t> abort_{0}, stopped_{0}, released_{0};

  // real-time thread only
  RealtimeState state_;
  std::uint64_t begun_ = 0, abort_seen_ = 0;
  bool standing_ = false;  // before an interlude, because of single block
  std::uint32_t standing_go_ = 0;
  std::uint64_t let_through_ = 0;  // interlude that the operator let begin
  double remaining_s_ = 0, remaining_rad_ = 0, last_phase_rad_ = 0;
  AxisVector drive_command_{};
  TripleBuffer<RealtimeState> buffer_;
};

}  // namespace headstock::operation

#include "operation/realtime.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace headstock::operation {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kInPosition_mm = 0.02;  // FANUC No. 1826, usual value
constexpr double kAtRest_mm_s = 0.05;
constexpr double kSmallestRadius_mm =
    0.01;  // surface speed at the centre asks for infinite rpm: the clamp decides

}  // namespace

Realtime::Realtime(const machine::Machine& machine, motion::Kernel& kernel, const TagRing& tags,
                   std::unique_ptr<axes::Drive> drive, std::unique_ptr<plc::Auxiliary> machine_functions)
    : axes_(machine.axes.size()),
      period_s_(machine.period_us * 1e-6),
      max_rpm_(machine.spindle.max_rpm),
      surface_axis_(machine.axis_index('X').value_or(0)),
      kernel_(kernel),
      tags_(tags),
      drive_(std::move(drive)),
      functions_(std::move(machine_functions)),
      spindle_(machine.spindle) {
  state_.actual = drive_->actual();
  state_.sample.position = drive_command_ = state_.actual;
  state_.sample.queue_empty = true;
  buffer_.back() = state_;
  buffer_.publish();
}

void Realtime::post(const Interlude& interlude) {
  posted_interlude_ = interlude;
  posted_.store(posted_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

void Realtime::request_abort() {
  abort_.store(abort_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

void Realtime::abort_over() {
  released_.store(abort_.load(std::memory_order_relaxed), std::memory_order_release);
}

void Realtime::step() noexcept {
  // Read before anything else: the lock is taken off after the new position has been set, so who sees it off
  // here gets the new position from the kernel below.
  const bool locked = machine_lock.load(std::memory_order_seq_cst);
  const std::uint64_t abort = abort_.load(std::memory_order_acquire);
  if (abort != abort_seen_) {
    abort_seen_ = abort;
    kernel_.abort();
    functions_->reset();
  }
  const bool resting_after_abort = stopped_.load(std::memory_order_relaxed) == abort_seen_ &&
                                   released_.load(std::memory_order_acquire) != abort_seen_;
  if (!resting_after_abort) {
    const motion::Overrides wanted = overrides();
    state_.go = wanted.go;
    state_.sample = kernel_.step(wanted, spindle_.phase_rad(), std::abs(spindle_.rpm()));
  }
  step_spindle();
  step_drives(locked);
  const bool aborting = stopped_.load(std::memory_order_relaxed) != abort_seen_;
  if (aborting) {
    if (kernel_.aborted() && !state_.sample.moving) {
      standing_ = false;
      begun_ = posted_.load(std::memory_order_acquire);
      done_.store(begun_, std::memory_order_release);
      stopped_.store(abort_seen_, std::memory_order_release);
    }
  } else {
    step_interlude();
  }

  state_.block_stopped = state_.sample.block_stopped || standing_;
  ++state_.periods;
  const bool holding = hold.load(std::memory_order_relaxed) && !state_.sample.moving;
  if (running.load(std::memory_order_relaxed) && !holding) {
    ++state_.run_periods;
    if (state_.sample.moving && tags_.find(state_.sample.tag).cutting) ++state_.cutting_periods;
  }
  state_.machine = functions_->outputs();
  buffer_.back() = state_;
  buffer_.publish();
}

motion::Overrides Realtime::overrides() const noexcept {
  const SegmentState& segment = tags_.find(state_.sample.tag);
  motion::Overrides now;
  now.feed = segment.fixed_feed ? 1 : feed_override.load(std::memory_order_relaxed);
  now.rapid = rapid_override.load(std::memory_order_relaxed);
  now.hold = hold.load(std::memory_order_relaxed) && !segment.not_held;
  now.single_block = single_block.load(std::memory_order_relaxed);
  now.go = go.load(std::memory_order_relaxed);
  now.skip_signal = (segment.skip_signals & skip_signals.load(std::memory_order_relaxed)) != 0;
  return now;
}

bool Realtime::stands_before(std::uint64_t posted) noexcept {
  if (standing_ && state_.go != standing_go_) {
    standing_ = false;
    let_through_ = posted;
  }
  const bool stop = posted_interlude_.new_block && let_through_ != posted && !standing_ &&
                    single_block.load(std::memory_order_relaxed);
  if (stop) {
    standing_ = true;
    standing_go_ = state_.go;
  }
  return standing_;
}

void Realtime::begin(const Interlude& interlude) noexcept {
  remaining_s_ = interlude.seconds;
  remaining_rad_ = interlude.revolutions * kTwoPi;
  last_phase_rad_ = spindle_.phase_rad();
  if (interlude.kind == Interlude::Kind::function) functions_->request(interlude.request);
}

bool Realtime::finished() noexcept {
  switch (posted_interlude_.kind) {
    case Interlude::Kind::meeting:
      return true;
    case Interlude::Kind::function:
      return functions_->finished();
    case Interlude::Kind::dwell: {
      // Feed hold stops the clock of a dwell too; the rest is waited after cycle start.
      const double turned = std::abs(spindle_.phase_rad() - last_phase_rad_);
      last_phase_rad_ = spindle_.phase_rad();
      if (!hold.load(std::memory_order_relaxed)) {
        remaining_s_ -= period_s_;
        remaining_rad_ -= turned;
      }
      if ((posted_interlude_.skip_signals & skip_signals.load(std::memory_order_relaxed)) != 0) return true;
      return remaining_s_ <= period_s_ * 1e-6 && remaining_rad_ <= 1e-9;
    }
  }
  return true;
}

void Realtime::step_interlude() noexcept {
  functions_->step({spindle_.at_speed(), period_s_});
  const std::uint64_t posted = posted_.load(std::memory_order_acquire);
  if (done_.load(std::memory_order_relaxed) == posted) return;
  if (begun_ != posted) {
    const motion::Sample& sample = state_.sample;
    const bool all_traced = sample.queue_empty && !sample.starved &&
                            (posted_interlude_.after_tag == 0 || posted_interlude_.after_tag == sample.tag);
    const bool moves_done = planned_.load(std::memory_order_acquire) == posted && !sample.moving &&
                            (all_traced || sample.skipped);
    if (!moves_done || sample.block_stopped || !state_.in_position || hold.load(std::memory_order_relaxed))
      return;
    if (stands_before(posted)) return;
    begun_ = posted;
    begin(posted_interlude_);
    // A function has its answer in the next period at the earliest; a dwell counts this period's end as its
    // start.
    if (posted_interlude_.kind != Interlude::Kind::meeting) return;
  }
  if (finished()) done_.store(posted, std::memory_order_release);
}

void Realtime::step_spindle() noexcept {
  const plc::Outputs& wanted = functions_->outputs();
  double rpm = wanted.speed;
  if (wanted.constant_surface_speed) {
    const SegmentState& segment = tags_.find(state_.sample.tag);
    const double radius =
        std::abs(state_.sample.position[surface_axis_] - segment.modal.work_zero[surface_axis_]);
    rpm = wanted.speed * 1000 / (kTwoPi * std::max(radius, kSmallestRadius_mm));
  }
  rpm *= spindle_override.load(std::memory_order_relaxed);
  if (wanted.clamp_rpm > 0) rpm = std::min(rpm, wanted.clamp_rpm);
  rpm = std::clamp(rpm, 0.0, max_rpm_) * static_cast<double>(wanted.turning);
  if (emergency_stop.load(std::memory_order_relaxed)) rpm = 0;
  spindle_.command(rpm);
  spindle_.step(period_s_);
  state_.spindle_rpm = spindle_.rpm();
  state_.spindle_commanded_rpm = rpm;
}

void Realtime::step_drives(bool locked) noexcept {
  if (!locked) drive_command_ = state_.sample.position;
  drive_->enable(!emergency_stop.load(std::memory_order_relaxed));
  drive_->command(drive_command_);
  const AxisVector before = state_.actual;
  state_.actual = drive_->actual();
  state_.drives_at_rest = state_.in_position = true;
  for (std::size_t i = 0; i < axes_; ++i) {
    if (std::abs(state_.actual[i] - before[i]) > kAtRest_mm_s * period_s_) state_.drives_at_rest = false;
    if (std::abs(state_.actual[i] - drive_command_[i]) > kInPosition_mm) state_.in_position = false;
  }
}

}  // namespace headstock::operation

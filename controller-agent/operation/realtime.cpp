#include "operation/realtime.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace headstock::operation {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kAtRest_mm_s = 0.05;
constexpr double kGuard_mm = 0.002;  // rounding of a finite difference must not look like passing a limit

axes::Fault fault_of(axes::FaultKind kind, std::size_t axis, bool positive = false) {
  axes::Fault fault;
  fault.kind = kind;
  fault.axis = axis;
  fault.positive = positive;
  return fault;
}

bool servo_fault(axes::FaultKind kind) {
  return kind != axes::FaultKind::spindle_fluctuation && kind != axes::FaultKind::overtravel;
}

}  // namespace

Realtime::Realtime(const machine::Machine& machine, motion::Kernel& kernel, const TagRing& tags,
                   std::unique_ptr<axes::Drive> drive, std::unique_ptr<plc::Auxiliary> machine_functions)
    : axes_(machine.axes.size()),
      period_s_(machine.period_us * 1e-6),
      machine_(machine),
      surface_axis_(machine.axis_index('X').value_or(0)),
      contour_axis_(machine.spindle.contour_axis == 0
                        ? -1
                        : static_cast<int>(machine.axis_index(machine.spindle.contour_axis).value_or(0))),
      kernel_(kernel),
      tags_(tags),
      drive_(std::move(drive)),
      functions_(std::move(machine_functions)),
      spindle_(machine, period_s_),
      mechanics_(machine, period_s_),
      supervision_(machine),
      ramp_(machine, period_s_),
      tap_(machine, period_s_),
      polygon_(machine, period_s_),
      hand_(machine, period_s_) {
  state_.actual = drive_->actual();
  AxisVector home{};
  for (std::size_t i = 0; i < axes_; ++i) {
    home[i] = machine.axes[i].reference_mm;
    if (machine.axes[i].plc) ladder_axes_ |= 1u << i;
  }
  mechanics_.set_position(home);
  state_.sample.position = state_.base = commanded_ = drive_command_ = home;
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

void Realtime::request_park() {
  park_.store(park_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

void Realtime::unpark(const AxisVector& position, std::uint32_t taken_over, std::uint32_t marks) {
  park_cancelled_ = false;
  park_position_ = position;
  park_taken_over_ = taken_over;
  park_marks_ = marks;
  unparked_.store(park_.load(std::memory_order_relaxed), std::memory_order_release);
}

void Realtime::cancel_park() {
  park_cancelled_ = true;
  unparked_.store(park_.load(std::memory_order_relaxed), std::memory_order_release);
}

void Realtime::step() noexcept {
  // Read before anything else: the lock is taken off after the new position has been set, so who sees it off
  // here gets the new position from the kernel below.
  const bool locked = machine_lock.load(std::memory_order_seq_cst);
  const bool emergency = emergency_stop.load(std::memory_order_seq_cst);
  const std::uint64_t abort = abort_.load(std::memory_order_acquire);
  if (abort != abort_seen_) {
    abort_seen_ = abort;
    kernel_.abort();
    if (motion::Kernel* second = second_kernel.load(std::memory_order_acquire)) second->abort();
    functions_->reset();
    tap_.stop();
    hand_.stop();
    polygon_.set({}, spindle_.spindle().phase_rad(), spindle_.spindle().rpm());
    watch_.set({});
  }
  const std::uint64_t before_release = release_seen_;
  if (const std::uint64_t released = released_.load(std::memory_order_acquire); released != release_seen_) {
    release_seen_ = released;
    end_beside();
  }
  const bool released_now = release_seen_ != before_release;
  step_kernel(released_now);
  if (released_now) {  // what was commanded before counts no more
    commanded_ = state_.base;
    mechanics_.take_up(commanded_);
    velocity_ = {};
  }
  step_beside(emergency);
  step_spindle(emergency);
  step_drives(locked, emergency);
  supervise();
  if (stopped_.load(std::memory_order_relaxed) != abort_seen_)
    step_abort();
  else
    step_interlude();

  state_.block_stopped = state_.sample.block_stopped || standing_;
  ++state_.periods;
  const bool holding = hold.load(std::memory_order_relaxed) && !state_.sample.moving;
  if (running.load(std::memory_order_relaxed) && !holding) {
    ++state_.run_periods;
    if (state_.sample.moving && tags_.find(state_.sample.tag).cutting) ++state_.cutting_periods;
  }
  state_.machine = functions_->outputs();
  state_.hand_busy = hand_.busy();
  state_.hand_orders = hand_.taken();
  state_.marks_found = hand_.homed();
  state_.home_failed = hand_.failed();
  for (std::size_t i = 0; i < axes_; ++i) state_.hand_offset[i] = hand_.offset(i);
  state_.tap_in_hole = tap_.in_hole();
  state_.contour = spindle_.contour_ready();
  buffer_.back() = state_;
  buffer_.publish();
}

void Realtime::end_beside() noexcept {
  hand_.clear(~0u);
  hand_.homed_seen();
  polygon_.drop();
  polygon_.clear();
  tap_shown_ = false;
  tripped_ = in_fault_ = false;
  ramp_.end();
  supervision_.restart();
}

/// Nothing is beside the kernel any more but what others still move.
void Realtime::take_new_position() noexcept {
  hand_.clear(park_taken_over_);
  hand_.homed_seen();
  polygon_.clear();
  tap_shown_ = false;
  if (park_marks_ == 0) return;
  mechanics_.set_position(park_position_);
  const AxisVector called = mechanics_.to_motors(park_position_);
  AxisVector motors = drive_->actual();
  for (std::size_t i = 0; i < axes_; ++i) {
    if ((park_marks_ >> i & 1) == 0) continue;
    motors[i] = called[i];
    commanded_[i] = park_position_[i];
  }
  drive_->set_position(motors);
  supervision_.restart();
}

/// @param set_anew the kernel has just been given a position that it has to take up before anything else
void Realtime::step_kernel(bool set_anew) noexcept {
  const std::uint64_t park = park_.load(std::memory_order_acquire);
  if (!set_anew && parked_.load(std::memory_order_relaxed) != park) {
    parked_.store(park, std::memory_order_release);
    return;
  }
  if (!set_anew && unpark_seen_ != park) {
    if (unparked_.load(std::memory_order_acquire) != park)
      return;  // the kernel is being given a new position
    unpark_seen_ = park;
    if (!park_cancelled_) take_new_position();
  }
  const bool resting_after_abort = stopped_.load(std::memory_order_relaxed) == abort_seen_ &&
                                   released_.load(std::memory_order_acquire) != abort_seen_;
  if (resting_after_abort) return;
  const motion::Overrides wanted = overrides();
  state_.go = wanted.go;
  state_.sample = kernel_.step(wanted, spindle_.spindle().phase_rad(), std::abs(spindle_.spindle().rpm()));
  // Of the block, which may be several moves of the kernel.
  if (const SegmentState& segment = tags_.find(state_.sample.tag); segment.has_end)
    for (std::size_t i = 0; i < axes_; ++i)
      state_.sample.distance_to_go[i] = segment.end[i] - state_.sample.position[i];
  state_.base = state_.sample.position;
  state_.kernel_moving = state_.sample.moving;
}

/// Moves of a hand along a path: the feed override acts, the program's feed hold does not.
void Realtime::step_second() noexcept {
  motion::Kernel* kernel = second_kernel.load(std::memory_order_acquire);
  state_.second_moving = false;
  state_.second_done = true;
  if (kernel == nullptr) return;
  motion::Overrides wanted;
  wanted.feed = feed_override.load(std::memory_order_relaxed);
  const motion::Sample sample = kernel->step(wanted, 0, 0);
  state_.second_position = sample.position;
  state_.second_moving = sample.moving;
  state_.second_done = !sample.moving && (sample.queue_empty || kernel->aborted());
  state_.second_tag = sample.tag;
}

/// Everything that moves axes beside the kernel, and the ramp that ends all of it.
void Realtime::step_beside(bool emergency) noexcept {
  if (tripped_) tap_.drop();
  if (tap_.running()) tap_.step(spindle_.spindle(), drive_->position_gain(tap_.axis()));
  if (tap_shown_) state_.base[tap_.axis()] = tap_.position();
  step_second();
  AxisVector position =
      second_kernel.load(std::memory_order_relaxed) != nullptr ? state_.second_position : state_.base;
  polygon_.step(spindle_.spindle().phase_rad());
  position[polygon_.axis()] += polygon_.offset_deg();
  hand_.step(state_.base, feed_override.load(std::memory_order_relaxed),
             rapid_override.load(std::memory_order_relaxed), *drive_);
  for (std::size_t i = 0; i < axes_; ++i) position[i] += hand_.offset(i);
  mechanics_.couple(position);
  const bool ramping = emergency || tripped_ || in_fault_;
  if (!ramping) ramp_.end();
  bool stands = true;
  if (ramping) {
    if (!ramp_.active()) {
      ramp_.begin(commanded_, tripped_ ? AxisVector{} : velocity_);  // without drives nothing is braked
      tap_.stop();
      hand_.stop();
    }
    stands = ramp_.step();
    // A tap in its hole keeps the step with its spindle to the end.
    if (tap_.running()) {
      ramp_.set(tap_.axis(), position[tap_.axis()]);
      stands = false;
    }
    position = ramp_.position();
  } else if (guard_travel()) {
    position = ramp_.position();
    stands = false;
  }
  drives_on_ = !tripped_ && !(emergency && stands);
  state_.sample.moving = state_.kernel_moving || state_.second_moving || tap_.running() || hand_.moving() ||
                         polygon_.moving() || !stands;
  if (tap_.running()) state_.sample.tag = posted_interlude_.tag;
  for (std::size_t i = 0; i < axes_; ++i) {
    velocity_[i] = (position[i] - commanded_[i]) / period_s_;
    if (tap_.running() || hand_.moving() || state_.second_moving || polygon_.moving() || ramping)
      state_.sample.velocity[i] = velocity_[i];
  }
  if (tap_.running()) {
    const double to = tap_.position() - tap_.order().end;
    state_.sample.distance_to_go[tap_.axis()] = -to;
    state_.sample.path_speed_mm_s = std::abs(velocity_[tap_.axis()]);
  } else if (hand_.moving() || state_.second_moving) {
    double sum = 0;
    for (std::size_t i = 0; i < axes_; ++i) sum += velocity_[i] * velocity_[i];
    state_.sample.path_speed_mm_s = std::sqrt(sum);
  }
  commanded_ = position;
  state_.sample.position = position;
}

/// The last guard of the stroke limits, whatever moves the axes: who could not stop inside any more is
/// stopped by the emergency deceleration. Moves of programs and of hands end at the limit by themselves.
bool Realtime::guard_travel() noexcept {
  const std::uint32_t known = homed.load(std::memory_order_relaxed);
  for (std::size_t i = 0; i < axes_; ++i) {
    const machine::Axis& axis = machine_.axes[i];
    if (axis.rotary || axis.follows != 0 || (known >> i & 1) == 0) continue;
    const double v = velocity_[i], way = v * v / (2 * axes::emergency_deceleration(axis));
    const bool above = v > 0 && commanded_[i] + way > axis.max_mm + kGuard_mm;
    const bool below = v < 0 && commanded_[i] - way < axis.min_mm - kGuard_mm;
    if (!above && !below) continue;
    raise(fault_of(axes::FaultKind::overtravel, i, above));
    ramp_.begin(commanded_, velocity_);
    ramp_.step();
    return true;
  }
  return false;
}

void Realtime::raise(const axes::Fault& fault) noexcept {
  if (in_fault_ || tripped_) return;
  state_.fault = fault;
  ++state_.faults;
  if (servo_fault(fault.kind)) tripped_ = true;
  if (fault.kind == axes::FaultKind::overtravel) in_fault_ = true;
}

void Realtime::supervise() noexcept {
  if (!drives_on_) {
    supervision_.restart();
    return;
  }
  const axes::Fault axis = supervision_.check(drive_command_, state_.actual);
  if (axis.kind != axes::FaultKind::none) raise(axis);
  if (tap_.running() && tap_.coupled()) {
    const axes::TapOrder& order = tap_.order();
    const double most = machine_.spindle.position_error_deg / 360 * order.pitch_mm;
    const bool off = order.follows
                         ? tap_.beyond_mm() > order.pitch_mm
                         : tap_.error_mm(state_.actual[order.axis], spindle_.spindle().phase_rad()) > most;
    if (off) raise(fault_of(axes::FaultKind::tap_error, order.axis));
  }
  if (watch_.check(spindle_.commanded_rpm(), spindle_.spindle().rpm(), period_s_)) {
    raise(fault_of(axes::FaultKind::spindle_fluctuation, 0));
    watch_.set({});
  }
}

void Realtime::step_abort() noexcept {
  if (!kernel_.aborted() || state_.sample.moving || hand_.moving()) return;
  standing_ = false;
  begun_ = posted_.load(std::memory_order_acquire);
  done_.store(begun_, std::memory_order_release);
  stopped_.store(abort_seen_, std::memory_order_release);
}

motion::Overrides Realtime::overrides() const noexcept {
  const SegmentState& segment = tags_.find(state_.sample.tag);
  motion::Overrides now;
  now.feed = segment.fixed_feed ? 1 : feed_override.load(std::memory_order_relaxed);
  now.rapid = rapid_override.load(std::memory_order_relaxed);
  if (now.rapid == 0) now.rapid = rapid_f0.load(std::memory_order_relaxed);
  now.hold =
      (hold.load(std::memory_order_relaxed) || brake.load(std::memory_order_relaxed)) && !segment.not_held;
  now.single_block = single_block.load(std::memory_order_relaxed) && !segment.no_single_block;
  now.in_position = state_.in_position;
  now.go = go.load(std::memory_order_relaxed);
  const unsigned inputs = skip_signals.load(std::memory_order_relaxed);
  now.skip_signal = (segment.skip_signals & (segment.skip_low ? ~inputs : inputs)) != 0;
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
  last_phase_rad_ = spindle_.spindle().phase_rad();
  switch (interlude.kind) {
    case Interlude::Kind::function:
      functions_->request(interlude.request);
      break;
    case Interlude::Kind::tap:
      tap_.begin(interlude.tap, state_.base[interlude.tap.axis]);
      tap_from_ = state_.base[interlude.tap.axis];
      tap_shown_ = true;
      break;
    case Interlude::Kind::watch:
      watch_.set(interlude.watch);
      break;
    case Interlude::Kind::polygon:
      polygon_.set(interlude.polygon, spindle_.spindle().phase_rad(), spindle_.spindle().rpm());
      break;
    case Interlude::Kind::meeting:
    case Interlude::Kind::dwell:
      break;
  }
}

bool Realtime::finished() noexcept {
  switch (posted_interlude_.kind) {
    case Interlude::Kind::meeting:
    case Interlude::Kind::watch:
      return true;
    case Interlude::Kind::function:
      return posted_interlude_.not_awaited || functions_->finished();
    case Interlude::Kind::polygon:
      return polygon_.settled();
    case Interlude::Kind::tap:
      if (tap_.running() || !state_.in_position) return false;
      if (!tap_.order().follows)
        spindle_.hold_after_tap(functions_->outputs().spindle_orders, tap_.phase_rad(),
                                drive_->position_gain(tap_.axis()));
      if (tap_.position() == tap_from_) tap_shown_ = false;
      return true;
    case Interlude::Kind::dwell: {
      // Feed hold stops the clock of a dwell too; the rest is waited after cycle start.
      const double turned = std::abs(spindle_.spindle().phase_rad() - last_phase_rad_);
      last_phase_rad_ = spindle_.spindle().phase_rad();
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
  functions_->step({spindle_.spindle().at_speed(), spindle_.oriented(), spindle_.contour_ready(), period_s_});
  if (tripped_) return;  // without drives nothing begins and nothing is done; the abort drops it
  const std::uint64_t posted = posted_.load(std::memory_order_acquire);
  if (done_.load(std::memory_order_relaxed) == posted) return;
  if (begun_ != posted) {
    const motion::Sample& sample = state_.sample;
    const bool all_traced = sample.queue_empty && !sample.starved &&
                            (posted_interlude_.after_tag == 0 || posted_interlude_.after_tag == sample.tag);
    const bool moves_done = planned_.load(std::memory_order_acquire) == posted && !state_.kernel_moving &&
                            (all_traced || sample.skipped);
    if (!moves_done || sample.block_stopped || !state_.in_position) return;
    if (hold.load(std::memory_order_relaxed) && !posted_interlude_.not_held) return;
    // The function before may still be under way when the program did not wait for it.
    if (posted_interlude_.kind == Interlude::Kind::function && !functions_->finished()) return;
    if (stands_before(posted)) return;
    begun_ = posted;
    begin(posted_interlude_);
    // A function has its answer in the next period at the earliest; a dwell counts this period's end as its
    // start.
    if (posted_interlude_.kind != Interlude::Kind::meeting) return;
  }
  if (finished()) done_.store(posted, std::memory_order_release);
}

void Realtime::step_spindle(bool emergency) noexcept {
  const plc::Outputs& outputs = functions_->outputs();
  SpindleControl::Wanted wanted;
  wanted.override = spindle_override.load(std::memory_order_relaxed);
  wanted.off = emergency || tripped_;
  if (outputs.constant_surface_speed) {
    const std::size_t axis = outputs.surface_axis < axes_ ? outputs.surface_axis : surface_axis_;
    const SegmentState& segment = tags_.find(state_.sample.tag);
    // During positioning nothing is cut: the speed is that of where it leads (0i-D 9.3).
    const bool positioning = state_.kernel_moving && !segment.cutting;
    const double at = state_.base[axis] + (positioning ? state_.sample.distance_to_go[axis] : 0);
    wanted.surface_radius_mm = std::abs(at - segment.modal.work_zero[axis]);
  }
  if (contour_axis_ >= 0) wanted.contour_deg = commanded_[static_cast<std::size_t>(contour_axis_)];
  spindle_.step(outputs, wanted, tap_.running());
  state_.spindle_rpm = spindle_.spindle().rpm();
  state_.spindle_commanded_rpm = spindle_.commanded_rpm();
}

void Realtime::step_drives(bool locked, bool emergency) noexcept {
  const std::uint32_t axis_locks = axis_lock.load(std::memory_order_relaxed);
  for (std::size_t i = 0; i < axes_; ++i)
    if (!locked && (axis_locks >> i & 1) == 0) drive_command_[i] = commanded_[i];
  drive_->enable(drives_on_);
  drive_->command(mechanics_.to_motors(drive_command_));
  const AxisVector before = state_.actual;
  state_.actual = mechanics_.to_axes(drive_->actual());
  if (spindle_.contour_ready()) {  // this axis is the spindle itself
    const auto c = static_cast<std::size_t>(contour_axis_);
    state_.actual[c] = drive_command_[c] - spindle_.spindle().position_error_rad() / kTwoPi * 360;
  }
  state_.drives_at_rest = !emergency || !drives_on_;
  for (std::size_t i = 0; i < axes_; ++i)
    if (std::abs(state_.actual[i] - before[i]) > kAtRest_mm_s * period_s_) state_.drives_at_rest = false;
  // A tool axis in step with the spindle never stands, and the ladder's axes are not the program's.
  std::uint32_t besides = ladder_axes_;
  if (polygon_.moving() && polygon_.settled()) besides |= 1u << polygon_.axis();
  state_.in_position = supervision_.in_position(drive_command_, state_.actual, besides);
}

}  // namespace headstock::operation

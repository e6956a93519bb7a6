#include "motion/kernel.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "motion/cells.hpp"
#include "motion/ring.hpp"
#include "motion/smoothing.hpp"
#include "motion/speed_plan.hpp"
#include "motion/thread_sync.hpp"
#include "motion/time_law.hpp"

namespace headstock::motion {

namespace {

constexpr std::size_t kSpans = 16'384;
constexpr std::size_t kCells = 16'384;
constexpr std::size_t kPlanPiece = 512;     // cells one plan() makes at most, and how far entries are batched
constexpr std::uint64_t kBlocksAhead = 64;  // looked at for a block end that can still be stopped at
constexpr int kStopsTried = 2;              // of them, in one period
constexpr int kStartPatience = 32;  // periods at rest before starting with a look-ahead that is not full
constexpr double kAny = std::numeric_limits<double>::infinity();

/// What the real-time thread knows of a move.
struct MoveOnPath {
  std::uint64_t tag = 0;
  AxisVector end{};
  double length_end = 0;
  FeedKind kind = FeedKind::feed;
  bool block_end = true, skip = false;
  double begin = 0;
  bool after_exact_stop = false;  // behind which the drives are waited for
  ThreadCourse thread;
};

/// Where the real-time thread finds a new path after set_position().
struct Restart {
  AxisVector position{};
  std::uint64_t cell = 0, span = 0, move = 0;
  Kernel::Shapes shapes{};
};

AxisVector jerks_of(const machine::Machine& machine) {
  AxisVector jerks{};
  for (std::size_t i = 0; i < machine.axes.size(); ++i) jerks[i] = machine.axes[i].max_jerk_mm_s3;
  return jerks;
}

}  // namespace

struct Kernel::Impl {
  explicit Impl(const machine::Machine& machine)
      : axes(machine.axes.size()),
        highest_rpm(machine.spindle.max_rpm),
        period_s(machine.period_us * 1e-6),
        smoother(axes, tolerance_weights(machine)),
        maker(machine),
        plan(cells),
        law(cells, period_s, maker.law_steps(), maker.smoothing_periods()),
        filter(axes, period_s, jerks_of(machine)) {
    for (std::size_t i = 0; i < axes; ++i) rapid_mm_s[i] = machine.axes[i].rapid_mm_min / 60;
    own_smoothing = maker.smoothing_periods();
    restart(AxisVector{});
    take_restart();
  }

  // ---- look-ahead thread
  void restart(const AxisVector& position) {
    smoother.reset(0);
    maker.reset();
    path_end = position;
    path_length = 0;
    previous_kind = FeedKind::rapid;
    anything_pushed = exact_stop_before = false;
    previous_shape = 0;
    cells_done = cells_written;
    const std::uint64_t next = restart_count.load(std::memory_order_relaxed) + 1;
    restarts[next % restarts.size()] = {position, cells_written, spans_written, moves_written, shapes};
    complete.store(cells_written, std::memory_order_release);
    aborting.store(false, std::memory_order_relaxed);
    stood.store(false, std::memory_order_relaxed);
    restart_count.store(next, std::memory_order_release);
  }

  void push(const Move& move) {
    MoveOnPath& info = moves[moves_written];
    info = {};
    info.tag = move.tag;
    info.block_end = move.block_end;
    info.skip = move.skip;
    info.begin = path_length;
    info.after_exact_stop = exact_stop_before;
    Piece piece;
    piece.curve = Curve::from(path_end, move, axes);
    piece.begin = path_length;
    const bool has_length = piece.curve.length >= kNoLength;
    piece.stop = move.exact_stop || move.tolerance_mm < 1e-6;
    FeedSection section = section_of(move, piece.curve, info.thread);
    info.kind = section.kind;
    info.end = has_length ? piece.curve.end : path_end;
    if (has_length) {
      const bool thread_edge = (section.kind == FeedKind::thread) != (previous_kind == FeedKind::thread);
      const std::uint8_t shape = move.shape < kShapes ? move.shape : std::uint8_t{0};
      if ((thread_edge || shape != previous_shape) && anything_pushed) smoother.stop_at_end();
      section.shape = previous_shape = shape;
      section.bell_s = shapes[shape].bell_s;
      exact_stop_before = move.exact_stop;
      path_length += piece.curve.length;
      path_end = piece.curve.end;
      piece.end = path_length;
      piece.tolerance = move.tolerance_mm;
      section.end = path_length;
      if (section.kind != FeedKind::thread) {
        if (move.highest_mm_s > 0) section.highest = move.highest_mm_s;
        if (move.corner_mm_s > 0) section.corner = move.corner_mm_s;
      }
      if (move.speed_up_mm_s2 > 0) section.speed_up = move.speed_up_mm_s2;
      if (move.slow_down_mm_s2 > 0) section.slow_down = move.slow_down_mm_s2;
      info.thread.begin = piece.begin;
      info.thread.end = piece.end;
      maker.add_section(section);
      smoother.add(piece);
      previous_kind = section.kind;
      anything_pushed = true;
    } else if (piece.stop) {
      smoother.stop_at_end();
      exact_stop_before = exact_stop_before || move.exact_stop;
    }
    info.length_end = path_length;
    moves.publish(++moves_written);
  }

  FeedSection section_of(const Move& move, const Curve& curve, ThreadCourse& thread) const {
    FeedSection section;
    if (const auto* feed = std::get_if<PathFeed>(&move.feed)) {
      section.kind = FeedKind::feed;
      section.speed = std::max(feed->mm_s, 1e-6);
    } else if (const auto* per_turn = std::get_if<RevolutionFeed>(&move.feed)) {
      section.kind = FeedKind::revolution;
      section.reference_rpm = per_turn->reference_rpm > 0 ? per_turn->reference_rpm : highest_rpm;
      section.speed = std::max(per_turn->mm_rev * section.reference_rpm / 60, 1e-6);
    } else if (const auto* cut = std::get_if<ThreadFeed>(&move.feed)) {
      section.kind = FeedKind::thread;
      section.speed = kAny;
      double share = 0;
      for (std::size_t i = 0; i < axes; ++i) share = std::max(share, std::abs(curve.end[i] - curve.start[i]));
      share = curve.length > 0 && share > 0 ? share / curve.length : 1;
      thread.lead = std::max(cut->lead_mm, 1e-6) / share;
      thread.lead_change = cut->lead_change_mm / share;
      thread.start_angle_rad = cut->start_angle_rad;
    } else {
      section.kind = FeedKind::rapid;
      // What the rapid override is a part of: the speed at which the first axis is at its rapid rate.
      section.speed = kAny;
      for (std::size_t i = 0; i < axes && curve.length > 0; ++i) {
        const double way = std::abs(curve.end[i] - curve.start[i]);
        if (way > 0) section.speed = std::min(section.speed, rapid_mm_s[i] * curve.length / way);
      }
    }
    return section;
  }

  bool plan_some() {
    const std::uint64_t oldest = cells.released();
    std::uint64_t made = 0;
    bool more = false;
    for (;;) {
      if (made >= kPlanPiece) {
        more = true;
        break;
      }
      if (cells.room(cells_written) == 0) break;
      if (maker.next(cells[cells_written])) {
        ++cells_written;
        ++made;
        continue;
      }
      if (spans.room(spans_written) == 0) break;
      Span& span = spans[spans_written];
      if (!smoother.next(span)) break;
      maker.add(span);
      ++spans_written;
    }
    spans.publish(spans_written);
    if (cells_written != cells_done) {
      plan.begin(cells_done, cells_written);
      cells.publish(cells_written);
      plan.raise(std::max(oldest, path_first_cell()), cells_done);
      cells_done = cells_written;
    }
    // Full is as far as the look-ahead can see: motion may start.
    if (!more && (moves.room(moves_written) < moves.capacity() / 2 ||
                  cells.room(cells_written) < cells.capacity() / 2))
      complete.store(cells_written, std::memory_order_release);
    if (!more && finished) complete.store(cells_written, std::memory_order_release);
    return more;
  }

  std::uint64_t path_first_cell() const {
    return restarts[restart_count.load(std::memory_order_relaxed) % restarts.size()].cell;
  }

  // ---- real-time thread
  void take_restart() {
    const std::uint64_t count = restart_count.load(std::memory_order_acquire);
    if (count == restart_taken) return;
    restart_taken = count;
    const Restart& from = restarts[count % restarts.size()];
    standing = placed = from.position;
    shapes_in_force = from.shapes;
    shape_in_force = 0;
    filter.set(shapes_in_force[0], standing, 0, 0);
    span_cursor = from.span;
    move_cursor = leading_move = from.move;
    law.reset(0, from.cell);
    law.smooth(own_smoothing, 0);
    sync.stop();
    single = {};
    skipped = false;
    patience = 0;
    release();
  }

  void release() {
    cells.release(std::min(law.cell(), cells.published()));
    spans.release(span_cursor);
    moves.release(move_cursor);
  }

  const MoveOnPath* move_at(std::uint64_t& cursor, double length) const {
    const std::uint64_t end = moves.published();
    while (cursor + 1 < end && moves[cursor].length_end <= length) ++cursor;
    return cursor < end ? &moves[cursor] : nullptr;
  }

  /// The move the law's leading length is on.
  const MoveOnPath* leading() {
    leading_move = std::max(leading_move, move_cursor);  // those before are released
    return move_at(leading_move, law.leading_length());
  }

  /// At rest: may motion start from this cell?
  bool may_start() {
    const std::uint64_t cell = law.cell();
    if (cell >= cells.published()) {
      patience = 0;
      return false;
    }
    if (cell < complete.load(std::memory_order_acquire)) return true;
    return ++patience > kStartPatience;
  }

  Demand demand(const Overrides& overrides, double phase_rad, double rpm) {
    Demand demand;
    const bool dropping = skipped || aborting.load(std::memory_order_acquire);
    if (law.at_rest()) {
      if (dropping) {
        if (filter.empty()) stood.store(true, std::memory_order_release);
        demand.ratio = 0;
        return demand;
      }
      if (!stands_at_block_end(overrides) && !overrides.hold && filter.empty() && !awaits_drives(overrides))
        law.pass_stop();
      if (single.standing || !may_start()) {
        demand.ratio = 0;
        return demand;
      }
      take_shape();
    } else {
      patience = 0;
    }
    const Cell& cell = cells[law.cell()];
    demand.ratio = 0;
    if (cell.kind != FeedKind::thread) sync.stop();
    if (dropping) return demand;
    demand.stop_at = block_stop(overrides);
    if (cell.kind == FeedKind::thread) {
      const MoveOnPath* cutting = leading();
      if (!cutting || (overrides.hold && !sync.running())) return demand;
      return sync.demand(cutting->thread, law.at_rest() && law.leading_length() == cutting->thread.begin,
                         phase_rad, rpm, law);
    }
    if (overrides.hold) return demand;
    const double feed = std::clamp(overrides.feed, 0.0, kMaxOverride);
    switch (cell.kind) {
      case FeedKind::rapid:
        demand.ratio = std::clamp(overrides.rapid, 0.0, 1.0);
        break;
      case FeedKind::revolution:
        demand.ratio = std::min(kMaxOverride, feed * std::abs(rpm) / cell.reference_rpm);
        break;
      default:
        demand.ratio = feed;
    }
    return demand;
  }

  /// Standing at an exact stop while the drives are still on their way to it?
  bool awaits_drives(const Overrides& overrides) {
    if (overrides.in_position) return false;
    const MoveOnPath* next = leading();
    return next && next->after_exact_stop && law.leading_length() <= next->begin;
  }

  /// At rest: how the stretch ahead speeds up and slows down. It changes at stops only, where nothing is left
  /// in the filter.
  void take_shape() {
    const Cell& cell = cells[law.cell()];
    if (filter.empty() && cell.shape != shape_in_force) {
      shape_in_force = cell.shape;
      const AccelerationShape& shape = shapes_in_force[shape_in_force];
      filter.set(shape, standing, law.length(), leading_axis(shape, cell.kind));
    }
    law.smooth(cell.smoothing, filter.lag_s());
  }

  /// Whose lag is that of the length along the path: of a thread the axis that moves most, otherwise the
  /// slowest.
  std::size_t leading_axis(const AccelerationShape& shape, FeedKind kind) {
    const MoveOnPath* next = kind == FeedKind::thread ? leading() : nullptr;
    std::size_t most = 0;
    for (std::size_t i = 1; i < axes; ++i) {
      const bool more =
          next ? std::abs(next->end[i] - standing[i]) > std::abs(next->end[most] - standing[most])
               : shape.after_s[i] > shape.after_s[most];
      if (more) most = i;
    }
    return most;
  }

  /// Standing at a block end? Takes the operator's go-ahead.
  bool stands_at_block_end(const Overrides& overrides) {
    if (single.standing && overrides.go != single.go) {
      single.standing = single.chosen = false;
      single.passed = single.at;
    }
    return single.standing;
  }

  /// Where to stop for single block: chosen once, kept until the axes stand there. Infinite: nowhere for now.
  double block_stop(const Overrides& overrides) {
    if (!overrides.single_block && !single.standing) single.chosen = false;
    if (!overrides.single_block) return kAny;
    if (single.chosen && law.leading_length() > single.at + 1e-6) single.chosen = false;
    if (!single.chosen) {
      const std::uint64_t end = moves.published();
      leading();
      int tried = 0;
      // The last move known is no block to stop behind: what comes after it is not queued, or ends the queue.
      for (std::uint64_t k = leading_move; k + 1 < end && k - leading_move < kBlocksAhead; ++k) {
        const MoveOnPath& move = moves[k];
        if (!move.block_end || move.length_end <= single.passed || move.length_end < law.leading_length())
          continue;
        if (move.kind == FeedKind::thread && moves[k + 1].kind == FeedKind::thread) continue;
        // Too near, or the axes brake for a corner with all they have: perhaps the next block's end, or the
        // next period.
        if (law.plan_stop(move.length_end) == TimeLaw::StopPlan::possible) {
          single.chosen = true;
          single.at = move.length_end;
        }
        if (single.chosen || ++tried == kStopsTried) break;
      }
    }
    return single.chosen ? single.at : kAny;
  }

  void latch_skip(const Overrides& overrides, Sample& sample) {
    if (!skipped && overrides.skip_signal && sample.moving) {
      const MoveOnPath* tracing = move_at(move_cursor, traced());
      if (tracing && tracing->skip) {
        skipped = true;
        skip_position = sample.position;
      }
    }
    sample.skipped = skipped;
    sample.skip_position = skip_position;
  }

  /// Length along the path that the axes have come to.
  double traced() const { return filter.active() ? filter.length() : law.length(); }

  Sample step(const Overrides& overrides, double phase_rad, double rpm) {
    take_restart();
    const Demand wanted = demand(overrides, phase_rad, rpm);
    const double before = law.length();
    const AxisVector position_before = placed;
    law.advance(wanted);
    Sample sample;
    const std::uint64_t last_span = spans.published();
    while (span_cursor + 1 < last_span && spans[span_cursor].end <= law.length()) ++span_cursor;
    if (law.length() != before && span_cursor < last_span)
      standing = spans[span_cursor].position(law.length());
    placed = filter.active() ? filter.step(standing, law.length()) : standing;
    sample.position = placed;
    double squares = 0;
    for (std::size_t i = 0; i < axes; ++i) {
      sample.velocity[i] = (placed[i] - position_before[i]) / period_s;
      squares += sample.velocity[i] * sample.velocity[i];
    }
    sample.path_speed_mm_s = std::sqrt(squares);
    sample.moving = !law.at_rest() || !filter.empty();
    sample.threading = wanted.follow;
    if (wanted.follow) sample.thread_error_mm = law.leading_length() - wanted.target;
    const std::uint64_t last_cell = cells.published();
    sample.queue_empty = last_cell == law.cell() ||
                         (law.cell() + 1 == last_cell && law.leading_length() == cells[law.cell()].end);
    const MoveOnPath* tracing = move_at(move_cursor, traced());
    if (tracing) {
      sample.tag = tracing->tag;
      for (std::size_t i = 0; i < axes; ++i) sample.distance_to_go[i] = tracing->end[i] - placed[i];
    }
    const MoveOnPath* last = filter.active() ? leading() : tracing;
    sample.starved = sample.queue_empty && last && last->length_end > law.leading_length();
    sample.queue_empty = sample.queue_empty && !sample.moving && !sample.starved;
    if (!sample.moving && !single.standing && single.chosen && law.leading_length() == single.at) {
      single.standing = true;
      single.go = overrides.go;
    }
    sample.block_stopped = single.standing;
    latch_skip(overrides, sample);
    release();
    return sample;
  }

  const std::size_t axes;
  const double highest_rpm;
  AxisVector rapid_mm_s{};
  const double period_s;
  std::size_t own_smoothing = 1;  // periods

  // between the threads
  Ring<MoveOnPath> moves{kQueueMoves};
  Ring<Span> spans{kSpans};
  Ring<Cell> cells{kCells};
  std::array<Restart, 4> restarts;
  std::atomic<std::uint64_t> restart_count{0};
  std::atomic<std::uint64_t> complete{0};  // cells before this one may be started from without waiting
  std::atomic<bool> aborting{false}, stood{false};

  // look-ahead thread
  AxisVector path_end{};
  double path_length = 0;
  FeedKind previous_kind = FeedKind::rapid;
  bool anything_pushed = false, finished = false, exact_stop_before = false;
  Shapes shapes{};
  std::uint8_t previous_shape = 0;
  Smoother smoother;
  CellMaker maker;
  SpeedPlan plan;
  std::uint64_t moves_written = 0, spans_written = 0, cells_written = 0, cells_done = 0;

  // real-time thread
  TimeLaw law;
  AxisFilter filter;
  Shapes shapes_in_force{};
  std::uint8_t shape_in_force = 0;
  ThreadSync sync;
  AxisVector standing{};  // where the interpolation is …
  AxisVector placed{};    // … and, behind the filter, the axes
  struct {
    bool chosen = false, standing = false;
    double at = 0, passed = -1;  // lengths; a block end that was stopped at is not stopped at again
    std::uint32_t go = 0;
  } single;
  bool skipped = false;
  AxisVector skip_position{};
  std::uint64_t restart_taken = 0, span_cursor = 0, move_cursor = 0, leading_move = 0;
  int patience = 0;
};

Kernel::Kernel(const machine::Machine& machine) : impl_(std::make_unique<Impl>(machine)) {}
Kernel::~Kernel() = default;

void Kernel::set_shapes(const Shapes& shapes) {
  impl_->shapes = shapes;
}

void Kernel::set_position(const AxisVector& position) {
  impl_->finished = false;
  impl_->restart(position);
}

bool Kernel::can_push() const {
  return impl_->moves.room(impl_->moves_written) > 0;
}

std::size_t Kernel::room() const {
  return static_cast<std::size_t>(impl_->moves.room(impl_->moves_written));
}

void Kernel::push(const Move& move) {
  if (!can_push()) return abort();
  impl_->finished = false;
  impl_->push(move);
}

void Kernel::finish() {
  impl_->smoother.stop_at_end();
  impl_->finished = true;
}

bool Kernel::plan() {
  return impl_->plan_some();
}

Sample Kernel::step(const Overrides& overrides, double spindle_phase_rad, double spindle_rpm) {
  return impl_->step(overrides, spindle_phase_rad, spindle_rpm);
}

void Kernel::abort() {
  impl_->aborting.store(true, std::memory_order_release);
}

bool Kernel::aborted() const {
  return impl_->stood.load(std::memory_order_acquire);
}

}  // namespace headstock::motion

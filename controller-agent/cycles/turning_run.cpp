#include "cycles/turning_run.hpp"

#include <cmath>
#include <numbers>
#include <utility>

namespace headstock::cycles {
namespace {

using interp::Executor;

class TurningRun final : public interp::MoveSource {
 public:
  TurningRun(const Executor& ex, const PlaneAxes& axes, Moves moves, Stops stops)
      : axes_(axes), moves_(std::move(moves)), stops_(stops), feed_(ex.feed_mm), unit_(ex.feed_unit) {}

  bool next(Executor& ex) override {
    Move move;
    while (moves_.next(move)) {
      if (std::exchange(part_ended_, false)) ++ex.at.part;
      const bool made = emit(ex, move);
      part_ended_ = stops_ == Stops::traverses || (stops_ == Stops::passes && move.ends_pass);
      if (made) return true;
    }
    return false;
  }

 private:
  void go(Executor& ex, std::size_t axis, double slide) const {
    interp::ProgramAxis& a = ex.axes[axis];
    a.position = std::llround(slide / a.mm_per_unit * 1e9);
  }

  // A move that is nothing after rounding is left out.
  bool emit(Executor& ex, const Move& move) {
    if (move.kind == MoveKind::dwell) {
      auto& pause = ex.emit<interp::Dwell>();
      pause.at = ex.at;
      pause.modal = ex.modal;
      pause.seconds = move.seconds;
      return true;
    }
    const Point from = here(ex, axes_);
    const interp::AxisVector before = ex.work_now;
    if (move.along_u) go(ex, axes_.u, move.to.u);
    if (move.along_v) go(ex, axes_.v, move.to.v);
    const bool moves = ex.shown(axes_.u) != before[axes_.u] || ex.shown(axes_.v) != before[axes_.v];
    const std::uint32_t mask = (move.along_u ? 1u << axes_.u : 0) | (move.along_v ? 1u << axes_.v : 0);
    if (!moves && move.kind != MoveKind::arc) return false;
    leaves_thread_ = std::exchange(on_thread_, move.kind == MoveKind::thread);
    switch (move.kind) {
      case MoveKind::rapid: {
        auto& motion = ex.emit<interp::Rapid>();
        ex.fill_motion(motion, mask);
        motion.linear = ex.linear_rapid;
        if (leaves_thread_) motion.retreat_ratio = ex.cycle.retreat_ratio;
        break;
      }
      case MoveKind::feed: {
        auto& motion = ex.emit<interp::Feed>();
        ex.fill_motion(motion, mask);
        motion.feed = feed_;
        motion.unit = unit_;
        break;
      }
      case MoveKind::thread: {
        auto& motion = ex.emit<interp::Thread>();
        ex.fill_motion(motion, mask);
        motion.lead_mm = move.lead_mm;
        motion.start_angle_deg = move.angle_deg;
        motion.run_up_mm = move.run_up_mm;
        break;
      }
      case MoveKind::arc: {
        auto& motion = ex.emit<interp::Arc>();
        ex.fill_motion(motion, mask);
        motion.feed = feed_;
        motion.unit = unit_;
        motion.plane = ex.plane;
        motion.turn = move.sweep > 0 ? interp::Turn::ccw : interp::Turn::cw;
        motion.turns = std::fabs(move.sweep) / (2 * std::numbers::pi);
        motion.radius_mm = std::hypot(from.u - move.center.u, from.v - move.center.v);
        motion.center_work = motion.end_work;
        motion.center_machine = motion.end_machine;
        for (const auto& [axis, center] :
             {std::pair{axes_.u, move.center.u}, std::pair{axes_.v, move.center.v}}) {
          motion.center_work[axis] = center / ex.axes[axis].mm_per_unit;
          motion.center_machine[axis] = center + ex.modal.work_zero[axis];
        }
        break;
      }
      case MoveKind::dwell:
        break;
    }
    return true;
  }

  PlaneAxes axes_;
  Moves moves_;
  Stops stops_;
  bool part_ended_ = false;
  bool on_thread_ = false, leaves_thread_ = false;  // the last move was a thread; this one comes from it
  double feed_;
  interp::FeedUnit unit_;
};

}  // namespace

void start(Executor& ex, const char* name, const PlaneAxes& axes, Moves moves, Stops stops) {
  ex.cycle.name = name;
  ex.cycle.starts_cycle = true;
  ex.cycle.running = std::make_unique<TurningRun>(ex, axes, std::move(moves), stops);
}

Point here(const Executor& ex, const PlaneAxes& axes) {
  return {ex.slide_mm(axes.u), ex.slide_mm(axes.v)};
}

bool check_feed(Executor& ex) {
  if (ex.feed_mm > 0 && ex.feed_unit != interp::FeedUnit::inverse_time) return true;
  return ex.alarm(dialects::AlarmReason::feed_missing, ex.block.has('F') ? ex.block['F'].column : 0, "F");
}

double slide_word(const Executor& ex, const program::Word& word, std::size_t axis) {
  const interp::ProgramAxis& a = ex.axes[axis];
  return static_cast<double>(ex.round_to(ex.nano(word, a.increment), a.increment)) / 1e9 * a.mm_per_unit;
}

std::optional<double> target_word(const Executor& ex, std::size_t axis, char absolute, char step) {
  const program::Block& b = ex.block;
  if (b.has(step) && (ex.incremental_letters & program::letter_bit(step)) != 0) {
    return ex.slide_mm(axis) + slide_word(ex, b[step], axis);
  }
  if (!b.has(absolute)) return std::nullopt;
  return slide_word(ex, b[absolute], axis) + (ex.incremental ? ex.slide_mm(axis) : 0);
}

void keep(Executor& ex, std::string_view parameter, double value) {
  if (parameter.empty()) return;
  const double before = ex.data.parameter(parameter);
  if (before == value) return;
  ex.data.parameters[std::string(parameter)] = value;
  ex.report_change("parameter/" + std::string(parameter), before, value);
}

}  // namespace headstock::cycles

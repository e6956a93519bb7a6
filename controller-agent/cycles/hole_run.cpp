#include "cycles/hole_run.hpp"

#include <bit>
#include <cmath>
#include <memory>
#include <utility>

#include "cycles/rules.hpp"

namespace headstock::cycles {
namespace {

using interp::Executor;

class HoleRun final : public interp::MoveSource {
 public:
  HoleRun(const Executor& ex, const HoleJob& job)
      : hole_(job.hole),
        small_(job.small),
        axis_(job.axis),
        plane_(job.plane),
        target_(job.target),
        left_(job.times),
        clamp_m_(job.clamp_m),
        stops_(job.stops),
        feed_(ex.feed_mm),
        unit_(ex.feed_unit) {}

  bool next(Executor& ex) override {
    for (;;) {
      switch (stage_) {
        case Stage::position: {
          if (left_-- <= 0) return false;
          stage_ = Stage::clamp;
          if (go_to_hole(ex)) return true;
          break;
        }
        case Stage::clamp:
          stage_ = Stage::drill;
          part_ends(ex);
          at_reference_ = false;
          center_ = {ex.slide_mm(plane_[0]), ex.slide_mm(plane_[1])};
          if (small_) count_retractions(ex, 0, 0);
          moves_ = small_ ? small_hole(*small_, &overload_) : drill(hole_);
          if (clamp_m_ != 0) {
            m_code(ex, clamp_m_);
            return true;
          }
          break;
        case Stage::drill: {
          overload_ = {ex.skip.triggered, ex.slide_mm(axis_)};
          HoleMove move;
          if (!moves_.next(move)) {
            stage_ = Stage::position;
            part_ends(ex);
            if (clamp_m_ != 0) {
              m_code(ex, clamp_m_ + 1);
              return true;
            }
            break;
          }
          if (!at_reference_ && move.kind != HoleMove::Kind::rapid) {
            at_reference_ = true;
            part_ends(ex);
          }
          if (emit(ex, move)) return true;
          break;
        }
      }
    }
  }

 private:
  enum class Stage : std::uint8_t { position, clamp, drill };

  // Single block stops behind what was made so far.
  void part_ends(Executor& ex) const {
    if (stops_) ++ex.at.part;
  }

  bool go_to_hole(Executor& ex) {
    if (target_.axes == 0) return false;
    for (std::uint32_t mask = target_.axes; mask != 0; mask &= mask - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(mask));
      const auto step = static_cast<std::int64_t>(target_.step[i]);
      interp::ProgramAxis& axis = ex.axes[i];
      axis.position = (target_.incremental >> i & 1u) != 0 ? axis.position + step : step;
    }
    rapid(ex, target_.axes);
    return true;
  }
  // No.5170, No.5171: the common variables that count retractions and those for the overload signal.
  void count_retractions(Executor& ex, int all, int overloads) {
    retractions_ = all;
    overloads_ = overloads;
    for (const auto& [parameter, count] : {std::pair{"5170", all}, std::pair{"5171", overloads}}) {
      const double number = ex.data.parameter(parameter);
      if (ex.macros != nullptr && number >= 100 && number <= 149)
        (void)ex.macros->variables.write(static_cast<std::uint32_t>(number), count);
    }
  }
  void rapid(Executor& ex, std::uint32_t axes) {
    auto& motion = ex.emit<interp::Rapid>();
    ex.fill_motion(motion, axes);
    motion.linear = ex.linear_rapid;
  }
  static void m_code(Executor& ex, std::int32_t number) {
    auto& sent = ex.emit<interp::MCode>();
    sent.at = ex.at;
    sent.modal = ex.modal;
    sent.code = number;
  }
  // The spindle that works: the main one, or a driven tool that M codes turn. A main spindle that stands (it
  // may be clamped as a C axis) is never started by a cycle.
  void turn(Executor& ex, interp::SpindleDirection direction) const {
    using enum interp::SpindleDirection;
    const std::int32_t nth = direction == cw ? 0 : direction == ccw ? 1 : 2;
    if (hole_.driven_m != 0) return m_code(ex, hole_.driven_m + nth);
    if (!hole_.main_turns) return m_code(ex, 3 + nth);
    ex.spindle_direction = direction;
    ex.emit_spindle();
  }
  // The skip input is the arbor's overload signal; override holds as in any cut.
  static void senses(Executor& ex, interp::Feed& motion) {
    const auto& rules = ex.dialect.modes;
    motion.skip_signals = ex.data.bit(rules.skip_off_parameter) ? 0 : 1;
    motion.skip_level = !ex.data.bit(rules.skip_low_parameter);
    motion.skip_overridable = true;
    motion.exact_stop = true;
    ex.skip.machine = ex.machine_now;
    ex.skip.triggered = false;
  }
  static void set(Executor& ex, std::size_t axis, double slide) {
    ex.axes[axis].position = std::llround(slide / ex.axes[axis].mm_per_unit * 1e9);
  }

  bool emit(Executor& ex, const HoleMove& move) {
    using Kind = HoleMove::Kind;
    const std::uint32_t mask = 1u << axis_;
    switch (move.kind) {
      case Kind::rapid:
      case Kind::feed: {
        const double before = ex.work_now[axis_];
        set(ex, axis_, move.to);
        if (ex.shown(axis_) == before) return false;
        if (move.kind == Kind::rapid) {
          rapid(ex, mask);
        } else {
          auto& motion = ex.emit<interp::Feed>();
          ex.fill_motion(motion, mask);
          const bool own = move.feed_mm_min > 0;
          motion.feed = own ? move.feed_mm_min : feed_ * move.feed_ratio;
          motion.unit = own ? interp::FeedUnit::mm_per_minute : unit_;
          if (move.senses) senses(ex, motion);
        }
        if (move.retracts) {
          count_retractions(ex, retractions_ + 1, overloads_ + (move.overloaded ? 1 : 0));
          at_reference_ = false;  // single block stops behind each retraction
        }
        return true;
      }
      case Kind::dwell: {
        auto& pause = ex.emit<interp::Dwell>();
        pause.at = ex.at;
        pause.modal = ex.modal;
        pause.seconds = move.seconds;
        return true;
      }
      case Kind::spindle:
        turn(ex, move.direction);
        return true;
      case Kind::orient:
        m_code(ex, 19);
        return true;
      case Kind::shift: {
        std::uint32_t moved = 0;
        const std::array<double, 2> by{move.u, move.v};
        for (std::size_t i = 0; i < 2; ++i) {
          const std::size_t axis = plane_[i];
          if (axis == axis_) continue;
          const double before = ex.work_now[axis];
          set(ex, axis, center_[i] + by[i]);
          if (ex.shown(axis) != before) moved |= 1u << axis;
        }
        if (moved == 0) return false;
        rapid(ex, moved);
        return true;
      }
      case Kind::speed: {
        if (hole_.driven_m != 0 || !hole_.main_turns) return false;
        const double programmed = std::exchange(ex.rpm, ex.rpm * move.speed_ratio);
        ex.emit_spindle();
        ex.rpm = programmed;
        return true;
      }
      case Kind::refused:
        (void)fail(ex, rules_of(ex.dialect), Fault::hole_peck, 0, "overload signal stays on");
        return true;
      case Kind::operator_stop: {
        auto& stop = ex.emit<interp::Stop>();
        stop.at = ex.at;
        stop.modal = ex.modal;
        return true;
      }
      case Kind::tap: {
        set(ex, axis_, move.to);
        auto& motion = ex.emit<interp::Tap>();
        ex.fill_motion(motion, mask);
        motion.bottom_work = motion.end_work;
        motion.bottom_machine = motion.end_machine;
        motion.bottom_work[axis_] = move.bottom / ex.axes[axis_].mm_per_unit;
        motion.bottom_machine[axis_] = move.bottom + ex.modal.work_zero[axis_];
        motion.kind = hole_.follows ? interp::TapKind::follows : interp::TapKind::rigid;
        motion.pitch_mm = hole_.pitch_mm;
        motion.rpm = ex.rpm;
        motion.direction = move.direction;
        motion.dwell_s = move.seconds;
        motion.out_ratio = hole_.tap_out_ratio;
        motion.spindle = hole_.driven_m != 0 ? 1 : 0;
        return true;
      }
    }
    return false;
  }

  Hole hole_;
  std::optional<SmallHole> small_;
  Overload overload_;
  int retractions_ = 0, overloads_ = 0;
  std::size_t axis_;
  std::array<std::size_t, 2> plane_;
  Target target_;
  std::int64_t left_;
  std::int32_t clamp_m_;
  bool stops_;
  bool at_reference_ = false;
  double feed_;
  interp::FeedUnit unit_;
  Stage stage_ = Stage::position;
  std::array<double, 2> center_{};
  HoleMoves moves_;
};

}  // namespace

void start_holes(Executor& ex, const char* name, const HoleJob& job) {
  ex.cycle.name = name;
  ex.cycle.starts_cycle = true;
  ex.cycle.running = std::make_unique<HoleRun>(ex, job);
}

}  // namespace headstock::cycles

#include "motion/time_law.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::motion {

namespace {

constexpr double kArrived = 1e-9;  // mm
constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr std::uint64_t kMostCells = 256;  // looked at in one step

/// Speed of a step from which the end of a cell is reached at v² = `next`, with `braking` (times the time of a step)
/// and `way` to the end (times braking).
double braking_towards(double next, double braking, double way) {
  // v² <= next + 2 b (way left behind this step).
  const double square = braking * braking + next + 2 * way;
  return square > 0 ? std::max(0.0, std::sqrt(square) - braking) : 0;
}

/// The same into a stop in the cell the step begins in, where only its own braking counts. A step's speed is that of
/// its middle: (v - b t/2)² <= 2 b (way left behind it). In the last one `crossing`, the speed that reaches the stop.
/// No two steps then differ by more than b t, with the half step that motion begins with behind it neither.
double braking_into_stop(double braking, double way, double crossing) {
  return std::max(std::min(crossing, 0.5 * braking), std::sqrt(2 * std::max(0.0, way)) - 0.5 * braking);
}

}  // namespace

/// Weights of the speed plans for a ratio of the reference feed: linear in v², where the limits are linear
/// too.
struct TimeLaw::Mix {
  std::size_t low = 0;
  double weight_low = 0, weight_high = 0;

  explicit constexpr Mix(double ratio) {
    const double square = ratio * ratio;
    if (ratio <= kPlans[0]) {
      weight_low = square / (kPlans[0] * kPlans[0]);
      return;
    }
    while (low + 2 < kPlanCount && ratio > kPlans[low + 1]) ++low;
    const double a = kPlans[low] * kPlans[low], b = kPlans[low + 1] * kPlans[low + 1];
    weight_high = std::min(1.0, (square - a) / (b - a));
    weight_low = 1 - weight_high;
  }
  double of(const PerPlan& values) const {
    return weight_low * values[low] + (weight_high > 0 ? weight_high * values[low + 1] : 0);
  }
  double entry(const Cell& cell) const {
    return weight_low * cell.entry[low].load(std::memory_order_acquire) +
           (weight_high > 0 ? weight_high * cell.entry[low + 1].load(std::memory_order_acquire) : 0);
  }
};

TimeLaw::TimeLaw(const Ring<Cell>& cells, double period_s, std::size_t steps, std::size_t smoothing_periods)
    : cells_(cells),
      period_s_(period_s),
      step_s_(period_s / static_cast<double>(steps)),
      steps_(steps),
      window_(std::max<std::size_t>(1, smoothing_periods), 0.0),
      stop_(kStopCells) {
  window_.reserve(CellMaker::kMostSmoothing);
}

void TimeLaw::smooth(std::size_t periods, double lag_after_s) {
  lag_after_s_ = lag_after_s;
  if (periods == window_.size()) return;
  window_.assign(periods, leading_);  // within what is reserved
  newest_ = 0;
  still_ = window_.size();
}

void TimeLaw::reset(double length, std::uint64_t cell) {
  std::fill(window_.begin(), window_.end(), length);
  leading_ = length_ = length;
  speed_ = 0;
  still_ = window_.size();
  cell_ = cell;
  stop_cells_ = 0;
}

double TimeLaw::acceleration_at(double speed) const {
  return cell_ < cells_.published() ? cells_[cell_].acceleration_for(speed, step_s_) : 0;
}

double TimeLaw::braking_at(double speed) const {
  return cell_ < cells_.published() ? cells_[cell_].braking_for(speed, step_s_) : 0;
}

double TimeLaw::reachable(const Mix& mix, double most) const {
  const std::uint64_t end = cells_.published();
  const double t = step_s_;
  double entry = cell_ < end ? mix.entry(cells_[cell_]) : 0;
  for (std::uint64_t k = cell_; k < end; ++k) {
    const Cell& cell = cells_[k];
    const bool last = cell.stop || k + 1 == end;
    const double next = last ? 0 : mix.entry(cells_[k + 1]);
    const double to_end = cell.end - leading_, crossing = to_end / t;
    if (!last && crossing < most && crossing * crossing <= next && k - cell_ < kMostCells) {
      entry = next;
      continue;
    }
    // With the braking that the plan uses here.
    const double b = std::max(mix.of(cell.ceiling_braking), (entry - next) / (2 * (cell.end - cell.begin)));
    const double braking = cell.stop && k == cell_ ? braking_into_stop(b * t, b * to_end, crossing)
                                                   : braking_towards(next, b * t, b * to_end);
    return std::max(0.0, std::min({most, braking, std::sqrt(mix.of(cell.ceiling))}));
  }
  return 0;
}

TimeLaw::StopPlan TimeLaw::plan_stop(double length) {
  const std::uint64_t end = cells_.published();
  stop_cells_ = 0;
  std::uint64_t last = cell_;
  while (last < end && cells_[last].end < length - kArrived && !cells_[last].stop &&
         last - cell_ < kStopCells)
    ++last;
  if (last >= end || last - cell_ >= kStopCells || cells_[last].end < length - kArrived)
    return StopPlan::too_far;
  if (cells_[last].stop && cells_[last].end <= length + kArrived)
    return StopPlan::possible;  // stops by itself
  // The backward pass of the speed plan, from rest at `length`.
  double ahead = 0;
  for (std::uint64_t k = last + 1; k-- > cell_;) {
    const Cell& cell = cells_[k];
    const double way = std::min(cell.end, length) - std::max(cell.begin, leading_);
    double entry = ahead;
    if (way > 0) entry = std::min(cell.ceiling.back(), cell.entry_before(ahead, way));
    stop_[k - cell_] = {ahead, way > 0 ? std::max(0.0, (entry - ahead) / (2 * way)) : 0.0};
    ahead = entry;
  }
  stop_first_ = cell_;
  stop_cells_ = last + 1 - cell_;
  stop_at_ = length;
  if (towards_stop(speed_) >= speed_ - braking_at(speed_) * step_s_ && speed_ * speed_ <= ahead)
    return StopPlan::possible;
  stop_cells_ = 0;
  return StopPlan::impossible;
}

double TimeLaw::towards_stop(double most) const {
  if (stop_cells_ == 0) return most;
  const double t = step_s_;
  for (std::uint64_t k = cell_; k < stop_first_ + stop_cells_; ++k) {
    const auto& [next, braking] = stop_[k - stop_first_];
    const double to_end = std::min(cells_[k].end, stop_at_) - leading_, crossing = to_end / t;
    if (k + 1 < stop_first_ + stop_cells_ && crossing < most && crossing * crossing <= next) continue;
    return std::max(0.0, std::min(most, braking_towards(next, braking * t, braking * to_end)));
  }
  return 0;
}

bool TimeLaw::cruises(const Mix& mix, double time_s) const {
  static constexpr Mix fastest(kMaxOverride);
  const std::uint64_t end = cells_.published();
  const double square = speed_ * speed_, to = leading_ + speed_ * time_s;
  for (std::uint64_t k = cell_; k + 1 < end && k - cell_ < kMostCells; ++k) {
    const Cell& cell = cells_[k];
    if (cell.stop || std::sqrt(mix.of(cell.ceiling)) != speed_) return false;
    const double left = std::max(0.0, cell.end - to);
    for (const Mix* plan : {&mix, &fastest})
      if (square > plan->entry(cells_[k + 1]) + 2 * plan->of(cell.ceiling_braking) * left) return false;
    if (to < cell.end) return true;
  }
  return false;
}

void TimeLaw::step(const Demand& demand, const Mix& mix, double left_s) {
  static constexpr Mix fastest(kMaxOverride);
  const double t = step_s_;
  double speed = 0;
  if (cell_ < cells_.published()) {
    // From rest to the middle of the first step.
    const double step = acceleration_at(speed_) * (speed_ > 0 ? t : 0.5 * t), brake = braking_at(speed_) * t;
    const double hard = reachable(fastest, speed_ + step);
    double wanted;
    if (demand.follow) {
      const double target = demand.target - demand.target_speed * left_s;
      const double error = target - (leading_ + demand.target_speed * t), a = 0.9 * std::min(step, brake) / t;
      const double correction =
          std::min(std::sqrt(2 * a * std::abs(error)), std::abs(error) / (4 * period_s_));
      wanted = std::clamp(demand.target_speed + std::copysign(correction, error),
                          std::max(0.0, speed_ - brake), speed_ + step);
    } else {
      wanted = demand.ratio <= 0 ? 0 : reachable(mix, speed_ + step);
      if (demand.stop_at < kFar) wanted = std::min(wanted, towards_stop(speed_ + step));
      wanted = std::max(wanted, speed_ - brake);
    }
    speed = std::max(0.0, std::min(hard, wanted));
  }
  double leading = leading_ + speed * t;
  if (!demand.follow && std::abs(leading - demand.stop_at) <= kArrived) {
    leading = demand.stop_at;
    speed = 0;
  }
  move_to(leading, speed);
}

void TimeLaw::move_to(double leading, double speed) {
  const std::uint64_t end = cells_.published();
  while (cell_ < end) {
    const Cell& cell = cells_[cell_];
    const bool last = cell.stop || cell_ + 1 == end;
    if (last) {
      if (leading >= cell.end - kArrived && (speed > 0 || speed_ > 0)) {
        leading = cell.end;
        speed = cell.stop || leading_ == cell.end ? 0 : speed;
      }
      break;
    }
    if (leading < cell.end) break;
    ++cell_;
  }
  speed_ = leading == leading_ ? 0 : speed;
  leading_ = leading;
}

void TimeLaw::advance(const Demand& demand) {
  const double before = leading_;
  const Mix mix(std::max(0.0, demand.ratio));
  for (std::size_t left = steps_; left > 0;) {
    const double speed = speed_, left_s = static_cast<double>(--left) * step_s_;
    step(demand, mix, left_s);
    // The rest of the period at once where it is the same again.
    if (speed_ != speed || left == 0 || demand.follow || demand.stop_at < kFar) continue;
    if (speed_ == 0) break;
    if (!cruises(mix, left_s)) continue;
    move_to(leading_ + speed_ * left_s, speed_);
    break;
  }
  if (leading_ != before)
    still_ = 1;
  else if (still_ < window_.size())
    ++still_;
  newest_ = newest_ + 1 == window_.size() ? 0 : newest_ + 1;
  window_[newest_] = leading_;
  // Summed anew as differences to the newest value, youngest first: no drift, exactly on it when standing,
  // and the same bits wherever the ring's seam is.
  double behind = 0;
  for (std::size_t i = newest_ + 1; i-- > 0;) behind += leading_ - window_[i];
  for (std::size_t i = window_.size(); i-- > newest_ + 1;) behind += leading_ - window_[i];
  length_ = leading_ - behind / static_cast<double>(window_.size());
}

bool TimeLaw::pass_stop() {
  if (cell_ + 1 >= cells_.published()) return false;
  const Cell& cell = cells_[cell_];
  if (!cell.stop || leading_ != cell.end || !at_rest()) return false;
  ++cell_;
  return true;
}

}  // namespace headstock::motion

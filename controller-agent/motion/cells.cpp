#include "motion/cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace headstock::motion {

namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr double kJerkUnlimited = 1e9;
// Shares of the limits. The rest of the acceleration brakes in a curve taken at its highest speed; the small
// margins pay for derivatives that change within one period.
constexpr double kVelocity = 0.9995, kAcceleration = 0.99, kJerk = 0.96;
constexpr double kBendShare = 0.96;      // of the acceleration for curvature at the highest speed
constexpr double kTwistShare = 0.4;      // of the jerk for twist at the highest speed
constexpr double kSmoothingShare = 1.5;  // smoothing time over (acceleration / jerk)
constexpr std::size_t kMostSmoothing = 1024;

}  // namespace

CellMaker::CellMaker(const machine::Machine& machine) : period_s_(machine.period_us * 1e-6) {
  double longest = 0, fastest = 0;
  for (const machine::Axis& axis : machine.axes) {
    const bool limited = axis.max_jerk_mm_s3 < kJerkUnlimited;
    axes_.push_back({kVelocity * axis.max_feed_mm_min / 60, kVelocity * axis.rapid_mm_min / 60,
                     kAcceleration * axis.max_acceleration_mm_s2,
                     limited ? kJerk * axis.max_jerk_mm_s3 : kAny});
    if (limited) longest = std::max(longest, axis.max_acceleration_mm_s2 / axis.max_jerk_mm_s3);
    jerk_limited_ = jerk_limited_ || limited;
    fastest = std::hypot(fastest, std::max(axis.max_feed_mm_min, axis.rapid_mm_min) / 60);
  }
  smoothing_periods_ = std::clamp<std::size_t>(
      static_cast<std::size_t>(std::lround(kSmoothingShare * longest / period_s_)), 1, kMostSmoothing);
  smoothing_s_ = static_cast<double>(smoothing_periods_) * period_s_;
  window_s_ = smoothing_s_ + 2 * period_s_;
  longest_reach_ = fastest * window_s_;
}

void CellMaker::reset() {
  sections_.clear();
  staged_.clear();
  reaching_.clear();
  final_ = 0;
  newest_ = 0;
}

void CellMaker::measure(const Span& span, RawCell& cell) {
  const double h = span.end - span.begin;
  double speed = kAny;
  AxisVector twist{};
  bool rapid_only = true;
  while (sections_.size() > 1 && sections_.front().end <= span.begin) sections_.pop_front();
  cell.kind = sections_.front().kind;
  cell.reference_rpm = sections_.front().reference_rpm;
  cell.feed = kAny;
  for (const FeedSection& section : sections_) {
    cell.feed = std::min(cell.feed, section.speed);
    rapid_only = rapid_only && section.kind == FeedKind::rapid;
    if (section.end >= span.end) break;
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const double c1 = span.c[1][i], c2 = span.c[2][i], c3 = span.c[3][i];
    // Bézier points of the first derivative bound it; the second is linear, the third constant.
    cell.rate[i] =
        std::max({std::abs(c1), std::abs(c1 + c2 * h), std::abs(c1 + 2 * c2 * h + 3 * c3 * h * h)});
    cell.bend[i] = std::max(std::abs(2 * c2), std::abs(2 * c2 + 6 * c3 * h));
    twist[i] = std::abs(6 * c3);
    const AxisLimits& axis = axes_[i];
    if (cell.rate[i] > 0)
      speed = std::min(speed, (rapid_only ? axis.rapid : std::min(axis.feed, axis.rapid)) / cell.rate[i]);
    if (cell.bend[i] > 0) speed = std::min(speed, std::sqrt(kBendShare * axis.acceleration / cell.bend[i]));
    if (twist[i] > 0) speed = std::min(speed, std::cbrt(kTwistShare * axis.jerk / twist[i]));
  }
  cell.speed = std::min(speed, cell.feed * kMaxOverride);
  cell.acceleration = kAny;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const double per_acceleration = 3 * cell.bend[i] * cell.speed + 2 * cell.rate[i] / smoothing_s_;
    if (axes_[i].jerk < kAny && per_acceleration > 0)
      cell.acceleration =
          std::min(cell.acceleration,
                   (axes_[i].jerk - twist[i] * cell.speed * cell.speed * cell.speed) / per_acceleration);
  }
  cell.reach = cell.speed * window_s_;
}

void CellMaker::limit(RawCell& target, const RawCell& by) {
  target.speed = std::min(target.speed, by.speed);
  target.feed = std::min(target.feed, by.feed);
  target.acceleration = std::min(target.acceleration, by.acceleration);
  for (std::size_t i = 0; i < target.rate.size(); ++i) {
    target.rate[i] = std::max(target.rate[i], by.rate[i]);
    target.bend[i] = std::max(target.bend[i], by.bend[i]);
  }
}

void CellMaker::add(const Span& span) {
  RawCell cell;
  cell.begin = span.begin;
  cell.end = span.end;
  cell.straight = span.straight;
  measure(span, cell);
  spread_back(cell);
  const RawCell own = cell;
  std::erase_if(reaching_, [&](const RawCell& r) { return r.end + r.reach <= cell.begin; });
  if (cell.straight) {
    // A long straight stretch is cut where limits of the bends behind it end.
    for (;;) {
      double cut = kAny;
      for (const RawCell& r : reaching_) {
        const double at = r.end + r.reach;
        if (at > cell.begin + 0.2 * (cell.begin - r.end) + 0.02 * r.reach && at < cell.end)
          cut = std::min(cut, at);
      }
      if (cut == kAny || cell.end - cut < 0.1 * (own.end - own.begin)) break;
      RawCell part = cell;
      part.end = cut;
      append(part);
      cell.begin = cut;
    }
  }
  cell.stop = span.stop;
  append(cell);
  newest_ = span.end;
  if (span.stop) {
    reaching_.clear();
    final_ = staged_.size();
  } else {
    reaching_.push_back(own);
    while (final_ < staged_.size() && staged_[final_].end + longest_reach_ < newest_) ++final_;
  }
}

void CellMaker::append(RawCell cell) {
  for (const RawCell& r : reaching_)
    if (r.end + r.reach > cell.begin) limit(cell, r);
  staged_.push_back(cell);
}

void CellMaker::spread_back(const RawCell& from) {
  const double until = from.begin - from.reach;
  for (std::size_t k = staged_.size(); k-- > final_;) {
    RawCell& cell = staged_[k];
    if (cell.end <= until) break;
    const bool cut = cell.straight && until - cell.begin > 0.1 * (cell.end - cell.begin);
    if (cut) {
      RawCell before = cell;
      before.end = until;
      cell.begin = until;
      limit(cell, from);
      staged_.insert(staged_.begin() + static_cast<std::ptrdiff_t>(k), before);
      break;
    }
    limit(cell, from);
  }
}

bool CellMaker::next(Cell& out) {
  if (final_ == 0) return false;
  const RawCell& raw = staged_.front();
  out.begin = raw.begin;
  out.end = raw.end;
  out.stop = raw.stop;
  out.kind = raw.kind;
  out.reference_rpm = raw.reference_rpm;
  out.most_acceleration = raw.acceleration;
  out.axes = 0;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (raw.rate[i] < 1e-9) continue;
    out.gain[out.axes] = axes_[i].acceleration / raw.rate[i];
    out.loss[out.axes] = raw.bend[i] / raw.rate[i];
    ++out.axes;
  }
  for (std::size_t p = 0; p < kPlanCount; ++p) {
    const double speed = std::min(raw.speed, raw.feed * kPlans[p]);
    out.ceiling[p] = speed * speed;
    out.ceiling_braking[p] = out.acceleration_at(out.ceiling[p]);
  }
  staged_.pop_front();
  --final_;
  return true;
}

}  // namespace headstock::motion

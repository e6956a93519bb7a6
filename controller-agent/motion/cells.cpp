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
constexpr double kVelocity = 0.9995, kAcceleration = 0.995, kJerk = 0.96;
constexpr double kBendShare = 0.99;  // of the acceleration for curvature at the highest speed
// Of the jerk for twist at the highest speed. The rest is left for acceleration: with stiff axes that is what
// time is lost by, with soft ones the highest speed is reached almost everywhere.
constexpr double kTwistShare = 0.45, kSoftTwistShare = 0.7;
constexpr int kJerkPoints = 2;  // speeds the jerk limit is looked at
// Smoothing time: twice acceleration / jerk lets a straight line use its whole acceleration, once of it blurs
// half as much. The longer one pays as long as it is short beside the waves of a path.
constexpr double kLongSmoothing_s = 0.010;
// Periods. A step may begin in one cell and end in another; where the third derivative jumps the acceleration
// of a step is not that of its middle. Where it does not, what an average mixes from both sides cancels to
// the first order, and half the way is enough.
constexpr double kWindowMargin = 1.0, kSmoothMargin = 0.1;
constexpr double kSmoothWindow = 0.2, kJumpInWindow = 0.05;  // found by the property tests, not by a proof
// Of the acceleration: error of a step's middle that is small enough. Averaging adds errors of its own.
constexpr double kJump = 0.012, kJumpUnsmoothed = 0.02;
constexpr double kJerkJump = 0.5;  // of the jerk: change of what twist takes of it that is small enough
// A bend is cut into at most so many cells, as far as its reach makes a share of it worth telling apart.
struct BendParts {
  double most, blur;
};
constexpr BendParts kParts{12, 0.08}, kPartsUnsmoothed{12, 0.05};
constexpr double kMuchSlower = 0.7;  // a bend beside is cut where the limits of something as slow as this end

}  // namespace

CellMaker::CellMaker(const machine::Machine& machine) : period_s_(machine.period_us * 1e-6) {
  double longest = 0;
  for (const machine::Axis& axis : machine.axes) {
    const bool limited = axis.max_jerk_mm_s3 < kJerkUnlimited;
    axes_.push_back({kVelocity * axis.max_feed_mm_min / 60, kVelocity * axis.rapid_mm_min / 60,
                     kAcceleration * axis.max_acceleration_mm_s2,
                     limited ? kJerk * axis.max_jerk_mm_s3 : kAny});
    if (limited) longest = std::max(longest, axis.max_acceleration_mm_s2 / axis.max_jerk_mm_s3);
    jerk_limited_ = jerk_limited_ || limited;
    fastest_ = std::hypot(fastest_, std::max(axis.max_feed_mm_min, axis.rapid_mm_min) / 60);
  }
  twist_share_ = 2 * longest <= kLongSmoothing_s ? kTwistShare : kSoftTwistShare;
  own_smoothing_ = std::clamp<std::size_t>(
      static_cast<std::size_t>(
          std::lround(std::max(longest, std::min(2 * longest, kLongSmoothing_s)) / period_s_)),
      1, kMostSmoothing);
  smooth(own_smoothing_, false);
}

/// @param asked_for for a bell, not for the jerk: how far the limits of a smooth path have to reach was found
/// for the short averages only
void CellMaker::smooth(std::size_t periods, bool asked_for) {
  smoothing_periods_ = periods;
  smoothing_s_ = static_cast<double>(smoothing_periods_) * period_s_;
  // The average lies in the middle of what it averages: no value of a window is farther from it than half a
  // window at the highest speed there.
  window_s_ = (0.5 * (static_cast<double>(smoothing_periods_) - 1) + kWindowMargin) * period_s_;
  smooth_window_s_ =
      (kSmoothWindow * (static_cast<double>(smoothing_periods_) - 1) + kSmoothMargin) * period_s_;
  if (asked_for) smooth_window_s_ = window_s_;
  longest_reach_ = fastest_ * window_s_;
}

/// The path goes on behind a stop: with the shape of the move that begins there.
void CellMaker::begin_stretch(double from) {
  constexpr double kRounding_mm = 1e-9;
  const auto found = std::find_if(sections_.begin(), sections_.end(), [&](const FeedSection& section) {
    return section.end > from + kRounding_mm;
  });
  if (found == sections_.end()) return;
  const FeedSection& first = *found;
  shape_ = first.shape;
  const auto bell = static_cast<std::size_t>(std::lround(std::min(first.bell_s, kLongestBell_s) / period_s_));
  const std::size_t periods = std::min(std::max(own_smoothing_, bell), kMostSmoothing);
  if (periods != smoothing_periods_) smooth(periods, periods > own_smoothing_);
}

void CellMaker::reset() {
  sections_.clear();
  staged_.clear();
  reaching_.clear();
  final_ = 0;
  newest_ = 0;
  previous_.reset();
  pending_.reset();
}

void CellMaker::measure(const Span& span, double from, double to, RawCell& cell) {
  const double u0 = from - span.begin, h = to - from;
  double speed = kAny, bend_taken = 0, twist_taken = 0;  // of the limits, per v² and v³
  AxisVector bends{}, twist{};
  bool rapid_only = true;
  while (sections_.size() > 1 && sections_.front().end <= from) sections_.pop_front();
  cell.kind = sections_.front().kind;
  cell.reference_rpm = sections_.front().reference_rpm;
  cell.feed = cell.speed_up = cell.slow_down = kAny;
  for (const FeedSection& section : sections_) {
    cell.feed = std::min(cell.feed, section.speed);
    speed = std::min(speed, section.highest);
    cell.speed_up = std::min(cell.speed_up, section.speed_up);
    cell.slow_down = std::min(cell.slow_down, section.slow_down);
    if (section.end >= from && section.end <= to) speed = std::min(speed, section.corner);
    rapid_only = rapid_only && section.kind == FeedKind::rapid;
    if (section.end >= to) break;
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const double c3 = span.c[3][i], c2 = span.c[2][i] + 3 * c3 * u0;
    const double c1 = span.c[1][i] + u0 * (2 * span.c[2][i] + 3 * c3 * u0);
    // Bézier points of the first derivative bound it; the second is linear, the third constant.
    const double r0 = c1, r1 = c1 + c2 * h, r2 = c1 + 2 * c2 * h + 3 * c3 * h * h;
    const double b0 = 2 * c2, b1 = b0 + 6 * c3 * h;
    cell.rate[i] = std::max({std::abs(r0), std::abs(r1), std::abs(r2)});
    const double bend = std::max(std::abs(b0), std::abs(b1));
    if (std::min({r0, r1, r2}) > 0) {
      cell.bend_up[i] = std::max(b0, b1);
      cell.bend_down[i] = std::max(-b0, -b1);
    } else if (std::max({r0, r1, r2}) < 0) {
      cell.bend_up[i] = std::max(-b0, -b1);
      cell.bend_down[i] = std::max(b0, b1);
    } else {
      cell.bend_up[i] = cell.bend_down[i] = bend;
    }
    bends[i] = bend;
    twist[i] = std::abs(6 * c3);
    const AxisLimits& axis = axes_[i];
    if (cell.rate[i] > 0)
      speed = std::min(speed, (rapid_only ? axis.rapid : std::min(axis.feed, axis.rapid)) / cell.rate[i]);
    bend_taken = std::max(bend_taken, bend / axis.acceleration);
    twist_taken = std::max(twist_taken, twist[i] / axis.jerk);
  }
  if (bend_taken > 0) speed = std::min(speed, std::sqrt(kBendShare / bend_taken));
  if (twist_taken > 0) speed = std::min(speed, std::cbrt(twist_share_ / twist_taken));
  cell.speed = std::min(speed, cell.feed * kMaxOverride);
  limit_by_jerk(bends, twist, cell);
  cell.reach = cell.speed * window_s_;
  if (smooth_around(span, cell.speed)) cell.reach = cell.speed * smooth_window_s_;
}

void CellMaker::limit_by_jerk(const AxisVector& bends, const AxisVector& twist, RawCell& cell) const {
  cell.jerk_gain = kAny;
  cell.jerk_loss = 0;
  if (!jerk_limited_) return;
  // Per axis |a| <= (J - twist v³) / (3 bend v + 2 rate / smoothing time). The steepest line in v² that ends
  // on it at the highest speed and is nowhere above it.
  std::array<double, kJerkPoints + 1> allowed;
  for (int k = 0; k <= kJerkPoints; ++k) {
    const double v = cell.speed * k / kJerkPoints;
    double& a = allowed[static_cast<std::size_t>(k)] = kAny;
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const double per_acceleration = 3 * bends[i] * v + 2 * cell.rate[i] / smoothing_s_;
      if (!(axes_[i].jerk < kAny) || per_acceleration <= 0) continue;
      a = std::min(a, (axes_[i].jerk - twist[i] * v * v * v) / per_acceleration);
    }
  }
  const double fastest = allowed.back(), square = cell.speed * cell.speed;
  if (!(fastest < kAny)) return;
  double loss = kAny;
  for (int k = 0; k < kJerkPoints && square > 0; ++k) {
    const double share = 1 - static_cast<double>(k * k) / (kJerkPoints * kJerkPoints);
    loss = std::min(loss, (allowed[static_cast<std::size_t>(k)] - fastest) / (share * square));
  }
  cell.jerk_loss = loss < kAny ? std::max(0.0, loss) : 0;
  cell.jerk_gain = fastest + cell.jerk_loss * square;
}

void CellMaker::limit(RawCell& target, const RawCell& by) {
  target.speed = std::min(target.speed, by.speed);
  target.feed = std::min(target.feed, by.feed);
  target.speed_up = std::min(target.speed_up, by.speed_up);
  target.slow_down = std::min(target.slow_down, by.slow_down);
  target.jerk_gain = std::min(target.jerk_gain, by.jerk_gain);
  target.jerk_loss = std::max(target.jerk_loss, by.jerk_loss);
  for (std::size_t i = 0; i < target.rate.size(); ++i) {
    target.rate[i] = std::max(target.rate[i], by.rate[i]);
    target.bend_up[i] = std::max(target.bend_up[i], by.bend_up[i]);
    target.bend_down[i] = std::max(target.bend_down[i], by.bend_down[i]);
  }
}

bool CellMaker::smooth_around(const Span& span, double speed) const {
  // Error of the middle of what is averaged, when the third derivative jumps there.
  const double factor = speed * speed * speed * period_s_ *
                        std::max(1.0, kJumpInWindow * static_cast<double>(smoothing_periods_));
  const double twist = 6 * speed * speed * speed;
  const double small = smoothing_periods_ > 1 ? kJump : kJumpUnsmoothed;
  const auto jumps = [&](const Span& other) {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const double jump = std::abs(span.c[3][i] - other.c[3][i]);
      if (jump * factor > small * axes_[i].acceleration || jump * twist > kJerkJump * axes_[i].jerk)
        return true;
    }
    return false;
  };
  const Span straight{};
  return !jumps(previous_ ? *previous_ : straight) && !jumps(following_ ? *following_ : straight);
}

void CellMaker::add(const Span& span) {
  // One span late: what follows decides how far its limits have to reach.
  if (pending_) {
    following_ = &span;
    cut(*pending_);
    previous_ = *pending_;
  }
  if (!pending_) begin_stretch(span.begin);
  pending_ = span;
  if (!span.stop) return;
  following_ = nullptr;
  cut(span);
  previous_.reset();
  pending_.reset();
}

void CellMaker::cut(const Span& span) {
  // A bend is cut so that its limits follow it, as far as spreading them would not blur that again; a
  // straight stretch has only one set.
  const double length = span.end - span.begin;
  int parts = 1;
  RawCell whole;
  whole.begin = span.begin;
  whole.end = span.end;
  whole.straight = span.straight;
  whole.shape = shape_;
  whole.smoothing = static_cast<std::uint16_t>(smoothing_periods_);
  measure(span, span.begin, span.end, whole);
  if (!span.straight) {
    const BendParts& cuts = smoothing_periods_ > 1 ? kParts : kPartsUnsmoothed;
    parts = static_cast<int>(std::clamp(std::ceil(length / (cuts.blur * whole.reach)), 1.0, cuts.most));
  }
  if (parts == 1) {
    add_cell(whole, span.stop);
    return;
  }
  double from = span.begin;
  for (int i = 1; i <= parts; ++i) {
    const double to = i == parts ? span.end : span.begin + length * i / parts;
    RawCell cell = whole;
    cell.begin = from;
    cell.end = to;
    measure(span, from, to, cell);
    add_cell(cell, span.stop && i == parts);
    from = to;
  }
}

void CellMaker::add_cell(RawCell cell, bool stop) {
  spread_back(cell);
  const RawCell own = cell;
  // A straight stretch is cut where limits of what is behind it end, a bend where that was much slower.
  ending_.clear();
  std::size_t passed = 0;
  for (const RawCell& r : reaching_) {
    const double at = r.end + r.reach;
    if (at <= cell.begin)
      ++passed;
    else if (at < cell.end && (cell.straight || r.speed < kMuchSlower * cell.speed))
      ending_.push_back({at, r.end, r.reach});
  }
  if (2 * passed > reaching_.size())  // moving the others costs more than looking at these
    std::erase_if(reaching_, [&](const RawCell& r) { return r.end + r.reach <= cell.begin; });
  while (!ending_.empty()) {
    // Ends close together share one cut, behind the last of them.
    double together = kAny, cut = kAny, grouped = 0;
    for (const Ending& r : ending_)
      if (r.at > cell.begin) together = std::min(together, 0.2 * (cell.begin - r.end) + 0.02 * r.reach);
    for (const Ending& r : ending_) {
      if (r.at <= cell.begin) continue;
      if (r.at < cell.begin + together)
        grouped = std::max(grouped, r.at);
      else
        cut = std::min(cut, r.at);
    }
    if (grouped > 0) cut = grouped;
    if (cut == kAny || cell.end - cut < 0.1 * (own.end - own.begin)) break;
    RawCell part = cell;
    part.end = cut;
    append(part);
    cell.begin = cut;
  }
  cell.stop = stop;
  append(cell);
  newest_ = own.end;
  if (stop) {
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
    const bool cut = (cell.straight || from.speed < kMuchSlower * cell.speed) &&
                     until - cell.begin > 0.1 * (cell.end - cell.begin);
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
  out.shape = raw.shape;
  out.smoothing = raw.smoothing;
  out.kind = raw.kind;
  out.reference_rpm = raw.reference_rpm;
  out.speed_up = raw.speed_up;
  out.slow_down = raw.slow_down;
  out.jerk_gain = raw.jerk_gain;
  out.jerk_loss = raw.jerk_loss;
  out.axes = 0;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (raw.rate[i] < 1e-9) continue;
    out.gain[out.axes] = axes_[i].acceleration / raw.rate[i];
    // Curvature that helps is counted on only without averaging: the average of v² is not the average's
    // square.
    const double help = raw.smoothing > 1 ? 0 : -kAny;
    out.loss_up[out.axes] = std::max(help, raw.bend_up[i]) / raw.rate[i];
    out.loss_down[out.axes] = std::max(help, raw.bend_down[i]) / raw.rate[i];
    ++out.axes;
  }
  for (std::size_t p = 0; p < kPlanCount; ++p) {
    const double speed = std::min(raw.speed, raw.feed * kPlans[p]);
    out.ceiling[p] = speed * speed;
    out.ceiling_braking[p] = out.braking_up_to(out.ceiling[p]);
  }
  staged_.pop_front();
  --final_;
  return true;
}

}  // namespace headstock::motion

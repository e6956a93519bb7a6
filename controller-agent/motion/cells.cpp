#include "motion/cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace headstock::motion {

namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr double kJerkUnlimited = 1e9;
// Shares of the limits. The rest of the acceleration brakes in a curve taken at its highest speed; the small
// margins pay for derivatives that change within one period.
constexpr double kVelocity = 0.9995, kAcceleration = 0.995, kJerk = 0.96;
constexpr double kStraight = 0.9995;  // of the acceleration, where an axis has nothing else to do with it
constexpr double kBendShare = 0.99;  // of the acceleration for curvature at the highest speed
// Of the jerk for twist at the highest speed. The rest is left for acceleration: with stiff axes that is what
// time is lost by, with soft ones the highest speed is reached almost everywhere.
constexpr double kTwistShare = 0.45, kSoftTwistShare = 0.7;
constexpr int kJerkPoints = 2;  // speeds the jerk limit is looked at
// Smoothing time: twice acceleration / jerk lets a straight line use its whole acceleration, once of it blurs
// half as much. The longer one pays as long as it is short beside the waves of a path.
constexpr double kLongSmoothing_s = 0.010;
// Periods of an average, or steps of the law. A step may begin in one cell and end in another; where the
// third derivative jumps the acceleration of a step is not that of its middle. Where it does not, what an
// average mixes from both sides cancels to the first order, and half the way is enough.
constexpr double kWindowMargin = 1.0, kSmoothMargin = 0.1;
constexpr double kSmoothWindow = 0.2, kJumpInWindow = 0.05;  // found by the property tests, not by a proof
// Of the acceleration: error of a step's middle that is small enough. Averaging adds errors of its own.
constexpr double kJump = 0.012, kJumpUnsmoothed = 0.02;
constexpr double kJerkJump = 0.5;  // of the jerk: change of what twist takes of it that is small enough
// A bend is cut into at most so many cells, as far as its reach makes a share of it worth telling apart.
struct BendParts {
  double most, blur;
};
constexpr BendParts kParts{12, 0.08}, kPartsUnsmoothed{24, 0.4};
constexpr double kMuchSlower = 0.7;  // a bend beside is cut where the limits of something as slow as this end
constexpr double kLowerFeed = 0.98;  // … or as such a share of its feed
constexpr double kLeastRate = 0.1;   // of the path: turning back on itself it has none
constexpr std::size_t kTakenKept = 256;  // cells handed over, before their place is taken back

double least_of(const AxisVector& values) {
  AxisVector v = values;
  for (std::size_t half = v.size() / 2; half > 0; half /= 2)
    for (std::size_t i = 0; i < half; ++i) v[i] = std::min(v[i], v[i + half]);
  return v[0];
}

double most_of(const AxisVector& values) {
  AxisVector v = values;
  for (std::size_t half = v.size() / 2; half > 0; half /= 2)
    for (std::size_t i = 0; i < half; ++i) v[i] = std::max(v[i], v[i + half]);
  return v[0];
}

/// Is a bend worth cutting where the limits of something with these speeds end?
bool much_slower(double speed, double feed, const CellLimits& bend) {
  return speed < kMuchSlower * bend.speed || feed < kLowerFeed * std::min(bend.feed, bend.speed);
}

/// Both cells' limits. Called some hundred times a segment: all lanes, whatever axes there are, nothing that
/// could be the other cell, and not inlined, where the compiler forgets that: a few instructions on whole
/// registers.
[[gnu::noinline]] void limit(CellLimits& __restrict target, const CellLimits& __restrict by, bool feed_too) {
  for (std::size_t i = 0; i < target.rate.size(); ++i) target.rate[i] = std::max(target.rate[i], by.rate[i]);
  for (std::size_t i = 0; i < target.rate.size(); ++i)
    target.bend_up[i] = std::max(target.bend_up[i], by.bend_up[i]);
  for (std::size_t i = 0; i < target.rate.size(); ++i)
    target.bend_down[i] = std::max(target.bend_down[i], by.bend_down[i]);
  target.speed = std::min(target.speed, by.speed);
  target.feed = std::min(target.feed, feed_too ? by.feed : kAny);
  target.speed_up = std::min(target.speed_up, by.speed_up);
  target.slow_down = std::min(target.slow_down, by.slow_down);
  target.jerk_gain = std::min(target.jerk_gain, by.jerk_gain);
  target.jerk_loss = std::max(target.jerk_loss, by.jerk_loss);
}

}  // namespace

CellMaker::CellMaker(const machine::Machine& machine)
    : axes_(machine.axes.size()),
      period_s_(machine.period_us * 1e-6),
      law_steps_(std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(period_s_ / kLawStep_s)))) {
  for (AxisVector* limits : {&feed_, &rapid_, &acceleration_, &jerk_}) limits->fill(kAny);
  double longest = 0;
  for (std::size_t i = 0; i < axes_; ++i) {
    const machine::Axis& axis = machine.axes[i];
    const bool limited = axis.max_jerk_mm_s3 < kJerkUnlimited;
    feed_[i] = kVelocity * axis.max_feed_mm_min / 60;
    rapid_[i] = kVelocity * axis.rapid_mm_min / 60;
    acceleration_[i] = kAcceleration * axis.max_acceleration_mm_s2;
    if (limited) jerk_[i] = kJerk * axis.max_jerk_mm_s3;
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
  mixes_feeds_ = periods > 1;
  between_s_ = periods > 1 ? period_s_ : period_s_ / static_cast<double>(law_steps_);
  // The average lies in the middle of what it averages: no value of a window is farther from it than half a
  // window at the highest speed there.
  window_s_ = (0.5 * (static_cast<double>(smoothing_periods_) - 1) + kWindowMargin) * between_s_;
  smooth_window_s_ =
      (kSmoothWindow * (static_cast<double>(smoothing_periods_) - 1) + kSmoothMargin) * between_s_;
  if (asked_for) smooth_window_s_ = window_s_;
  longest_reach_ = fastest_ * std::max(window_s_, period_s_);
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
  taken_ = final_ = 0;
  newest_ = 0;
  previous_twist_ = AxisVector{};
  pending_.reset();
}

void CellMaker::measure(const Span& span, double from, double to, RawCell& cell) {
  const double u0 = from - span.begin, h = to - from;
  double speed = kAny, corner = kAny;
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
    if (section.end >= from && section.end <= to) corner = std::min(corner, section.corner);
    rapid_only = rapid_only && section.kind == FeedKind::rapid;
    if (section.end >= to) break;
  }
  AxisVector axis_speed, bend_share, twist_share;
  double rate_0 = 0, rate_1 = 0, rate_2 = 0;  // squares of |q'|
  for (std::size_t i = 0; i < bends.size(); ++i) {
    const double c3 = span.c[3][i], c2 = span.c[2][i] + 3 * c3 * u0;
    const double c1 = span.c[1][i] + u0 * (2 * span.c[2][i] + 3 * c3 * u0);
    // Bézier points of the first derivative bound it; the second is linear, the third constant.
    const double r0 = c1, r1 = c1 + c2 * h, r2 = c1 + 2 * c2 * h + 3 * c3 * h * h;
    const double b0 = 2 * c2, b1 = b0 + 6 * c3 * h;
    rate_0 += r0 * r0;
    rate_1 += r1 * r1;
    rate_2 += r2 * r2;
    const double lowest = std::min(r0, std::min(r1, r2)), highest = std::max(r0, std::max(r1, r2));
    const double most = std::max(b0, b1), least = std::max(-b0, -b1), bend = std::max(most, least);
    cell.rate[i] = std::max(highest, -lowest);
    cell.bend_up[i] = lowest > 0 ? most : highest < 0 ? least : bend;
    cell.bend_down[i] = lowest > 0 ? least : highest < 0 ? most : bend;
    bends[i] = bend;
    twist[i] = std::abs(6 * c3);
    // A rate of nothing, and limits of an axis that the machine has not, make infinity and nothing.
    axis_speed[i] = (rapid_only ? rapid_[i] : std::min(feed_[i], rapid_[i])) / cell.rate[i];
    bend_share[i] = bend / acceleration_[i];
    twist_share[i] = twist[i] / jerk_[i];
  }
  // Rounding makes the path shorter than programmed; feed and highest speeds are those of the tool along it.
  const double rate = std::clamp(std::sqrt(std::max({rate_0, rate_1, rate_2})), kLeastRate, 1.0);
  cell.feed /= rate;
  speed = std::min(std::min(speed, corner) / rate, least_of(axis_speed));
  const double bend_taken = most_of(bend_share), twist_taken = most_of(twist_share);  // per v² and v³
  if (bend_taken > 0) speed = std::min(speed, std::sqrt(kBendShare / bend_taken));
  if (twist_taken > 0) speed = std::min(speed, std::cbrt(twist_share_ / twist_taken));
  cell.speed = std::min(speed, cell.feed * kMaxOverride);
  limit_by_jerk(bends, twist, cell);
  cell.reach = cell.speed * window_s_;
  if (smooth_around(cell.speed)) cell.reach = cell.speed * smooth_window_s_;
  // A corner's own speed is that of the whole period in which it is passed.
  if (corner < kAny) cell.reach = std::max(cell.reach, cell.speed * period_s_);
}

void CellMaker::limit_by_jerk(const AxisVector& bends, const AxisVector& twist, RawCell& cell) const {
  cell.jerk_gain = kAny;
  cell.jerk_loss = 0;
  if (!jerk_limited_) return;
  // Per axis |a| <= (J - twist v³) / (3 bend v + 2 rate / smoothing time). The steepest line in v² that ends
  // on it at the highest speed and is nowhere above it. The speed leaves some of the jerk, so the numerator
  // is above 0; an axis that does not move, or has no such limit, allows anything.
  AxisVector at_once;
  for (std::size_t i = 0; i < at_once.size(); ++i) at_once[i] = 2 * cell.rate[i] / smoothing_s_;
  std::array<double, kJerkPoints + 1> allowed;
  for (int k = 0; k <= kJerkPoints; ++k) {
    const double v = cell.speed * k / kJerkPoints;
    AxisVector a;
    for (std::size_t i = 0; i < a.size(); ++i)
      a[i] = (jerk_[i] - twist[i] * v * v * v) / (3 * bends[i] * v + at_once[i]);
    allowed[static_cast<std::size_t>(k)] = least_of(a);
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

bool CellMaker::smooth_around(double speed) const {
  // Error of the middle of what is averaged, when the third derivative jumps there.
  const double factor = speed * speed * speed * between_s_ *
                        std::max(1.0, kJumpInWindow * static_cast<double>(smoothing_periods_));
  const double twist = 6 * speed * speed * speed;
  const double small = smoothing_periods_ > 1 ? kJump : kJumpUnsmoothed;
  bool smooth = true;
  for (std::size_t i = 0; i < axes_; ++i)
    smooth =
        smooth && jump_[i] * factor <= small * acceleration_[i] && jump_[i] * twist <= kJerkJump * jerk_[i];
  return smooth;
}

void CellMaker::add(const Span& span) {
  // One span late: what follows decides how far its limits have to reach.
  if (pending_) {
    cut(*pending_, span.c[3]);
    previous_twist_ = pending_->c[3];
  } else {
    begin_stretch(span.begin);
  }
  pending_ = span;
  if (!span.stop) return;
  cut(span, AxisVector{});
  previous_twist_ = AxisVector{};
  pending_.reset();
}

/// Moves that go on in one line are one span. A piece too short to be a programmed one shares the lower feed.
double CellMaker::same_feed_until(double from, double end) const {
  constexpr double kShortest_mm = 1e-3;
  for (std::size_t i = 0; i + 1 < sections_.size() && sections_[i].end < end - kShortest_mm; ++i) {
    const FeedSection &here = sections_[i], &next = sections_[i + 1];
    if (here.end > from + kShortest_mm &&
        std::tie(here.kind, here.speed, here.reference_rpm, here.highest, here.speed_up, here.slow_down) !=
            std::tie(next.kind, next.speed, next.reference_rpm, next.highest, next.speed_up, next.slow_down))
      return here.end;
  }
  return end;
}

void CellMaker::cut(const Span& span, const AxisVector& following_twist) {
  for (std::size_t i = 0; i < jump_.size(); ++i)
    jump_[i] =
        std::max(std::abs(span.c[3][i] - previous_twist_[i]), std::abs(span.c[3][i] - following_twist[i]));
  // A bend is cut so that its limits follow it, as far as spreading them would not blur that again; a
  // straight stretch has only one set of its own, and is cut where another feed begins.
  RawCell cell;
  cell.begin = span.begin;
  cell.end = span.end;
  cell.straight = span.straight;
  cell.shape = shape_;
  cell.smoothing = static_cast<std::uint16_t>(smoothing_periods_);
  if (span.straight) {
    do {
      cell.end = same_feed_until(cell.begin, span.end);
      measure(span, cell.begin, cell.end, cell);
      add_cell(cell, span.stop && cell.end == span.end);
      cell.begin = cell.end;
    } while (cell.end < span.end);
    return;
  }
  measure(span, span.begin, span.end, cell);
  const double length = span.end - span.begin;
  const BendParts& cuts = smoothing_periods_ > 1 ? kParts : kPartsUnsmoothed;
  const int parts =
      static_cast<int>(std::clamp(std::ceil(length / (cuts.blur * cell.reach)), 1.0, cuts.most));
  if (parts == 1) {
    add_cell(cell, span.stop);
    return;
  }
  double from = span.begin;
  for (int i = 1; i <= parts; ++i) {
    const double to = i == parts ? span.end : span.begin + length * i / parts;
    cell.begin = from;
    cell.end = to;
    measure(span, from, to, cell);
    add_cell(cell, span.stop && i == parts);
    from = to;
  }
}

void CellMaker::add_cell(const RawCell& own, bool stop) {
  spread_back(own);
  // A straight stretch is cut where limits of what is behind it end, a bend where that was much slower.
  ending_.clear();
  std::size_t passed = 0;
  for (const Reaching& some : reaching_) {
    if (some.most_until <= own.begin) {
      ++passed;
      continue;
    }
    if (some.least_until >= own.end) continue;
    for (std::size_t i = 0; i < some.count; ++i) {
      const Reaching::One& r = some.ones[i];
      if (r.until > own.begin && r.until < own.end && (own.straight || much_slower(r.speed, r.feed, own)))
        ending_.push_back({r.until, r.end, r.reach});
    }
  }
  if (2 * passed > reaching_.size())  // moving the others costs more than looking at these
    std::erase_if(reaching_, [&](const Reaching& some) { return some.most_until <= own.begin; });
  double begin = own.begin;
  while (!ending_.empty()) {
    // Ends close together share one cut, behind the last of them.
    double together = kAny, cut = kAny, grouped = 0;
    for (const Ending& r : ending_)
      if (r.at > begin) together = std::min(together, 0.2 * (begin - r.end) + 0.02 * r.reach);
    for (const Ending& r : ending_) {
      if (r.at <= begin) continue;
      if (r.at < begin + together)
        grouped = std::max(grouped, r.at);
      else
        cut = std::min(cut, r.at);
    }
    if (grouped > 0) cut = grouped;
    if (cut == kAny || own.end - cut < 0.1 * (own.end - own.begin)) break;
    append(own, begin, cut);
    begin = cut;
  }
  append(own, begin, own.end);
  newest_ = own.end;
  if (stop) {
    staged_.back().stop = true;
    reaching_.clear();
    final_ = staged_.size();
  } else {
    if (reaching_.empty() || reaching_.back().count == Reaching::kMost)
      reaching_.emplace_back(own);
    else
      reaching_.back().add(own);
    while (final_ < staged_.size() && staged_[final_].end + longest_reach_ < newest_) ++final_;
  }
}

void CellMaker::append(const RawCell& cell, double begin, double end) {
  RawCell& last = staged_.emplace_back(cell);
  last.begin = begin;
  last.end = end;
  for (const Reaching& some : reaching_) {
    if (some.most_until <= begin) continue;
    if (some.least_until > begin) {
      limit(last, some.together, mixes_feeds_);
      continue;
    }
    for (std::size_t i = 0; i < some.count; ++i)
      if (some.ones[i].until > begin) limit(last, some.limits[i], mixes_feeds_);
  }
}

CellMaker::Reaching::Reaching(const RawCell& own)
    : together(own), least_until(own.end + own.reach), most_until(least_until) {
  add(own);
}

void CellMaker::Reaching::add(const RawCell& own) {
  const double until = own.end + own.reach;
  ones[count] = {until, own.end, own.reach, own.speed, own.feed};
  limits[count++] = own;
  limit(together, own, true);
  least_until = std::min(least_until, until);
  most_until = std::max(most_until, until);
}

void CellMaker::spread_back(const RawCell& from) {
  const double until = from.begin - from.reach;
  for (std::size_t k = staged_.size(); k-- > final_;) {
    RawCell& cell = staged_[k];
    if (cell.end <= until) break;
    const bool cut = (cell.straight || much_slower(from.speed, from.feed, cell)) &&
                     until - cell.begin > 0.1 * (cell.end - cell.begin);
    if (cut) {
      RawCell before = cell;
      before.end = until;
      cell.begin = until;
      limit(cell, from, mixes_feeds_);
      staged_.insert(staged_.begin() + static_cast<std::ptrdiff_t>(k), before);
      break;
    }
    limit(cell, from, mixes_feeds_);
  }
}

bool CellMaker::next(Cell& out) {
  if (taken_ == final_) return false;
  const RawCell& raw = staged_[taken_];
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
  for (std::size_t i = 0; i < axes_; ++i) {
    if (raw.rate[i] < 1e-9) continue;
    const bool bends = raw.bend_up[i] > 0 || raw.bend_down[i] > 0;
    out.gain[out.axes] = acceleration_[i] * (bends ? 1 : kStraight / kAcceleration) / raw.rate[i];
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
  if (++taken_ == kTakenKept) {
    staged_.erase(staged_.begin(), staged_.begin() + kTakenKept);
    final_ -= kTakenKept;
    taken_ = 0;
  }
  return true;
}

}  // namespace headstock::motion

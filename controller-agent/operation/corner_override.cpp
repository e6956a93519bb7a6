#include "operation/corner_override.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "operation/path_length.hpp"

namespace headstock::operation {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kLeastCorner = 2 * kDegree, kMostCorner = 178 * kDegree;
constexpr double kJudgement = 0.001 * kDegree;  // how exactly the angle is judged (0i-D L5045)
constexpr double kShortest_mm = 1e-4;           // no piece shorter than this is made
constexpr std::size_t kMostKept = 64;           // moves that one corner reaches back over
constexpr int kSteps = 64;
constexpr std::size_t kPlaneGroup = 2, kCompensationGroup = 7;

std::pair<char, char> plane_of(std::int16_t tenths) {
  if (tenths == 180) return {'Z', 'X'};
  if (tenths == 190) return {'Y', 'Z'};
  return {'X', 'Y'};
}

int quadrant(double x, double y) {
  return x >= 0 ? (y >= 0 ? 0 : 3) : (y >= 0 ? 1 : 2);
}

/// Arcs take part when they begin and end in the same or in neighbouring quadrants (0i-D L5105).
bool takes_part(const motion::Curve& curve) {
  if (!curve.is_arc) return true;
  const int from =
      quadrant(curve.start[curve.axis_1] - curve.center_1, curve.start[curve.axis_2] - curve.center_2);
  const int to = quadrant(curve.end[curve.axis_1] - curve.center_1, curve.end[curve.axis_2] - curve.center_2);
  return (to - from + 4) % 4 != 2;
}

}  // namespace

CornerOverrideRules CornerOverrideRules::read(const interp::MachineData& data) {
  CornerOverrideRules rules;
  const double angle = data.parameter("1711"), percent = data.parameter("1712");
  rules.ratio = percent / 100;
  rules.widest_rad = angle * kDegree;
  rules.before_mm = std::max(0.0, data.parameter("1713"));
  rules.after_mm = std::max(0.0, data.parameter("1714"));
  rules.valid = angle >= 2 && angle <= 178 && percent >= 1 && percent <= 100;
  return rules;
}

CuttingSide CuttingSide::of(const interp::Motion& motion, const machine::Machine& machine) {
  CuttingSide cutting;
  if (motion.cutting_mode != interp::CuttingMode::corner_override) return cutting;
  const std::int16_t compensation = motion.modal.g[kCompensationGroup];
  if (compensation != 410 && compensation != 420) return cutting;
  const auto [first, second] = plane_of(motion.modal.g[kPlaneGroup]);
  const auto axis_1 = machine.axis_index(first), axis_2 = machine.axis_index(second);
  if (!axis_1 || !axis_2) return cutting;
  cutting.side = compensation == 410 ? 1 : -1;
  cutting.axis_1 = static_cast<std::uint8_t>(*axis_1);
  cutting.axis_2 = static_cast<std::uint8_t>(*axis_2);
  return cutting;
}

std::optional<MachineAlarm> corner_override_alarm(const CuttingSide& side, const CornerOverrideRules& rules) {
  if (side.side == 0 || rules.valid) return std::nullopt;
  return MachineAlarm{"PS0148", "Setting error (corner override, No. 1711, 1712)",
                      "设定数据错误（拐角倍率 No.1711、1712）"};
}

void CornerOverride::reset() {
  kept_.clear();
  side_ = {};
  started_ = false;
  before_.reset();
  behind_.reset();
}

void CornerOverride::release() {
  for (const Kept& kept : kept_) sink_(kept.start, kept.move);
  kept_.clear();
}

void CornerOverride::add(const AxisVector& start, const motion::Move& move, const CuttingSide& side) {
  const bool running = side.side != 0 && side == side_;  // not the block that starts the compensation
  if (side.side == 0) {
    release();
    reset();
    sink_(start, move);
    return;
  }
  const motion::Curve curve = motion::Curve::from(start, move, axes_);
  const bool cutting = !std::holds_alternative<motion::RapidFeed>(move.feed);
  const bool corner = running && started_ && cutting && before_ && is_inner(*before_, curve);
  if (!running || !cutting) behind_.reset();
  side_ = side;
  started_ = running;
  before_ = cutting ? std::optional(curve) : std::nullopt;
  if (corner) {
    slow_before(start);
    behind_ = start;
  }
  kept_.push_back({start, move, curve, takes_part(curve)});
  if (behind_) slow_after();
  // What lies farther from the end than a corner reaches is settled.
  double length = 0;
  std::size_t needed = 0;
  while (needed < kept_.size() && (needed == 0 || length < rules_.before_mm))
    length += kept_[kept_.size() - ++needed].curve.length;
  while (kept_.size() > std::min(needed, kMostKept)) {
    sink_(kept_.front().start, kept_.front().move);
    kept_.pop_front();
  }
}

bool CornerOverride::is_inner(const motion::Curve& from, const motion::Curve& to) const {
  const AxisVector before = from.tangent(from.length), after = to.tangent(0);
  const double x0 = before[side_.axis_1], y0 = before[side_.axis_2], x1 = after[side_.axis_1],
               y1 = after[side_.axis_2];
  const double turn = std::atan2(x0 * y1 - y0 * x1, x0 * x1 + y0 * y1) * side_.side;  // > 0: toward the tool
  const double inside = std::numbers::pi - turn;
  return turn > 0 && inside >= kLeastCorner - kJudgement &&
         inside <= std::min(rules_.widest_rad, kMostCorner) + kJudgement;
}

double CornerOverride::length_at(const motion::Curve& curve, const AxisVector& corner, double distance,
                                 bool from_end) const {
  const auto away = [&](double share) {
    return motion::distance(curve.point(from_end ? curve.length * (1 - share) : curve.length * share),
                            corner);
  };
  double inside = 0, outside = 1;
  for (int i = 1; i <= kSteps; ++i) {
    outside = static_cast<double>(i) / kSteps;
    if (away(outside) > distance) break;
    inside = outside;
  }
  if (inside == outside) return from_end ? 0 : curve.length;  // all of it is near
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (inside + outside);
    (away(middle) > distance ? outside : inside) = middle;
  }
  return from_end ? curve.length * (1 - inside) : curve.length * inside;
}

bool CornerOverride::cut(std::size_t index, double length) {
  const Kept whole = kept_[index];
  if (length < kShortest_mm || length > whole.curve.length - kShortest_mm) return false;
  Kept first = whole, second = whole;
  const double share = length / whole.curve.length;
  const AxisVector at = whole.curve.point(length);
  if (auto* arc = std::get_if<motion::Arc>(&first.move.geometry)) {
    arc->end = at;
    arc->angle_rad *= share;
    std::get<motion::Arc>(second.move.geometry).angle_rad *= 1 - share;
  } else {
    first.move.geometry = motion::Line{at};
  }
  first.move.exact_stop = first.move.block_end = false;
  first.move.corner_mm_s = 0;
  second.start = at;
  first.curve = motion::Curve::from(first.start, first.move, axes_);
  second.curve = motion::Curve::from(second.start, second.move, axes_);
  kept_[index] = second;
  kept_.insert(kept_.begin() + static_cast<std::ptrdiff_t>(index), first);
  return true;
}

void CornerOverride::slow(Kept& kept) const {
  if (kept.slowed) return;
  kept.slowed = true;
  if (auto* feed = std::get_if<motion::PathFeed>(&kept.move.feed)) feed->mm_s *= rules_.ratio;
  if (auto* feed = std::get_if<motion::RevolutionFeed>(&kept.move.feed)) feed->mm_rev *= rules_.ratio;
}

void CornerOverride::slow_before(const AxisVector& corner) {
  for (std::size_t k = kept_.size(); k-- > 0;) {
    if (!kept_[k].takes_part) return;
    const double from = length_at(kept_[k].curve, corner, rules_.before_mm, true);
    const double length = kept_[k].curve.length;
    if (from > length - kShortest_mm) return;  // nothing of it is near
    if (cut(k, from)) {
      slow(kept_[k + 1]);
      return;
    }
    slow(kept_[k]);
  }
}

void CornerOverride::slow_after() {
  const std::size_t newest = kept_.size() - 1;
  const motion::Curve& curve = kept_[newest].curve;
  const double until = kept_[newest].takes_part ? length_at(curve, *behind_, rules_.after_mm, false) : 0;
  if (until < kShortest_mm) {
    behind_.reset();
    return;
  }
  if (cut(newest, until)) behind_.reset();
  slow(kept_[newest]);  // the first of the two
}

}  // namespace headstock::operation

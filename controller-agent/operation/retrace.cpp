#include "operation/retrace.hpp"

#include <algorithm>
#include <cmath>

#include "axes/arc_path.hpp"
#include "operation/path_length.hpp"

namespace headstock::operation {
namespace {

constexpr double kNoWay_mm = 1e-6;

}  // namespace

void Retrace::record(const AxisVector& start, const motion::Move& move) {
  if (!moves_.empty() && end_of(moves_.back().move) != start) forget();
  moves_.push_back({start, move, path_length(start, move)});
  if (moves_.size() <= kKept) return;
  moves_.pop_front();
  ++first_;
}

void Retrace::forget() {
  first_ += static_cast<std::int64_t>(moves_.size());
  moves_.clear();
  active_ = false;
}

AxisVector Retrace::point(const Executed& executed, double share) const {
  if (share >= 1) return end_of(executed.move);
  if (share <= 0) return executed.start;
  if (const auto* arc = std::get_if<motion::Arc>(&executed.move.geometry))
    return axes::ArcPath(executed.start, *arc).position(arc->angle_rad * share);
  AxisVector p = executed.start;
  const AxisVector& end = end_of(executed.move);
  for (std::size_t i = 0; i < machine_.axes.size(); ++i) p[i] += (end[i] - p[i]) * share;
  return p;
}

double Retrace::share_of(const Executed& executed, const AxisVector& position) const {
  const AxisVector& end = end_of(executed.move);
  if (const auto* arc = std::get_if<motion::Arc>(&executed.move.geometry)) {
    const axes::ArcPath path(executed.start, *arc);
    const double here =
        std::atan2(position[arc->axis_2] - arc->center_2, position[arc->axis_1] - arc->center_1);
    const double turn = 2 * M_PI * (arc->angle_rad < 0 ? -1 : 1);
    double angle = std::remainder(here - path.start_angle(), 2 * M_PI);
    if (angle * turn < 0) angle += turn;
    // Of several turns the one that fits the other axes best.
    double best = 0, least = -1;
    for (; std::abs(angle) <= std::abs(arc->angle_rad) + M_PI; angle += turn) {
      const double share = std::clamp(angle / arc->angle_rad, 0.0, 1.0);
      const AxisVector there = point(executed, share);
      double gap = 0;
      for (std::size_t i = 0; i < machine_.axes.size(); ++i)
        gap += (there[i] - position[i]) * (there[i] - position[i]);
      if (least >= 0 && gap >= least) continue;
      least = gap;
      best = share;
    }
    return best;
  }
  double along = 0, square = 0;
  for (std::size_t i = 0; i < machine_.axes.size(); ++i) {
    const double d = end[i] - executed.start[i];
    along += (position[i] - executed.start[i]) * d;
    square += d * d;
  }
  return square > 0 ? std::clamp(along / square, 0.0, 1.0) : 1;
}

motion::Move Retrace::part(const Executed& executed, double from, double to) const {
  motion::Move move;
  move.tolerance_mm = std::min(machine_.tolerance_mm, executed.move.tolerance_mm);  // less near a forbidden zone
  const AxisVector end = point(executed, to);
  const auto* arc = std::get_if<motion::Arc>(&executed.move.geometry);
  if (arc == nullptr) {
    move.geometry = motion::Line{end};
  } else {
    motion::Arc piece = *arc;
    piece.end = end;
    piece.angle_rad = arc->angle_rad * (to - from);
    move.geometry = piece;
  }
  return move;
}

bool Retrace::retraceable(std::int64_t move) const {
  return move >= first_ && move <= last() && !std::holds_alternative<motion::ThreadFeed>(at(move).move.feed);
}

bool Retrace::begin(std::uint64_t tag, const AxisVector& position) {
  active_ = false;
  double least = -1;
  for (std::int64_t k = first_; k <= last(); ++k) {
    if (at(k).move.tag != tag) continue;
    const double share = share_of(at(k), position);
    const AxisVector there = point(at(k), share);
    double gap = 0;
    for (std::size_t i = 0; i < machine_.axes.size(); ++i)
      gap += (there[i] - position[i]) * (there[i] - position[i]);
    if (least >= 0 && gap > least) continue;
    least = gap;
    hold_ = {k, share};
  }
  if (least < 0) return false;
  place_ = hold_;
  hold_position_ = position_ = position;
  if (!kernel_) kernel_ = std::make_unique<motion::Kernel>(machine_);
  active_ = true;
  return true;
}

bool Retrace::go(double way_mm, double feed_mm_s) {
  const bool back = way_mm < 0;
  double left = std::abs(way_mm);
  Place place = place_;
  std::deque<motion::Move> way;
  while (left > kNoWay_mm && way.size() < motion::Kernel::kQueueMoves / 2 && retraceable(place.move)) {
    const Executed& executed = at(place.move);
    const double end = back ? 0 : place.move == hold_.move ? hold_.share : 1;
    const double length = std::abs(place.share - end) * executed.length;
    double to = end;
    if (length > left) to = place.share + (end - place.share) * (left / length);
    if (std::abs(to - place.share) * executed.length > kNoWay_mm) {
      motion::Move move = part(executed, place.share, to);
      move.feed = motion::PathFeed{feed_mm_s};
      move.tag = static_cast<std::uint64_t>(place.move) + 1;
      way.push_back(move);
    }
    left -= std::min(left, length);
    place.share = to;
    if (to != end) break;
    if (!back && place.move == hold_.move) break;
    if (back && !retraceable(place.move - 1)) break;
    place = back ? Place{place.move - 1, 1} : Place{place.move + 1, 0};
  }
  if (!back && place.move == hold_.move && place.share == hold_.share) {
    // On a rounded corner the axes were held beside the programmed path: back there exactly.
    if (!way.empty()) {
      std::visit([this](auto& geometry) { geometry.end = hold_position_; }, way.back().geometry);
    } else if (position_ != hold_position_) {
      motion::Move last;
      last.geometry = motion::Line{hold_position_};
      last.feed = motion::PathFeed{feed_mm_s};
      last.tag = static_cast<std::uint64_t>(hold_.move) + 1;
      way.push_back(last);
    }
  }
  if (way.empty()) return false;
  // A corner belongs to both its moves, whichever way it is passed.
  for (std::size_t k = 0; k + 1 < way.size(); ++k)
    way[k].tolerance_mm = std::min(way[k].tolerance_mm, way[k + 1].tolerance_mm);
  kernel_->set_position(position_);
  way.back().exact_stop = true;
  for (const motion::Move& move : way) kernel_->push(move);
  kernel_->finish();
  while (kernel_->plan()) {
  }
  return true;
}

void Retrace::stopped(std::uint64_t tag, const AxisVector& position) {
  position_ = position;
  if (position == hold_position_) {
    place_ = hold_;
    return;
  }
  const auto move = static_cast<std::int64_t>(tag) - 1;
  if (tag == 0 || move < first_ || move > last()) return;
  place_ = {move, share_of(at(move), position)};
}

}  // namespace headstock::operation

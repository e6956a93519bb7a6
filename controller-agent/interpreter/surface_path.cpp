// The last stage of cylindrical and polar interpolation: plane → machine axes, piece by piece.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "interpreter/executor.hpp"
#include "interpreter/surface.hpp"

namespace headstock::interp {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kDegree = std::numbers::pi / 180;
// A piece never turns further: the check in its middle sees every bulge then.
constexpr double kWidestPiece = 0.5;
// Through the pole the rotary axis turns on the spot: no step is short enough for the check there.
constexpr double kShortestStep = 1e-9;

const Motion* moved_by(const Operation& operation) {
  if (const auto* feed = std::get_if<Feed>(&operation)) return feed;
  return std::get_if<Arc>(&operation);
}

}  // namespace

void SurfacePath::begin(const Surface& surface, const Operation& move, const AxisVector& from) {
  surface_ = surface;
  move_ = move;
  from_ = from;
  end_ = moved_by(move_)->end_machine;
  done_ = 0;
  step_ = 1;
  left_ = true;
  here_ = surface_.to_machine(from_, rotary_deg);
  here_[surface_.rotary] = rotary_deg;
  const auto* arc = std::get_if<Arc>(&move_);
  arc_ = arc != nullptr;
  double beside = 0;
  if (arc_) {
    axis_1_ = arc->axis_1;
    axis_2_ = arc->axis_2;
    center_1_ = arc->center_machine[axis_1_];
    center_2_ = arc->center_machine[axis_2_];
    start_angle_ = std::atan2(from_[axis_2_] - center_2_, from_[axis_1_] - center_1_);
    sweep_ = arc->turns * kTwoPi * (arc->turn == Turn::ccw ? 1 : -1);
    radius_0_ = std::hypot(from_[axis_1_] - center_1_, from_[axis_2_] - center_2_);
    radius_1_ = std::hypot(end_[axis_1_] - center_1_, end_[axis_2_] - center_2_);
  }
  for (std::size_t i = 0; i < end_.size(); ++i) {
    const bool in_arc = arc_ && (i == axis_1_ || i == axis_2_);
    if (!in_arc) beside += (end_[i] - from_[i]) * (end_[i] - from_[i]);
  }
  length_ = arc_ ? std::hypot(std::fabs(sweep_) * (radius_0_ + radius_1_) / 2, std::sqrt(beside))
                 : std::sqrt(beside);
}

AxisVector SurfacePath::on_path(double t) const {
  AxisVector point{};
  for (std::size_t i = 0; i < point.size(); ++i) point[i] = from_[i] + t * (end_[i] - from_[i]);
  if (arc_ && t < 1) {  // the end itself is exact
    const double radius = radius_0_ + t * (radius_1_ - radius_0_);
    const double angle = start_angle_ + t * sweep_;
    point[axis_1_] = center_1_ + radius * std::cos(angle);
    point[axis_2_] = center_2_ + radius * std::sin(angle);
  }
  return point;
}

// How far the middle of the straight connection of two machine positions lies from the path between t0 and
// t1.
double SurfacePath::departure(double t0, double t1, const AxisVector& m0, const AxisVector& m1) const {
  AxisVector middle{};
  for (std::size_t i = 0; i < middle.size(); ++i) middle[i] = (m0[i] + m1[i]) / 2;
  middle = surface_.to_plane(middle);
  const AxisVector wanted = on_path((t0 + t1) / 2);
  double off = 0;
  for (std::size_t i = 0; i < middle.size(); ++i) off += (middle[i] - wanted[i]) * (middle[i] - wanted[i]);
  return std::sqrt(off);
}

void SurfacePath::piece(Operation& out) {
  double step = std::min(2 * step_, 1 - done_);
  AxisVector there{};
  for (;; step /= 2) {
    const double to = step >= 1 - done_ ? 1 : done_ + step;
    there = surface_.to_machine(on_path(to), rotary_deg);
    const double turned = surface_.kind == SurfaceKind::polar
                              ? std::fabs(there[surface_.rotary] - here_[surface_.rotary]) * kDegree
                              : 0;
    const double swept = arc_ ? std::fabs(sweep_) * (to - done_) : 0;
    if (step <= kShortestStep || (turned <= kWidestPiece && swept <= kWidestPiece &&
                                  departure(done_, to, here_, there) <= kSurfaceTolerance_mm))
      break;
  }
  const double from = done_;
  done_ = step >= 1 - done_ ? 1 : done_ + step;
  step_ = step;
  left_ = done_ < 1;

  double squares = 0;
  for (std::size_t i = 0; i < there.size(); ++i) squares += (there[i] - here_[i]) * (there[i] - here_[i]);
  const double on_axes = std::sqrt(squares), on_plane = length_ * (done_ - from);
  double feed = 0;
  FeedUnit unit = FeedUnit::mm_per_minute;
  std::uint16_t skip = 0;
  if (const auto* line = std::get_if<Feed>(&move_)) {
    feed = line->feed;
    unit = line->unit;
    skip = line->skip_signals;
  } else {
    feed = std::get<Arc>(move_).feed;
    unit = std::get<Arc>(move_).unit;
  }
  Feed made;
  static_cast<Motion&>(made) = *moved_by(move_);
  made.feed = on_plane > 0 && on_axes > 0 ? feed * on_axes / on_plane : feed;
  made.unit = unit;
  made.skip_signals = skip;
  made.end_machine = there;
  made.axes |= 1u << surface_.rotary;
  if (surface_.kind == SurfaceKind::polar) made.axes |= 1u << surface_.linear;
  made.exact_stop = made.exact_stop && !left_;
  surface_.show(made, there);
  here_ = there;
  rotary_deg = there[surface_.rotary];
  out = made;
}

}  // namespace headstock::interp

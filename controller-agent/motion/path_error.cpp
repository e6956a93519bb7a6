#include "motion/path_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace headstock::motion {

namespace {
constexpr std::size_t kAround = 16;  // moves to either side that can share a blend with the one being traced
}  // namespace

void PathError::start(const AxisVector& position) {
  moves_.clear();
  current_ = 0;
  last_end_ = position;
}

void PathError::add(const Move& move) {
  const AxisVector end = std::visit([](const auto& g) { return g.end; }, move.geometry);
  moves_.push_back({last_end_, end, move});
  last_end_ = end;
}

double PathError::distance_to(const Traced& traced, const AxisVector& position) const {
  auto gap = [&](const AxisVector& p) {
    double sum = 0;
    for (std::size_t i = 0; i < axes_; ++i) {
      const double d = (p[i] - position[i]) * weights_[i];
      sum += d * d;
    }
    return std::sqrt(sum);
  };
  AxisVector p{};
  const Arc* arc = std::get_if<Arc>(&traced.move.geometry);
  if (!arc || arc->angle_rad == 0) {
    double along = 0, square = 0;
    for (std::size_t i = 0; i < axes_; ++i) {
      const double d = (traced.end[i] - traced.start[i]) * weights_[i];
      along += (position[i] - traced.start[i]) * weights_[i] * d;
      square += d * d;
    }
    const double share = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
    for (std::size_t i = 0; i < axes_; ++i)
      p[i] = traced.start[i] + share * (traced.end[i] - traced.start[i]);
    return gap(p);
  }
  // Arc, helix or spiral by share w of the angle; several turns: the nearest in each turn, then refined.
  const std::size_t a = arc->axis_1, b = arc->axis_2;
  const double x = traced.start[a] - arc->center_1, y = traced.start[b] - arc->center_2;
  const double angle_0 = std::atan2(y, x), r0 = std::hypot(x, y);
  const double ex = traced.end[a] - arc->center_1, ey = traced.end[b] - arc->center_2,
               r1 = std::hypot(ex, ey);
  double sweep = arc->angle_rad;
  if (r1 > 1e-7) sweep += std::remainder(std::atan2(ey, ex) - angle_0 - sweep, 2 * M_PI);
  auto at = [&](double w) {
    for (std::size_t i = 0; i < axes_; ++i) p[i] = traced.start[i] + w * (traced.end[i] - traced.start[i]);
    const double angle = angle_0 + w * sweep, r = r0 + w * (r1 - r0);
    p[a] = arc->center_1 + r * std::cos(angle);
    p[b] = arc->center_2 + r * std::sin(angle);
    return gap(p);
  };
  bool pitched = std::abs(r1 - r0) > 1e-9;
  for (std::size_t i = 0; i < axes_; ++i)
    pitched = pitched || (i != a && i != b && traced.start[i] != traced.end[i]);
  double best = std::min(at(0), at(1));
  const double here = std::atan2(position[b] - arc->center_2, position[a] - arc->center_1);
  const double first = std::remainder(here - angle_0, 2 * M_PI) / sweep, turn = std::abs(2 * M_PI / sweep);
  double w = first - turn * std::ceil(first / turn) - turn;
  for (; w <= 1 + turn; w += turn) {
    double low = std::clamp(w - 0.1 * turn, 0.0, 1.0), high = std::clamp(w + 0.1 * turn, 0.0, 1.0);
    if (low >= high) continue;
    double m = std::clamp(w, low, high);
    best = std::min(best, at(m));
    if (!pitched) continue;
    for (int i = 0; i < 40; ++i) {  // ternary search: pitch and spiral move the nearest point a little
      const double m1 = low + (high - low) / 3, m2 = high - (high - low) / 3;
      if (at(m1) < at(m2))
        high = m2;
      else
        low = m1;
    }
    best = std::min(best, at(0.5 * (low + high)));
  }
  return best;
}

double PathError::search(const AxisVector& position, std::uint64_t tag, double enough) {
  if (moves_.empty()) {
    double sum = 0;
    for (std::size_t i = 0; i < axes_; ++i) {
      const double d = (position[i] - last_end_[i]) * weights_[i];
      sum += d * d;
    }
    return std::sqrt(sum);
  }
  for (std::size_t k = current_; k < moves_.size(); ++k) {
    if (moves_[k].move.tag != tag) continue;
    current_ = k;
    break;
  }
  const std::size_t from = current_ > kAround ? current_ - kAround : 0,
                    to = std::min(moves_.size(), current_ + kAround + 1);
  double best = distance_to(moves_[current_], position);
  for (std::size_t k = from; k < to && best > enough; ++k)
    best = std::min(best, distance_to(moves_[k], position));
  if (current_ > 4 * kAround) {
    const std::size_t drop = current_ - kAround;
    moves_.erase(moves_.begin(), moves_.begin() + static_cast<std::ptrdiff_t>(drop));
    current_ -= drop;
  }
  if (!moves_[current_].move.free_path) max_ = std::max(max_, best);
  return best;
}

}  // namespace headstock::motion

#include "motion/smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace headstock::motion {

namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr std::size_t kAhead =
    20;  // moves known before knots are placed: keeps knots independent of when moves come
// Share of the tolerance for a corner with a knot on it (error: turn * d / 6, when the knots beside it are as far
// away on both sides; up to a quarter more when a neighbour's are in the way).
constexpr double kAligned = 0.77 * 6, kAlone = 0.97 * 6;
constexpr double kBesideArc = 0.48 * 6;  // the arc's own knots take a share, too
constexpr double kRun = 0.7;             // share in runs of short segments: knots are not evenly apart there
constexpr double kRunGrowth = 1.3;       // of the distance of knots from one to the next, in a run
constexpr double kArc = 0.35 * 6;        // share of an arc's ends (error: d² / 6 radius)
constexpr double kArcAngle = 0.15;       // rad between knots inside an arc
constexpr double kMostWidth = 50;        // mm
constexpr int kWidthSteps = 6;           // of halving the range a width of a run is searched in
constexpr double kRoomForBoth = 0.95;    // of a line: two knots on it
constexpr double kNearWhole = 0.9;       // of a line: a knot beyond it goes to the middle

// In a run: the largest error that a unit corner makes at distance x when knots are `width` apart, wherever
// it lies between them, is below kHighest width (1 - x / (kReach width))³ (an upper envelope of the spline of
// hat-weighted means).
constexpr double kReach = 2.1, kHighest = 0.2908;

/// Knot distance a piece allows beside it: a short arc is a corner to knots farther apart than its length.
double width_beside(const Piece& piece) {
  if (!piece.curve.is_arc) return kAny;
  const double bend = std::max(std::abs(piece.curve.angle_per_mm), 1e-12), length = piece.curve.length;
  const double own = std::sqrt(kArc * piece.tolerance / bend);
  return own <= length ? own : std::max(length, kBesideArc * piece.tolerance / (bend * length));
}

AxisVector mix(const AxisVector& p, double wp, const AxisVector& q, double wq, double over) {
  AxisVector r;
  const double a = wp / over, b = wq / over;
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = p[i] * a + q[i] * b;
  return r;
}

}  // namespace

/// In parts of the tolerance: a corner's error is that much, of each axis what its own tolerance allows.
double Smoother::tangent_change(const Curve& from, const Curve& to) const {
  AxisVector before = from.tangent(from.length), behind = to.tangent(0);
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    before[i] *= weights_[i];
    behind[i] *= weights_[i];
  }
  return distance(before, behind);
}

void Smoother::reset(double length) {
  nodes_.clear();
  knots_.assign(3, length);
  controls_.clear();
  placing_ = control_piece_ = 0;
  width_before_ = kAny;
  last_interval_ = 0;
}

void Smoother::add(const Piece& piece) {
  if (!nodes_.empty() && !nodes_.back().piece.stop)
    nodes_.back().corner.turn = tangent_change(nodes_.back().piece.curve, piece.curve);
  const bool first = nodes_.empty() && controls_.empty();
  nodes_.push_back({piece, {}});
  if (const Curve& curve = piece.curve; curve.is_arc)  // its own error is in its plane
    nodes_.back().piece.tolerance /= std::max({1.0, weights_[curve.axis_1], weights_[curve.axis_2]});
  if (first) controls_.push_back(piece.curve.start);
}

bool Smoother::stop_at_end() {
  if (nodes_.empty() || nodes_.back().piece.stop) return false;
  nodes_.back().piece.stop = true;
  return true;
}

bool Smoother::known_ahead(std::size_t index) const {
  if (nodes_.size() > index + kAhead) return true;
  for (std::size_t k = index; k < nodes_.size(); ++k)
    if (nodes_[k].piece.stop) return true;
  return false;
}

Smoother::CornersNear Smoother::corners_near(std::size_t index, double reach) const {
  CornersNear near;
  const double at = nodes_[index].piece.end;
  const auto add = [&](std::size_t k, std::size_t away) {
    const Node& node = nodes_[k];
    const double x = std::abs(node.piece.end - at);
    if (x >= reach || node.piece.stop) return false;
    if (away > kWindow || node.piece.curve.is_arc) {
      near.known_to = std::min(near.known_to, x);
      return false;
    }
    near.distance[near.count] = x;
    near.turn[near.count++] = node.corner.turn;
    return true;
  };
  near.distance[near.count] = 0;
  near.turn[near.count++] = nodes_[index].corner.turn;
  for (std::size_t k = index; k > 0 && add(k - 1, index - (k - 1)); --k) {
  }
  for (std::size_t k = index + 1; k < nodes_.size() && add(k, k - index); ++k) {
  }
  return near;
}

double Smoother::CornersNear::error(double width) const {
  const double reach = kReach * width;
  if (known_to < reach) return kAny;
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double r = 1 - distance[i] / reach;
    if (r > 0) sum += turn[i] * (kHighest * width * r * r * r);
  }
  return sum;
}

/// Have its knots and those of both neighbours room beside each other? A neighbour in a run has knots anywhere.
bool Smoother::alone(std::size_t index) const {
  const auto widest = [&](std::size_t k) {
    const Node& node = nodes_[k];
    if (node.piece.stop) return 0.0;
    const double width = kAlone * node.piece.tolerance / std::max(node.corner.turn, 1e-12);
    const double room = std::min(node.piece.curve.length, nodes_[k + 1].piece.curve.length);
    return width <= room ? width : kAny;
  };
  const double before = index > 0 ? widest(index - 1) : 0, behind = widest(index + 1);
  const double most = std::max(before, behind) + widest(index);
  return most <= kRoomForBoth * nodes_[index].piece.curve.length &&
         most <= kRoomForBoth * nodes_[index + 1].piece.curve.length;
}

const Smoother::Corner& Smoother::measured(std::size_t index) {
  Corner& corner = nodes_[index].corner;
  if (corner.measured) return corner;
  corner.measured = true;
  const Piece& piece = nodes_[index].piece;
  if (piece.stop) {
    corner.width = kAny;
    return corner;
  }
  const Piece& following = nodes_[index + 1].piece;
  const bool beside_arc = piece.curve.is_arc || following.curve.is_arc;
  const double room = std::min(piece.curve.length, following.curve.length);
  corner.width = std::min(
      kMostWidth, (beside_arc ? kBesideArc : kAligned) * piece.tolerance / std::max(corner.turn, 1e-12));
  if (beside_arc) corner.width = std::min({corner.width, width_beside(piece), width_beside(following)});
  if (!beside_arc && alone(index)) corner.width *= kAlone / kAligned;
  if (beside_arc || corner.width <= room) return corner;
  // A neighbour is shorter than the blend: do knots at least as far apart as the corners stay inside?
  double least = room,
         most = std::min(corner.width,
                         8 * std::max(room, 0.5 * std::min(corner.width, std::max(piece.curve.length,
                                                                                  following.curve.length))));
  const CornersNear near = corners_near(index, kReach * std::max(least, most));
  if (least < most && near.error(least) <= kRun * piece.tolerance) {
    for (int i = 0; i < kWidthSteps; ++i) {
      const double middle = std::sqrt(least * most);
      (near.error(middle) <= kRun * piece.tolerance ? least : most) = middle;
    }
    corner.width = least;
    corner.run = true;
    return corner;
  }
  // All corners keep their knots; no interval much longer than the short one, or it would pull at the corner
  // beside it.
  corner.width = std::min(corner.width, 2 * room);
  return corner;
}

bool Smoother::place_knots() {
  if (placing_ >= nodes_.size() || !known_ahead(placing_)) return false;
  const double from = knots_.back();
  const Piece& piece = nodes_[placing_].piece;
  if (piece.curve.is_arc) {
    const Corner& corner = measured(placing_);
    emit_arc(piece, width_before_, corner.width);
    width_before_ = corner.width;
  } else {
    const Placed placed = place_in_run(from);
    if (placed == Placed::inside) {
      forget_passed();
      return true;
    }
    if (placed == Placed::nothing) place_line(from, width_before_);
  }
  if (nodes_[placing_].piece.stop) {
    knot(nodes_[placing_].piece.end);
    knot(nodes_[placing_].piece.end);
    controls_.back() = nodes_[placing_].piece.curve.end;
    width_before_ = kAny;
    last_interval_ = 0;
  }
  ++placing_;
  forget_passed();
  return true;
}

void Smoother::place_line(double from, double before) {
  const double end = nodes_[placing_].piece.end, after = measured(placing_).width;
  if (end - from <= std::min(before, after)) {
    last_interval_ = end - from;
    knot(end);
  } else {
    emit_line(from, end, before, after);
  }
  width_before_ = after;
}

Smoother::Placed Smoother::place_in_run(double from) {
  if (!measured(placing_).run && !(from > nodes_[placing_].piece.begin)) return Placed::nothing;
  double most = width_before_;
  if (last_interval_ > 0) most = std::min(most, kRunGrowth * last_interval_);
  // The narrowest of the corners near; the first one ahead that keeps a knot.
  double keeps = kAny;
  std::size_t at = placing_;
  for (; at < nodes_.size() && at - placing_ <= kWindow; ++at) {
    const double way = nodes_[at].piece.end - from;
    if (way > 2 * most) break;
    const Corner& corner = measured(at);
    most = std::min(most, corner.width);
    if (corner.run) continue;
    keeps = way;
    break;
  }
  if (at == placing_ && nodes_[at].piece.end - from > 4 * most) {  // into a long line, out of the run
    place_line(from, most);
    return Placed::at_corner;
  }
  if (keeps < kAny) {
    const double count = std::max(1.0, std::ceil(keeps / most - 1e-9));
    last_interval_ = keeps / count;
    if (count == 1) {
      placing_ = at;
      knot(nodes_[at].piece.end);
      width_before_ = nodes_[at].corner.width;
      return Placed::at_corner;
    }
  } else {
    last_interval_ = most;
  }
  const double to = from + last_interval_;
  knot(to);
  while (nodes_[placing_].piece.end <= to) ++placing_;
  const bool corner_near = placing_ > 0 && to - nodes_[placing_].piece.begin < 2 * last_interval_;
  width_before_ = corner_near ? nodes_[placing_ - 1].corner.width : kAny;
  return Placed::inside;
}

void Smoother::emit_line(double begin, double end, double before, double after) {
  const double length = end - begin;
  const bool near_begin = before < length, near_end = after < length;
  double last = begin;
  if (near_begin && near_end && before + after >= kRoomForBoth * length) {
    last = begin + length * before / (before + after);
    knot(last);
  } else {
    // A knot just before the other end would make a tiny interval, with a third derivative to match; one that
    // falls on it is even a double knot, where the second derivative jumps.
    if (near_begin) knot(last = begin + (before < kNearWhole * length ? before : 0.5 * length));
    if (near_end) knot(last = end - (after < kNearWhole * length ? after : 0.5 * length));
  }
  last_interval_ = end - last;
  knot(end);
}

void Smoother::emit_arc(const Piece& piece, double before, double after) {
  const Curve& curve = piece.curve;
  const double radius =
      std::max(1e-6, std::min(curve.radius, curve.radius + curve.radius_per_mm * curve.length));
  const double per_rad = 1 / std::max(std::abs(curve.angle_per_mm), 1e-12);
  // In the plane the spline turns by angle, whatever the pitch of a helix: error = radius * angle² / 6 at the
  // ends.
  const double angle = std::min(kArcAngle, std::sqrt(kArc * piece.tolerance / radius));
  double interval = angle * per_rad;
  double begin = piece.begin, end = piece.end;
  const bool near_begin = before < interval && before < 0.4 * curve.length;
  const bool near_end = after < interval && after < 0.4 * curve.length;
  if (!near_begin) interval = std::min(interval, before);
  if (!near_end) interval = std::min(interval, after);
  if (near_begin) knot(begin += before);
  if (near_end) end -= after;
  const double count = std::max(1.0, std::ceil((end - begin) / interval - 1e-9));
  for (double i = 1; i < count; ++i) knot(begin + (end - begin) * (i / count));
  last_interval_ = (end - begin) / count;
  if (near_end) {
    knot(end);
    last_interval_ = after;
  }
  knot(piece.end);
}

void Smoother::knot(double t) {
  knots_.push_back(t);
  const std::size_t n = knots_.size();
  controls_.push_back(control(knots_[n - 3], knots_[n - 2], knots_[n - 1]));
}

AxisVector Smoother::control(double t1, double t2, double t3) {
  const double mean = t1 + ((t2 - t1) + (t3 - t1)) / 3;
  while (control_piece_ + 1 < nodes_.size() && nodes_[control_piece_].piece.end < mean) ++control_piece_;
  AxisVector mean_of_run;
  if (mean_in_run(t1, t2, t3, mean_of_run)) return mean_of_run;
  const Piece& piece = nodes_[control_piece_].piece;
  const Curve& curve = piece.curve;
  double outward = 1;
  if (curve.is_arc) {
    const double h1 = t2 - t1, h2 = t3 - t2, slack = 1e-6 * (t3 - t1);
    if (t1 >= piece.begin - slack && t3 <= piece.end + slack && std::abs(h1 - h2) < slack)
      outward = 3 / (2 + std::cos(h1 * curve.angle_per_mm));  // (1 + 4 + 1)/6 of such points lies on the arc
  }
  return curve.point(std::clamp(mean - piece.begin, 0.0, curve.length), outward);
}

bool Smoother::mean_in_run(double t1, double t2, double t3, AxisVector& mean) const {
  if (!(t1 < t2 && t2 < t3)) return false;
  std::size_t first = control_piece_, last = control_piece_;
  while (first > 0 && nodes_[first].piece.begin > t1) --first;
  while (last + 1 < nodes_.size() && nodes_[last].piece.end < t3) ++last;
  if (first == last || nodes_[first].piece.begin > t1 || nodes_[last].piece.end < t3) return false;
  for (std::size_t k = first; k < last; ++k)
    if (!nodes_[k].corner.run) return false;
  // Straight piece times straight side of the hat: Simpson's rule is exact.
  mean = AxisVector{};
  const auto weigh = [&](const Piece& piece, double from, double to) {
    if (!(from < to)) return;
    const double share = (to - from) / (3 * (t3 - t1)), middle = 0.5 * (from + to);
    for (const auto& [t, times] : {std::pair{from, 1.0}, {middle, 4.0}, {to, 1.0}}) {
      const double weight = share * times * (t < t2 ? (t - t1) / (t2 - t1) : (t3 - t) / (t3 - t2));
      const double u = t - piece.begin;
      for (std::size_t i = 0; i < axes_; ++i)
        mean[i] += weight * (piece.curve.start[i] + piece.curve.direction[i] * u);
    }
  };
  for (std::size_t k = first; k <= last; ++k) {
    const Piece& piece = nodes_[k].piece;
    const double from = std::max(t1, piece.begin), to = std::min(t3, piece.end);
    weigh(piece, from, std::min(to, t2));
    weigh(piece, std::max(from, t2), to);
  }
  return true;
}

void Smoother::forget_passed() {
  const std::size_t needed = std::min(placing_, control_piece_);
  if (needed < 6 * kWindow) return;
  const std::size_t drop = needed - 3 * kWindow;
  nodes_.erase(nodes_.begin(), nodes_.begin() + static_cast<std::ptrdiff_t>(drop));
  placing_ -= drop;
  control_piece_ -= drop;
}

bool Smoother::next(Span& out) {
  for (;;) {
    while (knots_.size() < 6)
      if (!place_knots()) return false;
    if (knots_[2] < knots_[3]) break;
    knots_.pop_front();
    controls_.pop_front();
  }
  const double a = knots_[0], b = knots_[1], c = knots_[2], d = knots_[3], e = knots_[4], f = knots_[5];
  const double h = d - c;
  // Bézier points by blossoming: bcc is the blossom at (b, c, c), and so on.
  const AxisVector ccd = mix(controls_[1], e - c, controls_[2], c - b, e - b);
  const AxisVector cdd = mix(controls_[1], e - d, controls_[2], d - b, e - b);
  const AxisVector bcc = mix(controls_[0], d - c, controls_[1], c - a, d - a);
  const AxisVector ccc = mix(bcc, d - c, ccd, c - b, d - b);
  const AxisVector dde = mix(controls_[2], f - d, controls_[3], d - c, f - c);
  const AxisVector ddd = mix(cdd, e - d, dde, d - c, e - c);
  out.begin = c;
  out.end = d;
  out.stop = e == d && f == d;
  if (out.stop) out.stop_point = ddd;
  double bend = 0;
  for (std::size_t i = 0; i < axes_; ++i) {
    const double second_0 = ccc[i] - 2 * ccd[i] + cdd[i], second_1 = ccd[i] - 2 * cdd[i] + ddd[i];
    bend = std::max({bend, std::abs(second_0), std::abs(second_1)});
    out.c[0][i] = ccc[i];
    out.c[1][i] = 3 * (ccd[i] - ccc[i]) / h;
    out.c[2][i] = 3 * second_0 / (h * h);
    out.c[3][i] = (second_1 - second_0) / (h * h * h);
  }
  // Below the rounding of the numbers themselves it is a straight line; say so, or noise would look like
  // curvature.
  double magnitude = 1;
  for (std::size_t i = 0; i < axes_; ++i) magnitude = std::max(magnitude, std::abs(ccc[i]));
  out.straight = bend < 32 * std::numeric_limits<double>::epsilon() * magnitude;
  if (out.straight) {
    for (std::size_t i = 0; i < axes_; ++i) out.c[1][i] = (ddd[i] - ccc[i]) / h;
    out.c[2] = out.c[3] = AxisVector{};
  }
  knots_.pop_front();
  controls_.pop_front();
  return true;
}

}  // namespace headstock::motion

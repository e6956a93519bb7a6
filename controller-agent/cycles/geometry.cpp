#include "cycles/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headstock::cycles {
namespace {

constexpr double kFull = 2 * std::numbers::pi;

double start_angle(const Segment& s) {
  return std::atan2(s.from.v - s.center.v, s.from.u - s.center.u);
}

// Fraction of an arc's sweep at which it passes an absolute angle; > 1 when it does not.
double fraction_at(const Segment& s, double angle) {
  double turn = s.sweep > 0 ? angle - start_angle(s) : start_angle(s) - angle;
  turn = std::fmod(turn, kFull);
  if (turn < 0) turn += kFull;
  return turn / std::fabs(s.sweep);
}

// Values of u or v at the ends and at the arc's turning points.
std::array<double, 2> range(const Segment& s, bool of_u) {
  const auto value = [of_u](Point p) { return of_u ? p.u : p.v; };
  double low = std::min(value(s.from), value(s.to));
  double high = std::max(value(s.from), value(s.to));
  if (!s.arc) return {low, high};
  const double r = radius_of(s);
  const double middle = value(s.center);
  const double high_angle = of_u ? 0 : kFull / 4;
  if (fraction_at(s, high_angle) < 1) high = std::max(high, middle + r);
  if (fraction_at(s, high_angle + kFull / 2) < 1) low = std::min(low, middle - r);
  return {low, high};
}

double against(const Segment& s, double sign, bool of_u) {
  const auto value = [&](Point p) { return sign * (of_u ? p.u : p.v); };
  if (!s.arc) return std::max(0.0, value(s.from) - value(s.to));
  // Between turning points an arc is monotonic: the worst step back of the running maximum.
  std::vector<double> stops{1};
  for (int quarter = 0; quarter < 4; ++quarter) {
    const double t = fraction_at(s, quarter * kFull / 4);
    if (t > 0 && t < 1) stops.push_back(t);
  }
  std::sort(stops.begin(), stops.end());
  double best = value(s.from), back = 0;
  for (const double stop : stops) {
    const double here = value(at(s, stop));
    back = std::max(back, best - here);
    best = std::max(best, here);
  }
  return back;
}

}  // namespace

double radius_of(const Segment& s) {
  return std::hypot(s.from.u - s.center.u, s.from.v - s.center.v);
}

Point at(const Segment& s, double t) {
  if (t <= 0) return s.from;
  if (t >= 1) return s.to;
  if (!s.arc) return {s.from.u + (s.to.u - s.from.u) * t, s.from.v + (s.to.v - s.from.v) * t};
  const double angle = start_angle(s) + s.sweep * t;
  const double r = radius_of(s);
  return {s.center.u + r * std::cos(angle), s.center.v + r * std::sin(angle)};
}

Segment piece(const Segment& s, double from, double to) {
  Segment part = s;
  part.from = at(s, from);
  part.to = at(s, to);
  part.sweep = s.sweep * (std::min(to, 1.0) - std::max(from, 0.0));
  if (to < 1) part.dwell_s = 0;
  return part;
}

std::size_t crossings(const Segment& s, double level, std::array<double, 2>& t) {
  std::size_t count = 0;
  const auto keep = [&](double fraction) {
    if (fraction > 0 && fraction < 1) t[count++] = fraction;
  };
  if (!s.arc) {
    if (s.from.v != s.to.v) keep((level - s.from.v) / (s.to.v - s.from.v));
    return count;
  }
  const double sine = (level - s.center.v) / radius_of(s);
  if (!(std::fabs(sine) < 1)) return 0;  // apart, or touching: no change of side
  const double angle = std::asin(sine);
  keep(fraction_at(s, angle));
  keep(fraction_at(s, kFull / 2 - angle));
  if (count == 2 && t[0] > t[1]) std::swap(t[0], t[1]);
  return count;
}

std::array<double, 2> range_u(const Segment& s) {
  return range(s, true);
}
std::array<double, 2> range_v(const Segment& s) {
  return range(s, false);
}
double against_u(const Segment& s, double sign) {
  return against(s, sign, true);
}
double against_v(const Segment& s, double sign) {
  return against(s, sign, false);
}

Segment View::to(const Segment& s) const {
  Segment seen = s;
  seen.from = to(s.from);
  seen.to = to(s.to);
  seen.center = to(s.center);
  if (mirrors()) seen.sweep = -s.sweep;
  return seen;
}

Segment View::back(const Segment& s) const {
  Segment seen = s;
  seen.from = back(s.from);
  seen.to = back(s.to);
  seen.center = back(s.center);
  if (mirrors()) seen.sweep = -s.sweep;
  return seen;
}

Path shifted(const Path& path, Point by) {
  Path moved = path;
  for (Segment& s : moved) {
    for (Point* p : {&s.from, &s.to, &s.center}) *p = {p->u + by.u, p->v + by.v};
  }
  return moved;
}

std::vector<Stretch> not_above(const Path& path, double level, Stretch within) {
  std::vector<Stretch> free;
  const auto add = [&free](double from, double to) {
    if (!free.empty() && free.back().to >= from - 1e-12) {
      free.back().to = to;
    } else {
      free.push_back({from, to});
    }
  };
  const auto last = static_cast<std::size_t>(std::ceil(within.to));
  for (auto i = static_cast<std::size_t>(within.from); i < last && i < path.size(); ++i) {
    const Segment& s = path[i];
    const double base = static_cast<double>(i);
    const double low = std::max(0.0, within.from - base);
    const double high = std::min(1.0, within.to - base);
    if (high <= low) continue;
    std::array<double, 2> t{};
    const std::size_t count = crossings(s, level, t);
    double from = low;
    for (std::size_t c = 0; c <= count; ++c) {
      const double to = c < count ? std::clamp(t[c], low, high) : high;
      if (to <= from) continue;
      if (at(s, (from + to) / 2).v <= level + kTiny) add(base + from, base + to);
      from = to;
    }
  }
  return free;
}

Point point_at(const Path& path, double place) {
  if (path.empty()) return {};
  const auto index = std::min(static_cast<std::size_t>(place), path.size() - 1);
  return at(path[index], place - static_cast<double>(index));
}

Path cut_out(const Path& path, Stretch stretch) {
  Path part;
  for (auto i = static_cast<std::size_t>(stretch.from); i < path.size(); ++i) {
    const double base = static_cast<double>(i);
    if (base >= stretch.to) break;
    const double low = std::max(0.0, stretch.from - base);
    const double high = std::min(1.0, stretch.to - base);
    if (high > low) part.push_back(piece(path[i], low, high));
  }
  return part;
}

}  // namespace headstock::cycles

#include "axes/travel_limits.hpp"

#include <algorithm>
#include <numbers>

#include "axes/arc_path.hpp"

namespace headstock::axes {
namespace {

constexpr double kPi = std::numbers::pi;
// Positions are sums of decimal numbers; what differs by less than this is the same position.
constexpr double kSamePosition_mm = 1e-9;

bool passes(double from, double to, double limit, bool positive) {
  const double sign = positive ? 1 : -1;
  return (to - limit) * sign > kSamePosition_mm && (to - from) * sign > 0;
}

double stop_coordinate(double limit, bool positive) {
  return positive ? limit - kStopBeforeLimit_mm : limit + kStopBeforeLimit_mm;
}

// The stretches of an arc's angle on which both plane axes run one way only. Turning points of c +
// r(φ)·cos(θ+φ) with r linear in φ lie where tan(angle) = r'/r, a quarter turn apart up to the slow change of
// r.
class MonotoneStretches {
 public:
  explicit MonotoneStretches(const ArcPath& path) : path_(path), sign_(path.sweep() < 0 ? -1 : 1) {
    slope_ = path.sweep() == 0 ? 0 : (path.end_radius() - path.start_radius()) / path.sweep();
    quarter_ = std::floor(sign_ * path.start_angle() / (kPi / 2)) - 1;
  }
  /// Next end of a stretch after `turned`; the whole sweep when there is no turning point before it.
  double next(double turned) {
    while (true) {
      const double angle = sign_ * quarter_ * (kPi / 2);
      double candidate = angle - path_.start_angle();
      for (int i = 0; i < 3; ++i) {
        const double radius = path_.start_radius() + slope_ * candidate;
        if (radius > 0) candidate = angle - path_.start_angle() + std::atan(slope_ / radius);
      }
      quarter_ += 1;
      if (sign_ * (candidate - turned) <= 1e-12) continue;
      return sign_ * candidate < sign_ * path_.sweep() ? candidate : path_.sweep();
    }
  }

 private:
  const ArcPath& path_;
  double sign_, slope_ = 0, quarter_ = 0;
};

std::optional<Overtravel> line_overtravel(const machine::Machine& machine, const AxisVector& start,
                                          const motion::Line& line) {
  std::optional<Overtravel> first;
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    for (const bool positive : {false, true}) {
      const double limit = positive ? machine.axes[i].max_mm : machine.axes[i].min_mm;
      if (!passes(start[i], line.end[i], limit, positive)) continue;
      const double fraction =
          std::clamp((stop_coordinate(limit, positive) - start[i]) / (line.end[i] - start[i]), 0.0, 1.0);
      if (!first || fraction < first->fraction) first = Overtravel{i, positive, fraction, motion::Line{}};
    }
  }
  if (first) {
    motion::Line allowed;
    for (std::size_t i = 0; i < allowed.end.size(); ++i)
      allowed.end[i] = start[i] + (line.end[i] - start[i]) * first->fraction;
    first->allowed = allowed;
  }
  return first;
}

double find_crossing(const ArcPath& path, std::size_t axis, double coordinate, double from, double to) {
  // Monotone between `from` and `to`: halving finds the last angle that is still inside.
  const bool rising = path.at(axis, to) > path.at(axis, from);
  for (int i = 0; i < 64; ++i) {
    const double middle = (from + to) / 2;
    const bool beyond = rising ? path.at(axis, middle) > coordinate : path.at(axis, middle) < coordinate;
    (beyond ? to : from) = middle;
  }
  return from;
}

std::optional<Overtravel> arc_overtravel(const machine::Machine& machine, const AxisVector& start,
                                         const motion::Arc& arc) {
  const ArcPath path(start, arc);
  MonotoneStretches stretches(path);
  for (double from = 0; from != path.sweep();) {
    const double to = stretches.next(from);
    std::optional<Overtravel> first;
    double first_angle = to;
    for (std::size_t i = 0; i < machine.axes.size(); ++i) {
      for (const bool positive : {false, true}) {
        const double limit = positive ? machine.axes[i].max_mm : machine.axes[i].min_mm;
        const double begin = path.at(i, from);
        if (!passes(begin, path.at(i, to), limit, positive)) continue;
        const double stop = stop_coordinate(limit, positive);
        const bool already_there = positive ? begin >= stop : begin <= stop;
        const double angle = already_there ? from : find_crossing(path, i, stop, from, to);
        if (!first || std::abs(angle) < std::abs(first_angle)) {
          first = Overtravel{i, positive, angle / path.sweep(), motion::Line{}};
          first_angle = angle;
        }
      }
    }
    if (first) {
      motion::Arc allowed = arc;
      allowed.angle_rad = first_angle;
      allowed.end = path.position(first_angle);
      first->allowed = allowed;
      return first;
    }
    from = to;
  }
  return std::nullopt;
}

bool near(const machine::Machine& machine, const AxisVector& point, double distance_mm) {
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const double distance = machine.allowance(i, distance_mm);
    if (point[i] > machine.axes[i].max_mm - distance || point[i] < machine.axes[i].min_mm + distance) return true;
  }
  return false;
}

}  // namespace

std::optional<Overtravel> find_overtravel(const machine::Machine& machine, const AxisVector& start,
                                          const std::variant<motion::Line, motion::Arc>& geometry) {
  if (const auto* line = std::get_if<motion::Line>(&geometry)) return line_overtravel(machine, start, *line);
  return arc_overtravel(machine, start, std::get<motion::Arc>(geometry));
}

bool near_limit(const machine::Machine& machine, const AxisVector& start,
                const std::variant<motion::Line, motion::Arc>& geometry, double distance_mm) {
  if (const auto* line = std::get_if<motion::Line>(&geometry)) return near(machine, line->end, distance_mm);
  const ArcPath path(start, std::get<motion::Arc>(geometry));
  MonotoneStretches stretches(path);
  for (double from = 0; from != path.sweep();) {
    from = stretches.next(from);
    if (near(machine, path.position(from), distance_mm)) return true;
  }
  return false;
}

}  // namespace headstock::axes

#include "axes/forbidden_zone.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "axes/arc_path.hpp"

namespace headstock::axes {
namespace {

constexpr double kChord_rad = std::numbers::pi / 180;
constexpr double kArcMargin_mm = 0.01;
// Standing on the border is outside a forbidden box and inside a permitted one.
constexpr double kOnBorder_mm = 1e-9;

bool limited(const Zone& zone, std::size_t axis) {
  return (zone.axes >> axis & 1u) != 0;
}

/// Strictly inside the box, drawn `in` tighter.
bool inside(const Zone& zone, const AxisVector& p, double in) {
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (!limited(zone, i)) continue;
    if (p[i] <= zone.least[i] + in || p[i] >= zone.most[i] - in) return false;
  }
  return zone.axes != 0;
}

/// Share of the line at which it is in the box, drawn `in` tighter: from `first` to `second`, empty when not
/// less.
struct Stay {
  double first = 0, second = 1;
  std::size_t axis = 0;
};
Stay stay_inside(const Zone& zone, const AxisVector& a, const AxisVector& b, double in) {
  Stay stay;
  bool named = false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!limited(zone, i)) continue;
    if (!std::exchange(named, true)) stay.axis = i;
    const double low = zone.least[i] + in, high = zone.most[i] - in, way = b[i] - a[i];
    if (way == 0) {
      if (a[i] <= low || a[i] >= high) stay.second = -1;
      continue;
    }
    const double t1 = (low - a[i]) / way, t2 = (high - a[i]) / way;
    if (std::min(t1, t2) > stay.first) {
      stay.first = std::min(t1, t2);
      stay.axis = i;
    }
    stay.second = std::min(stay.second, std::max(t1, t2));
  }
  return stay;
}

std::optional<Entry> enters(const Zone& zone, const AxisVector& a, const AxisVector& b, double margin) {
  if (!zone.outside_forbidden) {
    if (inside(zone, a, kOnBorder_mm - margin) && !inside(zone, b, kOnBorder_mm - margin))
      return std::nullopt;
    const Stay stay = stay_inside(zone, a, b, kOnBorder_mm - margin);
    if (stay.first >= stay.second) return std::nullopt;
    return Entry{stay.axis, b[stay.axis] > a[stay.axis]};
  }
  // A box is convex: who ends inside never left it.
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!limited(zone, i)) continue;
    const double low = zone.least[i] + margin - kOnBorder_mm, high = zone.most[i] - margin + kOnBorder_mm;
    if (b[i] > high && b[i] > a[i]) return Entry{i, true};
    if (b[i] < low && b[i] < a[i]) return Entry{i, false};
  }
  return std::nullopt;
}

bool near(const Zone& zone, const AxisVector& a, const AxisVector& b, const AxisVector& distance,
          double margin) {
  if (!zone.outside_forbidden) {
    Zone wider = zone;
    for (std::size_t i = 0; i < a.size(); ++i) {
      wider.least[i] -= distance[i];
      wider.most[i] += distance[i];
    }
    const Stay stay = stay_inside(wider, a, b, kOnBorder_mm - margin);
    return zone.axes != 0 && stay.first < stay.second;
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!limited(zone, i)) continue;
    const double free = distance[i] + margin - kOnBorder_mm;
    if (std::min(a[i], b[i]) < zone.least[i] + free || std::max(a[i], b[i]) > zone.most[i] - free)
      return true;
  }
  return false;
}

/// The move as one chord or, of an arc, several: found(from, to, margin) of each until one gives something.
/// The arc is within the margin of its chord.
template <class Found>
auto along_chords(const AxisVector& start, const std::variant<motion::Line, motion::Arc>& geometry,
                  Found found) {
  if (const auto* line = std::get_if<motion::Line>(&geometry)) return found(start, line->end, 0.0);
  const auto& arc = std::get<motion::Arc>(geometry);
  const ArcPath path(start, arc);
  const double chords = std::max(1.0, std::ceil(std::abs(arc.angle_rad) / kChord_rad));
  // A chord of 1° stays this much inside its arc.
  const double margin =
      kArcMargin_mm + std::max(path.start_radius(), path.end_radius()) * kChord_rad * kChord_rad / 8;
  AxisVector from = start;
  for (double k = 1; k < chords; ++k) {
    const AxisVector to = path.position(arc.angle_rad * k / chords);
    if (const auto entry = found(from, to, margin)) return entry;
    from = to;
  }
  return found(from, arc.end, margin);
}

}  // namespace

std::optional<Entry> find_entry(const Zone& zone, const AxisVector& start,
                                const std::variant<motion::Line, motion::Arc>& geometry) {
  return along_chords(start, geometry, [&](const AxisVector& from, const AxisVector& to, double margin) {
    return enters(zone, from, to, margin);
  });
}

bool comes_near(const Zone& zone, const AxisVector& start,
                const std::variant<motion::Line, motion::Arc>& geometry, const AxisVector& distance) {
  return along_chords(start, geometry, [&](const AxisVector& from, const AxisVector& to, double margin) {
    return near(zone, from, to, distance, margin);
  });
}

}  // namespace headstock::axes

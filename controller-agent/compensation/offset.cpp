#include "compensation/offset.hpp"

#include <algorithm>
#include <iterator>
#include <numbers>

namespace headstock::comp {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kStraightOn = 1e-7;  // sine
const double kDegreeSine = std::sin(kDegree);
const double kNearlyTangent =
    std::sin(2 * kDegree);  // end points are rounded: offset paths may just miss each other
constexpr double kAgainst_mm = 1e-6;
constexpr double kLonger_mm = 0.01;

// From the end of one block to the start of the other. Angles are never needed, only their sines and cosines.
struct Turn {
  Point before, after;  // unit vectors
  Point n1, n2;         // vectors normal to them, on the tool's side
  double sine, cosine;  // of the turn, + to the left
  bool inside;          // on the tool's side

  bool straight() const { return cosine > 0 && std::fabs(sine) < kStraightOn; }
  bool nearly_straight() const { return cosine > 0 && std::fabs(sine) < kNearlyTangent; }
  // Back on itself: more than 359 degrees (inside) or less than 1 (outside) on the workpiece side.
  bool back() const { return cosine < 0 && std::fabs(sine) < kDegreeSine; }
  // Outside: 90 degrees or more on the workpiece side.
  bool obtuse() const { return cosine >= -1e-9; }
};

Turn turn_of(Point before, Point after, double r) {
  Turn turn{};
  turn.before = before;
  turn.after = after;
  turn.n1 = left_of(turn.before) * r;
  turn.n2 = left_of(turn.after) * r;
  turn.sine = cross(turn.before, turn.after);
  turn.cosine = dot(turn.before, turn.after);
  const bool left = !std::signbit(turn.sine);
  turn.inside = (turn.sine == 0 && turn.cosine > 0) || left == (r > 0);
  return turn;
}

Turn turn_between(const Segment& a, const Segment& b, double r) {
  return turn_of(a.direction_at_end(), b.direction_at_start(), r);
}

// Around the corner on a circle.
Vectors around(Point n1, Point n2, const Turn& turn) {
  Vectors v;
  v.add(n1);
  v.add(n2);
  v.circular = true;
  v.turn = turn.sine > 0 ? 1 : -1;
  return v;
}

// Where the two lines beside the corner cross, as a vector from the corner.
Point crossing(Point n1, Point n2, double r) {
  return (n1 + n2) * (r * r / (r * r + dot(n1, n2)));
}

// An inside corner: the crossing of the offset paths that is nearest to the corner.
bool inside_vector(const Segment& a, const Segment& b, double r, Point& out) {
  const Crossings at = intersect(offset_curve(a, r, true), offset_curve(b, r, false));
  if (at.count == 0) return false;
  out = at.point[0] - a.to;
  if (at.count == 2) {
    const Point other = at.point[1] - a.to;
    if (length(other) < length(out)) out = other;
  }
  return true;
}

}  // namespace

Point normal_at_end(const Segment& segment, double r) {
  return left_of(segment.direction_at_end()) * r;
}
Point normal_at_start(const Segment& segment, double r) {
  return left_of(segment.direction_at_start()) * r;
}

Vectors corner(const Segment& a, const Segment& b, double r, const OffsetRules& rules) {
  return corner(a, a.direction_at_end(), b, b.direction_at_start(), r, rules);
}

Vectors corner(const Segment& a, const Point& a_end, const Segment& b, const Point& b_start, double r,
               const OffsetRules& rules) {
  const Turn turn = turn_of(a_end, b_start, r);
  const Point n1 = turn.n1, n2 = turn.n2;
  if (turn.straight()) return single(n1);
  Vectors v;
  if (turn.inside) {
    if (turn.back()) {  // back on itself: no search for a crossing
      v.add(n1);
      v.add(n2);
      return v;
    }
    Point at;
    if (!a.arc && !b.arc) {
      v.add(crossing(n1, n2, r));
    } else if (inside_vector(a, b, r, at)) {
      v.add(at);
    } else if (turn.nearly_straight()) {
      v.add(n1);
    }
    return v;
  }
  if (rules.circular_outside) return around(n1, n2, turn);
  const double size = std::fabs(r);
  if (a.arc) v.add(n1);
  if (turn.obtuse()) {
    v.add(crossing(n1, n2, r));
  } else {
    v.add(n1 + turn.before * size);
    v.add(n2 - turn.after * size);
  }
  if (b.arc) v.add(n2);
  return v;
}

Vectors start_up(const Segment& a, const Segment& b, double r, const OffsetRules& rules) {
  const Turn turn = turn_between(a, b, r);
  const Point n1 = turn.n1, n2 = turn.n2;
  if (rules.start == StartType::a || turn.inside || turn.back()) return single(n2);
  const double size = std::fabs(r);
  Vectors v;
  if (rules.circular_outside) return around(n1, n2, turn);
  if (turn.obtuse()) {
    if (rules.start_by_normal) v.add(n1);
    v.add(crossing(n1, n2, r));
  } else {
    v.add(n1);
    v.add(n1 + turn.before * size);
    v.add(n2 - turn.after * size);
  }
  if (b.arc) v.add(n2);
  return v;
}

Vectors cancel(const Segment& a, const Segment& b, double r, const OffsetRules& rules) {
  // The way back of a start-up: mirrored in time, the side changes.
  const auto back = [](const Segment& s) {
    Segment reversed = s;
    reversed.from = s.to;
    reversed.to = s.from;
    reversed.turn = -s.turn;
    return reversed;
  };
  const Vectors way = start_up(back(b), back(a), -r, rules);
  Vectors v;
  for (std::size_t i = way.count; i-- > 0;) v.add(way.at[i]);
  v.circular = way.circular;
  v.turn = -way.turn;
  return v;
}

Vectors change_side(const Segment& a, double r_a, const Segment& b, double r_b) {
  const Point n1 = normal_at_end(a, r_a), n2 = normal_at_start(b, r_b);
  const Crossings at = intersect(offset_curve(a, r_a, true), offset_curve(b, r_b, false));
  // A crossing counts when both blocks reach it (a line may run on by r).
  const double reach = 2 * std::fabs(r_a);
  const Point* best = nullptr;
  for (int i = 0; i < at.count; ++i) {
    const Point vector = at.point[static_cast<std::size_t>(i)] - a.to;
    if (length(vector) > reach) continue;
    if (best == nullptr || length(vector) < length(*best - a.to))
      best = &at.point[static_cast<std::size_t>(i)];
  }
  if (best != nullptr) return single(*best - a.to);
  Vectors v;
  v.add(n1);
  v.add(n2);
  return v;
}

bool is_groove(const Segment& a, const Segment& b, const Segment& c, double r) {
  return !b.arc && turn_between(a, b, r).inside && turn_between(b, c, r).inside;
}

Point normal_of(Point direction, double r) {
  const double size = length(direction);
  return size > 0 ? left_of(direction * (1 / size)) * r : Point{};
}

Vectors cancel_at_wall(const Segment& a, Point direction, double r) {
  const Segment wall = line(a.to, a.to + direction);
  const Turn turn = turn_between(a, wall, r);
  Point at;
  // On a straight line the two paths are one; where the wall leads straight back there is no crossing.
  const bool meets = !turn.straight() && !turn.back() && inside_vector(a, wall, r, at);
  return single(meets ? at : normal_at_end(a, r));
}

Vectors corner_arc(const Segment& a, Point after, double r) {
  const Point before = a.direction_at_end();
  Vectors v;
  v.add(normal_at_end(a, r));
  v.add(left_of(after) * r);
  v.circular = true;
  v.turn = cross(before, after) > 0 ? 1 : -1;
  return v;
}

Between check(const Segment& block, Point start, Point end) {
  const Point s = block.from + start, e = block.to + end;
  if (!block.arc) {
    const Point way = block.to - block.from;
    const double along = dot(e - s, way);
    return along < 0 && along < -kAgainst_mm * length(way) ? Between::reversed : Between::good;
  }
  if (length(e - s) < kAgainst_mm && block.sweep < std::numbers::pi) return Between::good;
  double sweep = swept(s, e, block.center, block.turn);
  if (sweep < 1e-9 && block.sweep > std::numbers::pi) sweep = 2 * std::numbers::pi;
  if (std::fabs(sweep - block.sweep) > std::numbers::pi) return Between::reversed;
  // Corners only ever shorten an arc. One that became longer by more than rounding runs into its neighbours:
  // the controllers' half-turn rule alone would let small inside arcs do that.
  const double longer_mm = (sweep - block.sweep) * length(s - block.center);
  return longer_mm > kLonger_mm ? Between::reversed : Between::good;
}

bool clears(const Segment& block, Point from, Point to, double r) {
  constexpr int kParts = 16;
  constexpr double kRounded_mm = 0.001;  // end points and centres are rounded
  const Point way = to - from;
  const double whole = dot(way, way);
  for (int i = 0; i <= kParts; ++i) {
    const double part = static_cast<double>(i) / kParts;
    Point at = block.from + (block.to - block.from) * part;
    if (block.arc) {
      const Point arm = block.from - block.center;
      const double by = block.turn * block.sweep * part;
      at = block.center +
           Point{arm.u * std::cos(by) - arm.v * std::sin(by), arm.u * std::sin(by) + arm.v * std::cos(by)};
    }
    const double near = whole > 0 ? std::fmax(0.0, std::fmin(1.0, dot(at - from, way) / whole)) : 0;
    if (length(from + way * near - at) < r - kRounded_mm) return false;
  }
  return true;
}

Between settle(const Segment& block, const Neighbours& beside, Vectors& start, Vectors& end, double r,
               bool& straight) {
  straight = false;
  if (check(block, start.last(), end.first()) == Between::good) return Between::good;
  Vectors s = start, e = end;
  while (s.count > 1 || e.count > 1) {
    if (s.count > 1) --s.count;
    if (e.count > 1) {
      for (std::size_t i = 1; i < e.count; ++i) e.at[i - 1] = e.at[i];
      --e.count;
    }
    const Segment way = line(block.from, block.to);
    if (check(block.arc ? way : block, s.last(), e.first()) != Between::good) continue;
    const Point from = block.from + s.last(), to = block.to + e.first();
    const bool clear =
        std::all_of(std::begin(beside.all), std::end(beside.all), [&](const Segment* neighbour) {
          return neighbour == nullptr || clears(*neighbour, from, to, std::fabs(r));
        });
    if (!clear || !clears(block, from, to, std::fabs(r))) continue;
    s.circular = s.circular && s.count > 1;
    e.circular = false;
    start = s;
    end = e;
    straight = block.arc;
    return Between::good;
  }
  return Between::reversed;
}

void merge_near(Vectors& vectors, double limit) {
  if (vectors.circular || vectors.bare >= 0) return;
  std::size_t kept = 1;
  for (std::size_t i = 1; i < vectors.count; ++i) {
    const Point d = vectors.at[i] - vectors.at[kept - 1];
    if (std::fabs(d.u) > limit || std::fabs(d.v) > limit) vectors.at[kept++] = vectors.at[i];
  }
  if (vectors.count > 0) vectors.count = kept;
}

}  // namespace headstock::comp

#include "cycles/roughing.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::cycles {

Move along(const Segment& s) {
  Move move = move_both(s.arc ? MoveKind::arc : MoveKind::feed, s.to);
  move.center = s.center;
  move.sweep = s.sweep;
  return move;
}

Move back(const View& view, Move seen) {
  if (view.swapped) std::swap(seen.along_u, seen.along_v);
  seen.to = view.back(seen.to);
  seen.center = view.back(seen.center);
  if (view.mirrors()) seen.sweep = -seen.sweep;
  return seen;
}

View view_of(const Roughing& job) {
  View view{.swapped = job.facing};
  if (job.profile.empty()) return view;
  const Point a = view.to(job.start);
  const Point first = view.to(job.profile.front().from);
  const Point last = view.to(job.profile.back().to);
  // Material lies between the start and A'; when the tool already stands at that level, the profile rises
  // toward it.
  const double depth = std::fabs(a.v - first.v) > kTiny ? a.v - first.v : last.v - first.v;
  if (depth < 0) view.sign_v = -1;
  if (last.u < first.u) view.sign_u = -1;
  return view;
}

namespace {

// The nearest u at which any part of the profile stands above the level.
double end_of_cut(const Path& profile, double level, double start_u) {
  double nearest = HUGE_VAL;
  for (const Segment& s : profile) {
    if (range_v(s)[1] <= level + kTiny) continue;
    std::array<double, 2> t{};
    const std::size_t count = crossings(s, level, t);
    double from = 0;
    for (std::size_t c = 0; c <= count; ++c) {
      const double to = c < count ? t[c] : 1;
      if (to > from && at(s, (from + to) / 2).v > level + kTiny) {
        nearest = std::min(nearest, range_u(piece(s, from, to))[0]);
      }
      from = to;
    }
  }
  if (nearest == HUGE_VAL) nearest = profile.back().to.u;  // above the whole profile: as long as it is
  return std::max(nearest, start_u);
}

Path seen_profile(const Roughing& job, const View& view) {
  Path profile;
  profile.reserve(job.profile.size());
  for (const Segment& s : job.profile) profile.push_back(view.to(s));
  return shifted(profile, view.to(job.allowance));
}

Point plus(Point a, Point b) {
  return {a.u + b.u, a.v + b.v};
}

}  // namespace

double above_start(const Roughing& job) {
  const View view = view_of(job);
  double highest = -HUGE_VAL;
  for (const Segment& s : job.profile) highest = std::max(highest, range_v(view.to(s))[1]);
  return highest - view.to(job.start).v;
}

Backward backward(const Roughing& job) {
  const View view = view_of(job);
  Backward worst;
  Point best{-HUGE_VAL, -HUGE_VAL};
  for (const Segment& programmed : job.profile) {
    const Segment s = view.to(programmed);
    const auto u = range_u(s);
    const auto v = range_v(s);
    worst.along = std::max({worst.along, against_u(s, 1), best.u - u[0]});
    worst.across = std::max({worst.across, against_v(s, 1), best.v - v[0]});
    best = {std::max(best.u, u[1]), std::max(best.v, v[1])};
  }
  return worst;
}

double levels(const Roughing& job) {
  const View view = view_of(job);
  double low = view.to(job.start).v;
  for (const Segment& s : job.profile) low = std::min(low, range_v(view.to(s))[0]);
  return std::ceil((view.to(job.start).v - low) / job.depth);
}

std::size_t most_moves(const Roughing& job) {
  // Pockets: every level may cut as many intervals as there are segments, and follow every segment once more.
  return static_cast<std::size_t>(levels(job) + 2) * (6 * job.profile.size() + 8) + 3 * job.profile.size() +
         8;
}

Moves parallel_cuts(Roughing job) {
  const View view = view_of(job);
  const Path profile = seen_profile(job, view);
  const Point a = view.to(job.start);
  const Point c = plus(a, view.to(job.allowance));
  const Point first = profile.front().from;
  const MoveKind infeed = job.approach_rapid ? MoveKind::rapid : MoveKind::feed;

  co_yield back(view, move_both(MoveKind::rapid, c));
  const double distance = c.v - first.v;
  const double exact = distance / job.depth;
  // A level that misses the first point of the profile by rounding only is that point.
  auto cuts = static_cast<std::int64_t>(std::ceil(exact - 1e-9));
  if (!job.level_cut_at_start && cuts > 0) --cuts;
  for (std::int64_t k = 1; k <= cuts; ++k) {
    const double level = std::max(c.v - job.depth * static_cast<double>(k), first.v);
    const double end = end_of_cut(profile, level, c.u);
    if (end - c.u < kTiny) continue;  // the profile stands right at the start: nothing to cut here
    co_yield back(view, move_v(infeed, level));
    co_yield back(view, move_u(MoveKind::feed, end));
    const double out = std::min(job.retract, end - c.u);
    co_yield back(view, move_both(MoveKind::feed, {end - out, level + job.retract}));
    co_yield back(view, ending_pass(move_u(MoveKind::rapid, c.u)));
  }
  if (job.contour_pass) {
    co_yield back(view, move_v(infeed, first.v));
    if (std::fabs(first.u - c.u) > kTiny) co_yield back(view, move_u(MoveKind::feed, first.u));
    for (const Segment& s : profile) {
      co_yield back(view, along(s));
      if (s.dwell_s > 0) co_yield Move{.kind = MoveKind::dwell, .seconds = s.dwell_s};
    }
  }
  double top = first.v;  // a profile that was not checked may end below its highest point
  for (const Segment& s : profile) top = std::max(top, range_v(s)[1]);
  if (job.contour_pass && profile.back().to.v < top - kTiny)
    co_yield back(view, move_v(MoveKind::rapid, std::max(top, c.v)));
  if (job.return_by_allowance) co_yield back(view, move_both(MoveKind::rapid, c));
  co_yield back(view, move_both(MoveKind::rapid, a));
}

Moves repeated_pattern(Pattern job) {
  const double count = static_cast<double>(job.passes);
  for (std::int64_t n = 1; n <= job.passes; ++n) {
    const double left = job.passes > 1 ? (count - static_cast<double>(n)) / (count - 1) : 0;
    const Point by{job.relief.u * left + job.allowance.u, job.relief.v * left + job.allowance.v};
    co_yield move_both(MoveKind::rapid, plus(job.start, by));
    const Path contour = shifted(job.profile, by);
    co_yield move_both(job.approach_rapid ? MoveKind::rapid : MoveKind::feed, contour.front().from);
    for (const Segment& s : contour) {
      Move cut = along(s);
      cut.ends_pass = &s == &contour.back();
      co_yield cut;
      if (s.dwell_s > 0) co_yield Move{.kind = MoveKind::dwell, .seconds = s.dwell_s};
    }
  }
  co_yield move_both(MoveKind::rapid, job.start);
}

}  // namespace headstock::cycles

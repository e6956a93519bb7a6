// Roughing of thousands of random profiles, judged by a model of the work that shares nothing with the
// planner: heights over a grid along the cuts.
#include "cycles/roughing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace headstock::cycles {
namespace {

// ---- random profiles in the planner's view: cuts go toward +u, material is taken from +v downward

struct Rng {
  std::mt19937 engine;
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  int pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(engine); }
};

Segment straight(Point from, Point to) {
  Segment s;
  s.from = from;
  s.to = to;
  return s;
}

// A quarter circle or less between two points, bulging to one side; monotonic in u and v.
Segment rounded(Point from, Point to, bool left) {
  const double du = to.u - from.u, dv = to.v - from.v;
  const double chord = std::hypot(du, dv);
  // Centre on the bisector, far enough that no turning point lies inside: radius from the steeper end's
  // tangent.
  const double flat = std::min(std::fabs(du), std::fabs(dv));
  const double steep = std::max(std::fabs(du), std::fabs(dv));
  // Half the sweep may be at most the angle between the chord and the nearer axis.
  const double half = std::atan2(flat, steep) * 0.98;
  const double radius = chord / 2 / std::sin(half);
  const double height = radius * std::cos(half);
  const double side = left ? 1 : -1;
  Segment s = straight(from, to);
  s.arc = true;
  s.center = {(from.u + to.u) / 2 - side * height * dv / chord,
              (from.v + to.v) / 2 + side * height * du / chord};
  s.sweep = side * 2 * half;  // centre on the left: counter-clockwise
  return s;
}

Path random_profile(Rng& rng, bool pockets, Point from) {
  Path path;
  Point here = from;
  const int count = 1 + rng.pick(8);
  int last = -1;
  for (int i = 0; i < count; ++i) {
    Point to = here;
    int kind = rng.pick(pockets ? 6 : 4);
    if ((kind == 1 && last == 5) || (kind == 5 && last == 1)) kind = 0;  // a slot without width
    last = kind;
    const double du = rng.between(0.5, 12), dv = rng.between(0.5, 6);
    if (kind == 0) to.u += du;  // along the axis
    if (kind == 1) to.v += dv;  // a wall
    if (kind == 2 || kind == 3) to = {here.u + du, here.v + dv};
    if (kind == 4) to = {here.u + du, here.v - dv};
    if (kind == 5) to.v -= dv;
    if (kind == 1 && i == 0) to.u += du;
    const bool slope = to.u != here.u && to.v != here.v;
    path.push_back(slope && rng.pick(2) == 0 ? rounded(here, to, rng.pick(2) == 0) : straight(here, to));
    here = to;
  }
  if (here.u == from.u) path.push_back(straight(here, {here.u + 3, here.v}));
  return path;
}

double highest(const Path& path) {
  double v = -1e9;
  for (const Segment& s : path) {
    for (int i = 0; i <= 200; ++i) v = std::max(v, at(s, i / 200.0).v);
  }
  return v;
}

// ---- the model

// Height of the profile over u, the highest where it is a wall; straight from the formulas of line and
// circle.
double height_over(const Path& path, double u) {
  double best = -1e9;
  for (const Segment& s : path) {
    const double low = std::min(s.from.u, s.to.u), high = std::max(s.from.u, s.to.u);
    if (u < low - 1e-9 || u > high + 1e-9) continue;
    if (!s.arc) {
      if (high - low < 1e-12) {
        best = std::max({best, s.from.v, s.to.v});
      } else {
        best = std::max(best, s.from.v + (s.to.v - s.from.v) * (u - s.from.u) / (s.to.u - s.from.u));
      }
      continue;
    }
    const double r = std::hypot(s.from.u - s.center.u, s.from.v - s.center.v);
    const double root = std::sqrt(std::max(0.0, r * r - (u - s.center.u) * (u - s.center.u)));
    const double side = (s.from.v + s.to.v) / 2 > s.center.v ? 1 : -1;
    best = std::max(best, s.center.v + side * root);
  }
  return best;
}

class Work {
 public:
  Work(Path profile, double from, double to, double stock)
      : profile_(std::move(profile)),
        from_(from),
        step_((to - from) / kCells),
        stock_(stock),
        heights_(kCells, stock) {}

  double u_of(std::size_t cell) const { return from_ + (static_cast<double>(cell) + 0.5) * step_; }
  double height(std::size_t cell) const { return heights_[cell]; }

  // Moves the tool; false with a reason when it goes where it must not.
  std::string move(Point a, const Segment& s, bool rapid) {
    constexpr int kSamples = 150;
    Point last = a;
    for (int i = 0; i <= kSamples; ++i) {
      const Point p = at(s, i / static_cast<double>(kSamples));
      // Touching a wall is not cutting into it: the lower of both sides counts.
      const double floor = std::min(height_over(profile_, p.u - 1e-7), height_over(profile_, p.u + 1e-7));
      if (p.v < std::min(floor, stock_) - 5e-5 && floor > -1e8)
        return "below the allowance at u=" + std::to_string(p.u) + " by " + std::to_string(floor - p.v);
      sweep(last, p, rapid);
      if (!crash_.empty()) return crash_;
      last = p;
    }
    return {};
  }

 private:
  static constexpr std::size_t kCells = 300;
  void sweep(Point a, Point b, bool rapid) {
    const double low = std::min(a.u, b.u), high = std::max(a.u, b.u);
    for (auto cell = static_cast<std::ptrdiff_t>((low - from_) / step_ - 1);
         cell <= static_cast<std::ptrdiff_t>((high - from_) / step_ + 1); ++cell) {
      if (cell < 0 || cell >= static_cast<std::ptrdiff_t>(kCells)) continue;
      const auto i = static_cast<std::size_t>(cell);
      const double u = u_of(i);
      if (u < low || u > high) continue;
      const double v = high - low < 1e-12 ? std::min(a.v, b.v) : a.v + (b.v - a.v) * (u - a.u) / (b.u - a.u);
      if (rapid && v < heights_[i] - 1e-6) crash_ = "rapid through material at u=" + std::to_string(u);
      heights_[i] = std::min(heights_[i], v);
    }
  }

  Path profile_;
  double from_, step_, stock_;
  std::vector<double> heights_;
  std::string crash_;
};

struct Numbers {
  std::size_t moves = 0, cells = 0;
};

// Plans the job and cuts the model with it.
void judge(const Roughing& job, bool pockets, Numbers& numbers) {
  const View view = view_of(job);
  Path profile;
  for (const Segment& s : job.profile) profile.push_back(view.to(s));
  const Point by = view.to(job.allowance);
  profile = shifted(profile, by);
  const Point start = view.to(job.start);
  // Material: from the first point of the contour on, up to the start level.
  Work work(profile, profile.front().from.u + 1e-5, profile.back().to.u - 1e-5,
            start.v + std::min(0.0, by.v));
  Moves moves = pockets ? pocket_cuts(job) : parallel_cuts(job);
  Move move;
  Point here = start;
  std::size_t count = 0;
  while (moves.next(move)) {
    ASSERT_LE(++count, most_moves(job)) << "more moves than promised";
    if (move.kind == MoveKind::dwell) continue;
    Segment s;
    s.from = view.back(here);
    s.to = s.from;
    if (move.along_u) s.to.u = move.to.u;
    if (move.along_v) s.to.v = move.to.v;
    s.arc = move.kind == MoveKind::arc;
    s.center = move.center;
    s.sweep = move.sweep;
    const Segment seen = view.to(s);
    const std::string wrong = work.move(here, seen, move.kind == MoveKind::rapid);
    ASSERT_EQ(wrong, "") << "move " << count;
    here = seen.to;
  }
  EXPECT_NEAR(here.u, start.u, 1e-9);
  EXPECT_NEAR(here.v, start.v, 1e-9);
  numbers.moves += count;
  for (std::size_t cell = 0; cell < 300; ++cell) {
    // The model cuts along chords: beside a wall that is a matter of micrometres along u.
    const double u = work.u_of(cell);
    const auto [low, high] = std::minmax(
        {height_over(profile, u - 1e-4), height_over(profile, u), height_over(profile, u + 1e-4)});
    const double stock =
        start.v;  // where the allowance reaches higher than the work there is nothing to leave
    ASSERT_GE(work.height(cell), std::min(low, stock) - 1e-3) << "cut too deep at u=" << u;
    ASSERT_LE(work.height(cell), high + 1e-3) << "material left at u=" << u;
    ++numbers.cells;
  }
}

Roughing random_job(Rng& rng, bool pockets) {
  Roughing job;
  const Point first{rng.between(-20, 20), rng.between(5, 15)};
  const Path contour = random_profile(rng, pockets, first);
  const Point start{first.u, highest(contour) + rng.between(0.01, 8)};
  View view;
  view.swapped = rng.pick(2) == 0;
  view.sign_u = rng.pick(2) == 0 ? 1 : -1;
  view.sign_v = rng.pick(2) == 0 ? 1 : -1;
  job.facing = view.swapped;
  job.start = view.back(start);
  for (const Segment& s : contour) job.profile.push_back(view.back(s));
  const int zero = rng.pick(4);
  // Allowances that leave material: away from the part. Along the cuts the tool starts that much earlier.
  const Point by{zero & 1 ? 0 : -rng.between(0, 0.5), zero & 2 ? 0 : rng.between(0, 1)};
  job.allowance = view.back(by);
  job.depth = rng.between(0.3, 5);
  job.retract = rng.pick(4) == 0 ? 0 : rng.between(0, 1.5);
  job.approach_rapid = rng.pick(2) == 0;
  job.level_cut_at_start = rng.pick(2) == 0;
  job.contour_out = rng.pick(2) == 0;
  job.return_by_allowance = rng.pick(2) == 0;
  job.contour_pass = pockets ? rng.pick(2) == 0 : true;
  return job;
}

TEST(Roughing, ParallelCutsLeaveTheAllowanceAndNothingElse) {
  Rng rng{std::mt19937(71)};
  Numbers numbers;
  for (int i = 0; i < 1'500; ++i) {
    SCOPED_TRACE(i);
    const Roughing job = random_job(rng, false);
    ASSERT_NEAR(backward(job).along, 0, 1e-6);
    ASSERT_NEAR(backward(job).across, 0, 1e-6);
    judge(job, false, numbers);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(numbers.moves, 20'000u);
}

TEST(Roughing, PocketsLeaveTheAllowanceAndNothingElse) {
  Rng rng{std::mt19937(72)};
  Numbers numbers;
  for (int i = 0; i < 1'500; ++i) {
    SCOPED_TRACE(i);
    const Roughing job = random_job(rng, true);
    ASSERT_NEAR(backward(job).along, 0, 1e-6);
    judge(job, true, numbers);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(numbers.moves, 20'000u);
}

TEST(Roughing, EveryPassOfAPatternIsNearer) {
  Pattern job;
  job.start = {10, 100};
  job.profile = {straight({0, 40}, {-20, 40}), straight({-20, 40}, {-30, 60})};
  job.allowance = {0.3, 0.25};
  job.relief = {1, 1};
  job.passes = 3;
  Moves moves = repeated_pattern(job);
  Move move;
  std::vector<Point> ends;
  while (moves.next(move)) ends.push_back(move.to);
  ASSERT_EQ(ends.size(), 3u * 4 + 1);
  EXPECT_NEAR(ends[1].v, 41.25, 1e-12);
  EXPECT_NEAR(ends[5].v, 40.75, 1e-12);
  EXPECT_NEAR(ends[9].v, 40.25, 1e-12);
  EXPECT_NEAR(ends[9].u, 0.3, 1e-12);
  EXPECT_NEAR(ends.back().u, 10, 1e-12);
}

TEST(Roughing, ProfileAboveTheStartIsSeen) {
  Roughing job;
  job.start = {0, 50};
  job.profile = {straight({0, 20}, {-20, 20}), straight({-20, 20}, {-30, 52})};
  EXPECT_NEAR(above_start(job), 2, 1e-12);
}

}  // namespace
}  // namespace headstock::cycles

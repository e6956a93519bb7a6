// Pass depths against closed forms, and bounds for any numbers.
#include "cycles/threading.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace headstock::cycles {
namespace {

std::vector<double> depths_of(const Threading& job) {
  std::vector<double> depths;
  Depths series(job);
  double depth = 0;
  while (series.next(depth)) depths.push_back(depth);
  return depths;
}

Threading m68() {
  Threading job;
  job.start = {10, 40};
  job.end = {-62, 30.32};
  job.height = 3.68;
  job.first_depth = 1.8;
  job.least = 0.1;
  job.finish = 0.2;
  job.lead_mm = 6;
  job.tip_angle_deg = 60;
  return job;
}

TEST(ThreadDepths, ConstantAreaGrowsWithTheRoot) {
  Threading job = m68();
  job.least = 0;
  job.first_depth = 0.5;
  const auto depths = depths_of(job);
  for (std::size_t n = 1; n + 1 < depths.size(); ++n) {
    EXPECT_NEAR(depths[n - 1], std::min(0.5 * std::sqrt(static_cast<double>(n)), 3.48), 1e-12);
  }
  EXPECT_DOUBLE_EQ(depths.back(), 3.68);
  // Equal chips: the area of a triangle grows by the same amount with every pass.
  for (std::size_t n = 1; n + 2 < depths.size(); ++n) {
    EXPECT_NEAR(depths[n] * depths[n] - depths[n - 1] * depths[n - 1], 0.25,
                n + 3 < depths.size() ? 1e-9 : 0.25);
  }
}

TEST(ThreadDepths, ManualExamples) {
  const auto gsk = depths_of(m68());  // GSK218T L2106
  ASSERT_EQ(gsk.size(), 5u);
  EXPECT_NEAR(gsk[1], 2.5456, 1e-4);
  EXPECT_NEAR(gsk[2], 3.1177, 1e-4);
  EXPECT_NEAR(gsk[3], 3.48, 1e-12);
  EXPECT_NEAR(gsk[4], 3.68, 1e-12);
}

TEST(ThreadDepths, ConstantDepthAndLeastCut) {
  Threading job = m68();
  job.law = DepthLaw::constant_depth;
  job.first_depth = 1;
  EXPECT_EQ(depths_of(job), (std::vector<double>{1, 2, 3, 3.48, 3.68}));
  job.law = DepthLaw::constant_area;
  job.least = 0.6;  // √2 - 1 is less than that
  EXPECT_EQ(depths_of(job).size(), 7u);
  EXPECT_NEAR(depths_of(job)[1], 1.6, 1e-12);
  EXPECT_NEAR(depths_of(job)[2], 2.2, 1e-12);
}

TEST(ThreadDepths, AlwaysDeeperAndWithinTheBound) {
  std::mt19937 engine(76);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  for (int i = 0; i < 3'000; ++i) {
    Threading job = m68();
    job.height = between(0.2, 8);
    job.first_depth = between(0.02, 1) * job.height;
    job.least = between(0, 0.3) * job.height;
    job.finish = i % 3 == 0 ? 0 : between(0, 0.4) * job.height;
    job.finish_passes = 1 + i % 4;
    job.law = i % 2 == 0 ? DepthLaw::constant_area : DepthLaw::constant_depth;
    job.least_from = i % 5 == 0 ? LeastFrom::root : LeastFrom::last_pass;
    const auto depths = depths_of(job);
    ASSERT_LE(static_cast<double>(depths.size()), most_passes(job));
    for (std::size_t n = 1; n < depths.size(); ++n) ASSERT_GE(depths[n], depths[n - 1]);
    ASSERT_DOUBLE_EQ(depths.back(), job.height);
    ASSERT_LE(depths[depths.size() - static_cast<std::size_t>(job.finish_passes) - 1],
              job.height - job.finish + 1e-12);
  }
}

TEST(Threading, EveryPassLiesOnTheSameFlankAndCone) {
  Threading job = m68();
  job.taper = -2;
  Moves moves = threading(job);
  Move move;
  int threads = 0;
  Point begin;
  const double flank = std::tan(30 * std::acos(-1.0) / 180);
  while (moves.next(move)) {
    if (move.kind == MoveKind::rapid && move.along_u && move.along_v) begin = move.to;
    if (move.kind != MoveKind::thread) continue;
    ++threads;
    const double depth = job.height - (move.to.v - job.end.v);
    const double shift = job.start.u - begin.u;
    EXPECT_NEAR(shift, depth * flank, 1e-9) << "the flank of the tool";
    const double slope = (begin.v - move.to.v) / (begin.u - move.to.u);
    EXPECT_NEAR(slope, job.taper / (job.start.u - job.end.u), 1e-12) << "parallel to the cone";
  }
  EXPECT_EQ(threads, 5);
}

// Quarter circles at both ends, on cones of every sign, toward both sides: judged by distances only.
TEST(Threading, ArcsTouchTheThreadAndNeverCutBelowIt) {
  std::mt19937 random(76);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < 2'000; ++i) {
    SCOPED_TRACE(i);
    ThreadPass job;
    const double toward = i % 2 == 0 ? -1 : 1, out = i % 4 < 2 ? 1 : -1;
    job.start = {0, 50};
    job.end = {toward * between(20, 60), 50 - out * between(15, 25)};
    job.taper = between(-4, 4);
    job.shift = between(-1, 3);
    job.lead_mm = between(0.5, 6);
    job.arc_in = i % 5 == 0 ? 0 : between(0.5, 6);
    job.arc_out = i % 3 == 0 ? 0 : between(0.5, 6);
    const Point begin{toward * job.shift, job.end.v + job.taper};
    const double size = std::hypot(job.end.u - begin.u, job.end.v - begin.v);
    const Point t{(job.end.u - begin.u) / size, (job.end.v - begin.v) / size};
    // How far out of the thread's line a point stands.
    const auto above = [&](Point q) { return out * toward * (t.u * (q.v - begin.v) - t.v * (q.u - begin.u)); };

    Moves moves = thread_pass(job);
    Move move;
    Point here = job.start;
    double in_mm = 0, out_mm = 0, speed = 0;
    int cuts = 0;
    bool on_thread = false;
    while (moves.next(move)) {
      const Point from = here;
      if (move.along_u) here.u = move.to.u;
      if (move.along_v) here.v = move.to.v;
      if (move.kind != MoveKind::thread) continue;
      ++cuts;
      ASSERT_GT(above(here), -1e-9) << "below the thread";
      const double du = std::fabs(here.u - from.u), dv = std::fabs(here.v - from.v), l = std::hypot(du, dv);
      const double on_path = move.lead_mm * l / std::max(du, dv);  // a turn of the spindle, along the path
      if (cuts > 1) {
        ASSERT_NEAR(on_path, speed, 1e-9);
      }
      speed = on_path;
      if (move.run_up_mm == 0) {
        on_thread = true;
        ASSERT_NEAR(above(from), 0, 1e-9);
        ASSERT_NEAR(above(here), 0, 1e-9);
        continue;
      }
      (on_thread ? out_mm : in_mm) += l;
      const double radius = on_thread ? job.arc_out : job.arc_in;
      // The circle that touches the thread's line and the way across.
      const double across_u = on_thread ? job.end.u - toward * radius : begin.u + toward * radius;
      const Point on_line{across_u, begin.v + (across_u - begin.u) * t.v / t.u};
      const Point center{across_u, on_line.v + out * radius / std::fabs(t.u)};
      const Point middle{(from.u + here.u) / 2, (from.v + here.v) / 2};
      ASSERT_NEAR(std::hypot(here.u - center.u, here.v - center.v), radius, 1e-9);
      ASSERT_NEAR(std::hypot(middle.u - center.u, middle.v - center.v), radius, kThreadChord_mm + 1e-9);
    }
    ASSERT_TRUE(on_thread);
    const auto about = [](double radius) { return radius * std::acos(-1.0) / 2; };
    EXPECT_NEAR(in_mm, about(job.arc_in), 0.25 * job.arc_in + 1e-9) << "a quarter, on cones about";
    EXPECT_NEAR(out_mm, about(job.arc_out), 0.25 * job.arc_out + 1e-9);
    EXPECT_NEAR(here.u, job.start.u, 1e-12);
    EXPECT_NEAR(here.v, job.start.v, 1e-12);
  }
}

TEST(Threading, StartsAreSpreadEvenly) {
  Threading job = m68();
  job.starts = 3;
  Moves moves = threading(job);
  Move move;
  std::vector<double> angles;
  while (moves.next(move)) {
    if (move.kind == MoveKind::thread) angles.push_back(move.angle_deg);
  }
  ASSERT_EQ(angles.size(), 15u);
  EXPECT_NEAR(angles[0], 0, 1e-12);
  EXPECT_NEAR(angles[1], 120, 1e-12);
  EXPECT_NEAR(angles[2], 240, 1e-12);
  EXPECT_NEAR(angles[3], 0, 1e-12);
}

TEST(Pecking, ReachesTheBottomInEveryColumnWithoutLongerPecks) {
  std::mt19937 engine(74);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  for (int i = 0; i < 500; ++i) {
    Pecking job;
    job.across_first = i % 2 == 0;
    job.start = {between(-50, 50), between(10, 60)};
    job.end = {between(-50, 50), between(10, 60)};
    job.step = between(0.5, 5);
    job.peck = between(0.5, 9);
    job.back = between(0, 0.4);
    job.full_retract = i % 7 == 0;
    const auto p = [&](Point at) { return job.across_first ? at.v : at.u; };
    const auto q = [&](Point at) { return job.across_first ? at.u : at.v; };
    const auto on_p = [&](const Move& m) { return job.across_first ? m.along_v : m.along_u; };
    Moves moves = pecking(job);
    Move move;
    double at_p = p(job.start), at_q = q(job.start), deepest = 0;
    int bottoms = 0;
    while (moves.next(move)) {
      if (on_p(move)) {
        const double depth = std::fabs(p(move.to) - p(job.start));
        if (move.kind == MoveKind::feed) {
          ASSERT_LE(depth - deepest, job.peck + 1e-9) << "a peck longer than commanded";
          deepest = std::max(deepest, depth);
          if (p(move.to) == p(job.end)) ++bottoms;
        }
        at_p = p(move.to);
      } else {
        ASSERT_NEAR(at_p, p(job.start), 1e-9) << "steps only outside the work";
        ASSERT_LE(std::fabs(q(move.to) - at_q),
                  std::max(job.step, std::fabs(q(job.end) - q(job.start))) + 1e-9);
        at_q = q(move.to);
        deepest = 0;
      }
    }
    const double width = std::fabs(q(job.end) - q(job.start));
    ASSERT_EQ(bottoms, static_cast<int>(std::ceil(width / job.step - 1e-9)) + 1);
    ASSERT_EQ(at_q, q(job.start));
  }
}

}  // namespace
}  // namespace headstock::cycles

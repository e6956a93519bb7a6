#include "cycles/geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace headstock::cycles {
namespace {

constexpr double kHalf = std::numbers::pi;

Segment line(Point from, Point to) {
  Segment s;
  s.from = from;
  s.to = to;
  return s;
}

Segment arc(Point from, Point to, Point center, double sweep) {
  Segment s = line(from, to);
  s.arc = true;
  s.center = center;
  s.sweep = sweep;
  return s;
}

TEST(Geometry, LineCrossesALevelOnce) {
  std::array<double, 2> t{};
  ASSERT_EQ(crossings(line({0, 0}, {10, 4}), 1, t), 1u);
  EXPECT_DOUBLE_EQ(t[0], 0.25);
  EXPECT_EQ(crossings(line({0, 1}, {10, 1}), 1, t), 0u) << "lying on the level is not crossing it";
  EXPECT_EQ(crossings(line({0, 0}, {10, 4}), 4, t), 0u) << "touching with an end is not crossing";
}

TEST(Geometry, HalfCircleCrossesTwiceInOrder) {
  const Segment s = arc({10, 0}, {-10, 0}, {0, 0}, kHalf);
  std::array<double, 2> t{};
  ASSERT_EQ(crossings(s, 5, t), 2u);
  EXPECT_NEAR(t[0], 1.0 / 6, 1e-12);
  EXPECT_NEAR(t[1], 5.0 / 6, 1e-12);
  EXPECT_EQ(crossings(s, 10, t), 0u) << "touching the top";
  EXPECT_EQ(crossings(s, -1, t), 0u);
}

TEST(Geometry, RangesOfAnArcReachItsTurningPoints) {
  const Segment s = arc({10, 0}, {-10, 0}, {0, 0}, kHalf);
  EXPECT_NEAR(range_v(s)[1], 10, 1e-12);
  EXPECT_NEAR(range_v(s)[0], 0, 1e-12);
  EXPECT_NEAR(range_u(s)[0], -10, 1e-12);
  EXPECT_NEAR(range_u(s)[1], 10, 1e-12);
}

TEST(Geometry, StepsBackAreMeasured) {
  EXPECT_EQ(against_u(line({0, 0}, {10, 4}), 1), 0);
  EXPECT_EQ(against_u(line({0, 0}, {-10, 4}), 1), 10);
  const Segment half = arc({-10, 0}, {10, 0}, {0, 0}, -kHalf);  // over the top, toward +u
  EXPECT_NEAR(against_u(half, 1), 0, 1e-12);
  EXPECT_NEAR(against_v(half, 1), 10, 1e-12);
}

TEST(Geometry, ViewGoesThereAndBackForEverySign) {
  const Segment s = arc({10, 0}, {0, 10}, {0, 0}, kHalf / 2);
  for (const bool swapped : {false, true}) {
    for (const double su : {1.0, -1.0}) {
      for (const double sv : {1.0, -1.0}) {
        const View view{swapped, su, sv};
        const Segment seen = view.to(s);
        // The middle of the arc must lie where the view puts it: orientation is right.
        const Point middle = view.to(at(s, 0.5));
        EXPECT_NEAR(at(seen, 0.5).u, middle.u, 1e-12);
        EXPECT_NEAR(at(seen, 0.5).v, middle.v, 1e-12);
        const Segment again = view.back(seen);
        EXPECT_NEAR(again.to.u, s.to.u, 1e-12);
        EXPECT_NEAR(again.sweep, s.sweep, 1e-12);
      }
    }
  }
}

TEST(Geometry, StretchesBelowALevel) {
  // Down into a groove and up again, a ridge at 5, then a second groove.
  const Path path = {line({0, 10}, {0, 2}), line({0, 2}, {4, 2}),  line({4, 2}, {6, 6}),
                     line({6, 6}, {8, 2}),  line({8, 2}, {12, 2}), line({12, 2}, {12, 10})};
  const auto low = not_above(path, 4, {0, 6});
  ASSERT_EQ(low.size(), 2u);
  EXPECT_NEAR(point_at(path, low[0].to).u, 5, 1e-12);
  EXPECT_NEAR(point_at(path, low[1].from).u, 7, 1e-12);
  EXPECT_EQ(not_above(path, 7, {0, 6}).size(), 1u);
  EXPECT_EQ(not_above(path, 1, {0, 6}).size(), 0u);
  const Path cut = cut_out(path, low[0]);
  EXPECT_NEAR(cut.front().from.v, 4, 1e-12);
  EXPECT_NEAR(cut.back().to.v, 4, 1e-12);
}

}  // namespace
}  // namespace headstock::cycles

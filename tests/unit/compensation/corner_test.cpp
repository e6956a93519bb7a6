// Chamfers and rounds between lines and arcs, checked by what they must be: ends on both segments, the size
// asked for, tangent.
#include "compensation/corner.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "compensation/drawing.hpp"

namespace headstock::comp {
namespace {

double heading(Point d) {
  return std::atan2(d.v, d.u);
}

double turned(double a, double b) {
  return std::remainder(a - b, 2 * std::numbers::pi);
}

// A segment of about 20…40 mm that starts at `from` with a heading.
Segment random_segment(std::mt19937& random, Point from, double at) {
  std::uniform_real_distribution<double> size(20, 40), side(-1, 1);
  const double kind = side(random);
  if (kind < 0) return line(from, from + Point{std::cos(at), std::sin(at)} * size(random));
  const double radius = size(random);
  const double turn = side(random) > 0 ? 1 : -1;
  const Point center = from + left_of({std::cos(at), std::sin(at)}) * (turn * radius);
  const double by = turn * size(random) / radius;
  const Point arm = from - center;
  const Point end = center + Point{arm.u * std::cos(by) - arm.v * std::sin(by),
                                   arm.u * std::sin(by) + arm.v * std::cos(by)};
  return arc(from, end, center, turn);
}

TEST(CutCorner, RoundsAreTangentAndChamfersHaveTheirSize) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> bend(0.3, 2.4), size(0.5, 3);
  int rounds = 0, chamfers = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Segment a = random_segment(random, {1, 2}, 0.7);
    const double turn = (i % 2 == 0 ? 1 : -1) * bend(random);
    const Segment b = random_segment(random, a.to, heading(a.direction_at_end()) + turn);
    const double r = size(random);

    const CutCorner round = cut_corner(a, b, CornerShape::round, r, ChamferSize::cut_back);
    if (round.fault == CornerFault::none) {
      ++rounds;
      ASSERT_NEAR(round.inserted.start_radius(), r, 1e-9);
      ASSERT_NEAR(round.inserted.end_radius(), r, 1e-9);
      ASSERT_NEAR(
          turned(heading(round.first.direction_at_end()), heading(round.inserted.direction_at_start())), 0,
          1e-6);
      ASSERT_NEAR(
          turned(heading(round.inserted.direction_at_end()), heading(round.second.direction_at_start())), 0,
          1e-6);
      ASSERT_LT(round.inserted.sweep, std::numbers::pi);
      ASSERT_LE(round.first.length_mm(), a.length_mm() + 0.01);
      ASSERT_LE(round.second.length_mm(), b.length_mm() + 0.01);
    }
    const CutCorner chamfer = cut_corner(a, b, CornerShape::chamfer, r, ChamferSize::cut_back);
    ASSERT_EQ(chamfer.fault, CornerFault::none);
    ++chamfers;
    ASSERT_NEAR(length(chamfer.inserted.from - a.to), r, 1e-9);
    ASSERT_NEAR(length(chamfer.inserted.to - a.to), r, 1e-9);
    if (a.arc) {
      ASSERT_NEAR(length(chamfer.first.to - a.center), a.start_radius(), 1e-9);
    }

    const CutCorner own = cut_corner(a, b, CornerShape::chamfer, r, ChamferSize::own_length);
    ASSERT_EQ(own.fault, CornerFault::none);
    ASSERT_NEAR(own.inserted.length_mm(), r, 1e-6);
    ASSERT_NEAR(length(own.inserted.from - a.to), length(own.inserted.to - a.to), 1e-6);
  }
  EXPECT_GT(rounds, 15'000);
  EXPECT_EQ(chamfers, 20'000);
}

TEST(CutCorner, TooLargeAndNotNeeded) {
  const Segment a = line({0, 0}, {10, 0}), b = line({10, 0}, {10, 4});
  EXPECT_EQ(cut_corner(a, b, CornerShape::round, 4, ChamferSize::cut_back).fault, CornerFault::none);
  EXPECT_EQ(cut_corner(a, b, CornerShape::round, 4.1, ChamferSize::cut_back).fault, CornerFault::too_large);
  EXPECT_EQ(cut_corner(a, b, CornerShape::chamfer, 4.1, ChamferSize::cut_back).fault, CornerFault::too_large);
  EXPECT_EQ(cut_corner(a, b, CornerShape::chamfer, 4 * std::sqrt(2.0), ChamferSize::own_length).fault,
            CornerFault::none);
  EXPECT_EQ(cut_corner(a, b, CornerShape::chamfer, 5.7, ChamferSize::own_length).fault,
            CornerFault::too_large);
  const Segment on = line({10, 0}, {20, 0});
  EXPECT_EQ(cut_corner(a, on, CornerShape::round, 1, ChamferSize::cut_back).fault, CornerFault::not_needed);
}

TEST(Drawing, AnglesAreSlopes) {
  const auto p = at_first({0, 0}, 45, 10, 0.01);
  ASSERT_TRUE(p);
  EXPECT_NEAR(p->v, 10, 1e-12);
  EXPECT_NEAR(at_first({0, 0}, 225, 10, 0.01)->v, 10, 1e-12);
  EXPECT_FALSE(at_first({0, 0}, 90, 10, 0.01));
  EXPECT_FALSE(at_second({0, 0}, 180.5, 10, 1));
  const auto q = meet({0, 0}, 30, {10, 0}, 150, 0.01);
  ASSERT_TRUE(q);
  EXPECT_NEAR(q->u, 5, 1e-12);
  EXPECT_NEAR(q->v, 5 * std::tan(std::numbers::pi / 6), 1e-12);
  EXPECT_FALSE(meet({0, 0}, 30, {10, 0}, 210, 0.01));
}

}  // namespace
}  // namespace headstock::comp

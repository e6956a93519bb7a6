// Three-point arcs and spirals: ends, plane, radius law, and chords that stay on the curve.
#include "interpreter/space_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace headstock::interp {
namespace {

constexpr double kPi = std::numbers::pi;

double distance(const Point3& a, const Point3& b) {
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                   (a[2] - b[2]) * (a[2] - b[2]));
}
void expect_near(const Point3& a, const Point3& b, double tolerance = 1e-9) {
  EXPECT_NEAR(distance(a, b), 0, tolerance) << a[0] << ' ' << a[1] << ' ' << a[2];
}

TEST(SpaceCurve, ThreePointsOfTheManual) {  // K2000TC L2735
  SpaceCurve curve;
  ASSERT_EQ(three_point_arc({100, 0, 0}, {0, 100, 0}, {0, 0, 100}, curve), CurveError::none);
  expect_near(curve.pole, {100.0 / 3, 100.0 / 3, 100.0 / 3});
  EXPECT_NEAR(curve.angle, 4 * kPi / 3, 1e-12);
  expect_near(curve.at(0), {100, 0, 0});
  expect_near(curve.at(curve.angle / 2), {0, 100, 0});
  expect_near(curve.at(curve.angle), {0, 0, 100});
}

TEST(SpaceCurve, ThreePointsInALineAreStraight) {
  SpaceCurve curve;
  EXPECT_EQ(three_point_arc({0, 0, 0}, {1, 1, 1}, {2, 2, 2}, curve), CurveError::straight);
  EXPECT_EQ(three_point_arc({0, 0, 0}, {0, 0, 0}, {2, 2, 2}, curve), CurveError::straight);
  EXPECT_EQ(three_point_arc({0, 0, 0}, {1, 0, 0}, {0, 0, 0}, curve), CurveError::straight);
}

TEST(SpaceCurve, RandomThreePointArcsGoThroughTheirPoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-200, 200);
  for (int i = 0; i < 5'000; ++i) {
    const Point3 a{place(random), place(random), place(random)},
        b{place(random), place(random), place(random)}, c{place(random), place(random), place(random)};
    SpaceCurve curve;
    ASSERT_EQ(three_point_arc(a, b, c, curve), CurveError::none);
    if (curve.radius_from > 1e5) continue;
    expect_near(curve.at(0), a, 1e-6);
    expect_near(curve.at(curve.angle), c, 1e-6);
    // The middle point lies on the way: nearest of many samples.
    double nearest = 1e9;
    for (int k = 0; k <= 2'000; ++k)
      nearest = std::min(nearest, distance(curve.at(curve.angle * k / 2'000), b));
    EXPECT_LT(nearest, curve.radius_from * curve.angle / 2'000);
  }
}

TEST(SpaceCurve, SpiralAboutItsEnd) {  // L2973: two turns from X100 to the pole
  SpaceCurve curve;
  ASSERT_EQ(spiral_about_end({100, 0, 0}, {0, 0, 0}, {0, 1, 0}, true, 4 * kPi, curve), CurveError::none);
  expect_near(curve.at(0), {100, 0, 0});
  expect_near(curve.at(2 * kPi), {50, 0, 0});
  expect_near(curve.at(4 * kPi), {0, 0, 0});
  ASSERT_EQ(spiral_about_end({0, 0, 0}, {100, 0, 0}, {0, -1, 0}, false, 4 * kPi, curve), CurveError::none);
  expect_near(curve.at(0), {0, 0, 0});
  expect_near(curve.at(4 * kPi), {100, 0, 0});
  EXPECT_EQ(spiral_about_end({1, 0, 0}, {1, 0, 0}, {0, 1, 0}, true, 1, curve), CurveError::no_way);
  EXPECT_EQ(spiral_about_end({1, 0, 0}, {2, 0, 0}, {0, 0, 0}, true, 1, curve), CurveError::no_normal);
}

TEST(SpaceCurve, SpiralAboutAPole) {  // L2991: 2.5 turns, radius 100 to 200
  SpaceCurve curve;
  ASSERT_EQ(spiral_about_pole({100, 0, 0}, {-200, 0, 0}, {0, 0, 0}, {0, 1, 0}, 2, false, 0, curve),
            CurveError::none);
  EXPECT_NEAR(curve.angle, 5 * kPi, 1e-12);
  expect_near(curve.at(curve.angle), {-200, 0, 0});
  EXPECT_NEAR(curve.radius_at(2.5 * kPi), 150, 1e-9);
  ASSERT_EQ(spiral_about_pole({100, 0, 0}, {-200, 0, 0}, {0, 0, 0}, {0, 1, 0}, 2, true, 0, curve),
            CurveError::none);
  EXPECT_NEAR(curve.radius_at(2.5 * kPi), 100 * std::sqrt(2.0), 1e-9);  // the same factor every turn
  expect_near(curve.at(curve.angle), {-200, 0, 0});
  // Equal ends are a circle, and one more turn for each P (L2930).
  ASSERT_EQ(spiral_about_pole({100, 0, 0}, {100, 0, 0}, {0, 0, 0}, {0, 1, 0}, 1, false, 0, curve),
            CurveError::none);
  EXPECT_NEAR(curve.angle, 4 * kPi, 1e-12);
}

TEST(SpaceCurve, EndOffThePlaneAddsAStraightWay) {  // L3166
  SpaceCurve curve;
  ASSERT_EQ(spiral_about_pole({300, 0, 0}, {-600, 0, 0}, {100, 100, 100}, {1, 1, 1}, 2, false, 0.01, curve),
            CurveError::none);
  expect_near(curve.at(0), {300, 0, 0}, 1e-9);
  expect_near(curve.at(curve.angle), {-600, 0, 0}, 1e-9);
  const double along_normal = (-600.0 - 300.0) / std::sqrt(3.0);
  EXPECT_NEAR(distance(curve.leg, {0, 0, 0}), std::fabs(along_normal), 1e-9);
}

TEST(SpaceCurve, Mistakes) {
  SpaceCurve curve;
  EXPECT_EQ(spiral_about_pole({100, 0, 0}, {-200, 0, 0}, {0, 1, 0}, {0, 1, 0}, 2, false, 0.01, curve),
            CurveError::pole_off_plane);
  EXPECT_EQ(spiral_about_pole({100, 0, 0}, {-200, 0, 0}, {100, 0, 0}, {0, 1, 0}, 2, false, 0.01, curve),
            CurveError::pole_on_start);
  EXPECT_EQ(spiral_about_pole({100, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 1, 0}, 2, true, 0.01, curve),
            CurveError::radius);
}

TEST(SpaceCurve, ChordsStayOnTheCurve) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-150, 150);
  constexpr double kTolerance = 0.0005;
  for (int i = 0; i < 60; ++i) {
    const Point3 start{place(random), place(random), 0}, end{place(random), place(random), 0};
    SpaceCurve curve;
    ASSERT_EQ(spiral_about_pole(start, end, {0, 0, 0}, {0, 0, 1}, i % 3, i % 2 == 0, 0, curve),
              CurveError::none);
    double turned = 0;
    int chords = 0;
    while (turned < curve.angle) {
      const double next = std::min(turned + curve.chord(turned, kTolerance), curve.angle);
      const Point3 a = curve.at(turned), b = curve.at(next), m = curve.at((turned + next) / 2);
      const Point3 half{(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
      // Across the chord; along it the two middles may differ.
      const double length = distance(a, b);
      const double along =
          ((m[0] - half[0]) * (b[0] - a[0]) + (m[1] - half[1]) * (b[1] - a[1])) / std::max(length, 1e-12);
      const double off = std::sqrt(std::max(0.0, distance(m, half) * distance(m, half) - along * along));
      ASSERT_LT(off, kTolerance * 1.3) << i;
      turned = next;
      ASSERT_LT(++chords, 200'000);
    }
  }
}

}  // namespace
}  // namespace headstock::interp

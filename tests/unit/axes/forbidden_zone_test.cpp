#include "axes/forbidden_zone.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace headstock::axes {
namespace {

Zone box(bool outside) {
  return {0b11, {-5, -5}, {5, 5}, outside};
}
bool entered(const Zone& zone, AxisVector from, AxisVector to) {
  return find_entry(zone, from, motion::Line{to}).has_value();
}

TEST(ForbiddenZone, LinesIntoThroughAndPastABox) {
  const Zone zone = box(false);
  EXPECT_TRUE(entered(zone, {-10, 0}, {0, 0}));
  EXPECT_TRUE(entered(zone, {-10, 0}, {10, 0}));
  EXPECT_TRUE(entered(zone, {-10, -8}, {10, 8}));
  EXPECT_FALSE(entered(zone, {-10, 6}, {10, 6}));
  EXPECT_FALSE(entered(zone, {-10, 5}, {10, 5})) << "along the border";
  EXPECT_FALSE(entered(zone, {0, -12}, {12, 0})) << "past a corner";
  EXPECT_FALSE(entered(zone, {0, 0}, {-10, 0})) << "out of it";
  EXPECT_TRUE(entered(zone, {0, 0}, {1, 0})) << "about in it";
  EXPECT_TRUE(entered(zone, {-10, 0, 3}, {0, 0, 99})) << "no border along the third axis";
  const auto entry = find_entry(zone, {10, 0}, motion::Line{{0, 0}});
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->axis, 0u);
  EXPECT_FALSE(entry->positive);
}

TEST(ForbiddenZone, LeavingAPermittedBox) {
  const Zone zone = box(true);
  EXPECT_FALSE(entered(zone, {0, 0}, {5, 5}));
  EXPECT_TRUE(entered(zone, {0, 0}, {5.001, 0}));
  EXPECT_FALSE(entered(zone, {9, 0}, {7, 0})) << "back inwards";
}

TEST(ForbiddenZone, HowNearALineComes) {
  const Zone forbidden = box(false), permitted = box(true);
  const AxisVector one{1, 1}, flat{1, 0.1};
  const auto near = [](const Zone& zone, AxisVector from, AxisVector to, AxisVector distance) {
    return comes_near(zone, from, motion::Line{to}, distance);
  };
  EXPECT_TRUE(near(forbidden, {-10, 5.9}, {10, 5.9}, one));
  EXPECT_FALSE(near(forbidden, {-10, 6}, {10, 6}, one)) << "as far as asked for";
  EXPECT_FALSE(near(forbidden, {-10, 5.9}, {10, 5.9}, flat));
  EXPECT_FALSE(near(forbidden, {0, -12.1}, {12.1, 0}, one)) << "past its corner";
  EXPECT_TRUE(near(forbidden, {0, 0}, {-10, 0}, one)) << "out of it";
  EXPECT_FALSE(near(permitted, {-4, 0}, {4, 0}, one));
  EXPECT_TRUE(near(permitted, {-4.1, 0}, {4, 0}, one));
  EXPECT_TRUE(near(permitted, {0, 0}, {0, 4.95}, flat));
  EXPECT_FALSE(near(Zone{}, {0, 0}, {1, 1}, one)) << "a zone without axes";
}

TEST(ForbiddenZone, ArcsAgainstTheirPoints) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> one(-1, 1);
  int hits = 0, misses = 0;
  for (int round = 0; round < 2000; ++round) {
    const AxisVector start{10 * one(generator), 10 * one(generator)};
    if (std::abs(start[0]) < 5.1 && std::abs(start[1]) < 5.1) continue;
    motion::Arc arc;
    arc.axis_1 = 0;
    arc.axis_2 = 1;
    const double x = 8 * one(generator), y = 8 * one(generator), angle = 6 * one(generator);
    arc.center_1 = start[0] - x;
    arc.center_2 = start[1] - y;
    arc.angle_rad = angle;
    const auto at = [&](double w) {
      const double c = std::cos(angle * w), s = std::sin(angle * w);
      return AxisVector{arc.center_1 + c * x - s * y, arc.center_2 + s * x + c * y};
    };
    arc.end = at(1);
    double nearest = 1e9;  // how far outside the box at the nearest; < 0: inside
    for (int k = 0; k <= 5000; ++k) {
      const AxisVector p = at(k / 5000.0);
      nearest = std::min(nearest, std::max(std::abs(p[0]), std::abs(p[1])) - 5);
    }
    const bool found = find_entry(box(false), start, arc).has_value();
    const bool near = comes_near(box(false), start, arc, AxisVector{2, 2});
    if (nearest < 2 || nearest > 2.03) {
      EXPECT_EQ(near, nearest < 2) << round << ' ' << nearest;
    }
    if (nearest < 0) {
      EXPECT_TRUE(found) << round;
      ++hits;
    } else if (nearest > 0.03) {
      EXPECT_FALSE(found) << round << ' ' << nearest;
      ++misses;
    }
  }
  EXPECT_GT(hits, 100);
  EXPECT_GT(misses, 100);
}

}  // namespace
}  // namespace headstock::axes

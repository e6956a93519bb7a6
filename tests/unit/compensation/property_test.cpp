// Thousands of random contours: where the control raises no alarm the tool's centre is never nearer than r to
// the contour and touches every piece that it has room for; where it does, the geometry really has no room.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "contour.hpp"

namespace headstock::reference {
namespace {

// Headings stay within 80° of +X: such a contour never meets itself.
std::vector<Piece> random_contour(std::mt19937& random) {
  std::uniform_real_distribution<double> heading(-1.4, 1.4), size(2, 20), radius(3, 30), chance(0, 1);
  std::uniform_int_distribution<int> count(3, 12);
  std::vector<Piece> contour;
  Xy at;
  for (int left = count(random); left > 0; --left) {
    const double from = heading(random);
    if (chance(random) < 0.6) {
      const double l = size(random);
      contour.push_back(line(at, {at.x + l * std::cos(from), at.y + l * std::sin(from)}));
    } else {
      const double to = heading(random);
      if (std::fabs(to - from) < 0.15) continue;
      contour.push_back(arc(at, from, radius(random), to - from));
    }
    at = contour.back().to;
  }
  return contour;
}

// The tool's centre when it touches the piece at a fraction of its way.
Xy touching(const Piece& p, double fraction, double r, int side) {
  const Xy q = point(p, fraction), ahead = point(p, fraction + 1e-6);
  const double l = std::hypot(ahead.x - q.x, ahead.y - q.y);
  return {q.x - side * r * (ahead.y - q.y) / l, q.y + side * r * (ahead.x - q.x) / l};
}

// Whether a tool that touches the contour somewhere would cut it elsewhere.
bool no_room(const std::vector<Piece>& contour, double r, int side) {
  for (const Piece& p : contour) {
    for (int k = 1; k < 200; ++k) {
      if (distance(touching(p, k / 200.0, r, side), contour) < r - 1e-3) return true;
    }
  }
  return false;
}

// Whether the tool fits against the piece anywhere.
bool fits(const std::vector<Piece>& contour, const Piece& p, double r, int side) {
  for (int k = 1; k < 400; ++k) {
    if (distance(touching(p, k / 400.0, r, side), contour) > r - 1e-4) return true;
  }
  return false;
}

// No place of the piece where the tool fits stays farther than r from its path.
bool touched(const std::vector<Piece>& contour, const Piece& p, const std::vector<Piece>& path, double r,
             int side) {
  for (int k = 1; k < 30; ++k) {
    if (distance(touching(p, k / 30.0, r, side), contour) < r - 1e-4) continue;  // it would cut elsewhere
    if (distance(point(p, k / 30.0), path) > r + kTolerance) return false;
  }
  return true;
}

TEST(CompensationProperty, DistanceOrAlarm) {
  std::mt19937 random(2024);
  std::uniform_real_distribution<double> tool(0.2, 4);
  int good = 0, alarms = 0, linked = 0;
  for (int i = 0; i < 6'000; ++i) {
    const std::vector<Piece> contour = as_programmed(random_contour(random));
    if (contour.size() < 2) continue;
    const double r = std::round(tool(random) * 1000) / 1000;
    const int side = i % 2 == 0 ? 1 : -1;
    const std::string program = program_around(contour, side);
    const Made made = run(program, r);
    SCOPED_TRACE(program + "r " + std::to_string(r));
    if (!made.alarm.empty()) {
      ++alarms;
      ASSERT_TRUE(made.alarm == "PS0041" || made.alarm == "PS0033" || made.alarm == "PS0038") << made.alarm;
      ASSERT_TRUE(no_room(contour, r, side)) << made.alarm;
      continue;
    }
    ++good;
    for (std::size_t m = 0; m < made.path.size(); ++m) {
      const unsigned block_line = made.lines[m];
      if (block_line <= kLinesBefore || block_line > kLinesBefore + contour.size()) continue;
      for (int k = 0; k <= 40; ++k) {
        ASSERT_GT(distance(point(made.path[m], k / 40.0), contour), r - kTolerance)
            << "cut by the path of piece " << block_line - kLinesBefore - 1;
      }
    }
    for (std::size_t j = 0; j < contour.size(); ++j) {
      if (touched(contour, contour[j], made.path, r, side)) continue;
      // Where a piece has no room for the tool at all, vectors are deleted and what is left is linked by a
      // straight line (K2000TC L18078): beside such a piece, and nowhere else, the tool may stay away.
      const bool beside = (j > 0 && !fits(contour, contour[j - 1], r, side)) ||
                          (j + 1 < contour.size() && !fits(contour, contour[j + 1], r, side));
      ASSERT_TRUE(beside) << "the tool stays away from piece " << j;
      ++linked;
    }
  }
  std::printf("contours without alarm %d, with alarm %d; pieces beside one without room %d\n", good, alarms,
              linked);
  EXPECT_GT(good, 5'000);
  EXPECT_GT(alarms, 300);
}

}  // namespace
}  // namespace headstock::reference

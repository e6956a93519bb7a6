// Every corner: line and arc in all pairs, both sides, inside and outside, sharp and flat, linear and
// circular connection, against distances measured point by point from the programmed contour.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "contour.hpp"

namespace headstock::reference {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kRadius = 3;
constexpr double kRounded = 0.004;  // end points are written with three decimals

Piece piece(Xy from, double heading, int kind) {
  if (kind == 0) return line(from, {from.x + 40 * std::cos(heading), from.y + 40 * std::sin(heading)});
  return arc(from, heading, 25, kind * 60 * kDegree);
}

struct Corner {
  int first, second, turn_deg, side;
  bool circular;
};

void check(const Corner& c) {
  const Piece a = piece({0, 0}, 0.2, c.first);
  const Piece b = piece(a.to, heading_at_end(a) + c.turn_deg * kDegree, c.second);
  const std::vector<Piece> contour = as_programmed({a, b});
  // From straight behind the contour, and away from it straight on: the corners in between are flat.
  const double in = heading_at_start(contour[0]), out = heading_at_end(contour[1]);
  const Xy before{-20 * std::cos(in), -20 * std::sin(in)};
  const Xy after{contour[1].to.x + 20 * std::cos(out), contour[1].to.y + 20 * std::sin(out)};
  char lead[200];
  std::snprintf(lead, sizeof lead, "G90 G94 G00 X%.4f Y%.4f\n%s G01 X0 Y0 D1 F500\n", before.x, before.y,
                c.side > 0 ? "G41" : "G42");
  char leave[100];
  std::snprintf(leave, sizeof leave, "G40 G01 X%.4f Y%.4f\nM30\n", after.x, after.y);
  const std::string program = lead + block(contour[0]) + block(contour[1]) + leave;
  const Made made = run(program, kRadius, c.circular ? R"({"19607#2": true})" : "{}");
  SCOPED_TRACE(program);
  ASSERT_EQ(made.alarm, "");

  const bool inside = c.turn_deg * c.side > 0;
  const double furthest = inside || c.circular ? kRadius : kRadius * std::sqrt(2.0);
  double nearest = 1e9, far = 0;
  for (std::size_t i = 0; i < made.path.size(); ++i) {
    if (made.lines[i] != 3 && made.lines[i] != 4) continue;
    for (int k = 0; k <= 200; ++k) {
      const double d = distance(point(made.path[i], k / 200.0), contour);
      nearest = std::min(nearest, d);
      far = std::max(far, d);
    }
  }
  EXPECT_GT(nearest, kRadius - kRounded);
  EXPECT_LT(far, furthest + kRounded);

  // The contour is touched everywhere but in the shadow of an inside corner.
  const double shadow = inside ? kRadius * std::tan(std::abs(c.turn_deg) * kDegree / 2) * 1.4 + 0.5 : 0;
  std::vector<Piece> centre;
  for (std::size_t i = 0; i < made.path.size(); ++i) {
    if (made.lines[i] == 3 || made.lines[i] == 4) centre.push_back(made.path[i]);
  }
  for (const Piece& p : contour) {
    for (int k = 0; k <= 100; ++k) {
      const Xy q = point(p, k / 100.0);
      if (std::hypot(q.x - a.to.x, q.y - a.to.y) < shadow) continue;
      EXPECT_LT(distance(q, centre), kRadius + kRounded) << k;
    }
  }
}

TEST(CornerMatrix, LineAndArcInAllPairs) {
  int corners = 0;
  for (const bool circular : {false, true}) {
    for (const int first : {0, 1, -1}) {
      for (const int second : {0, 1, -1}) {
        for (const int side : {1, -1}) {
          // Sharp corners of arcs that bend towards each other would cross themselves.
          for (const int turn : {-170, -135, -91, -90, -89, -45, -10, -1, 0, 1, 10, 45, 89, 90, 91, 120}) {
            if (std::abs(turn) > 91 && (first != 0 || second != 0)) continue;
            check({first, second, turn, side, circular});
            if (testing::Test::HasFailure()) return;
            ++corners;
          }
        }
      }
    }
  }
  EXPECT_EQ(corners, 480);
}

}  // namespace
}  // namespace headstock::reference

// G07.1 and G12.1: what comes out is checked against the programmed path, worked out here another way.
#include "interpreter/surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/unit/coordinates/bench.hpp"

namespace headstock::interp {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSlack = 1e-6;

struct Point {
  double a = 0, b = 0;
};
double distance(Point p, Point q) {
  return std::hypot(p.a - q.a, p.b - q.b);
}
double from_line(Point p, Point from, Point to) {
  return std::fabs((to.a - from.a) * (p.b - from.b) - (to.b - from.b) * (p.a - from.a)) / distance(from, to);
}

// Points of a move in steps that no bulge escapes, each carried through `map`.
void each_point(const AxisVector& from, const AxisVector& to,
                const std::function<void(const AxisVector&)>& at) {
  for (int step = 0; step <= 8; ++step) {
    AxisVector point{};
    for (std::size_t i = 0; i < point.size(); ++i) point[i] = from[i] + step / 8.0 * (to[i] - from[i]);
    at(point);
  }
}

// 0i-D 4.5, L3845 (examples E8) without its compensation: C parallel to X, so that G18 spans Z and C.
class Cylinder : public testing::Test {
 protected:
  static constexpr double kRadius = 57.299;
  Bench bench{"fanuc-0i-m", "C"};
  std::vector<Operation> made;
  void SetUp() override {
    bench.data.parameters["1022/C"] = 5;
    made = bench.run(
        "N01 G00 G90 Z100.0 C0\nN02 G01 G91 G18 Z0 C0\nN03 G07.1 C57299\nN04 G90 G01 Z120.0 F250\nN05 C30.0\n"
        "N06 G03 Z90.0 C60.0 R30.0\nN07 G01 Z70.0\nN08 G02 Z60.0 C70.0 R10.0\nN09 G01 C150.0\n"
        "N10 G02 Z70.0 C190.0 R75.0\nN11 G01 Z110.0 C230.0\nN12 G03 Z120.0 C270.0 R75.0\nN13 G01 C360.0\n"
        "N14 Z100.0\nN15 G07.1 C0\nN16 G00 C10.\nM30\n");
  }
};

TEST_F(Cylinder, EveryBlockEndsWhereItWasProgrammed) {
  ASSERT_EQ(alarm_of(made), "");
  struct End {
    std::uint32_t n;
    double z, c;
  };
  const End ends[] = {{4, 120, 0},    {5, 120, 30},   {6, 90, 60},    {7, 70, 60},
                      {8, 60, 70},    {9, 60, 150},   {10, 70, 190},  {11, 110, 230},
                      {12, 120, 270}, {13, 120, 360}, {14, 100, 360}, {16, 100, 10}};
  for (const End& end : ends) {
    const Motion* last = nullptr;
    for (const Operation& operation : made) {
      if (const Motion* m = motion_of(operation); m != nullptr && m->at.sequence == end.n) last = m;
    }
    ASSERT_NE(last, nullptr) << "N" << end.n;
    EXPECT_NEAR(last->end_machine[2], end.z, kSlack) << "N" << end.n;
    EXPECT_NEAR(last->end_machine[3], end.c, kSlack) << "N" << end.n;
    EXPECT_NEAR(last->end_work[3], end.c, kSlack) << "N" << end.n;
  }
}

TEST_F(Cylinder, ArcsStayOnTheirCirclesAndKeepTheFeed) {
  struct Circle {
    std::uint32_t n;
    double z, c, radius, sweep_deg;  // [computed] in examples E8
  };
  const Circle circles[] = {{6, 90.000, 30.002, 30, 90.003},
                            {8, 70.000, 69.999, 10, 90.003},
                            {10, 134.958, 152.512, 75, 31.911},
                            {12, 45.042, 267.488, 75, 31.911}};
  for (const Circle& circle : circles) {
    AxisVector before{};
    double worst = 0, minutes = 0;
    int pieces = 0;
    for (const Operation& operation : made) {
      const auto* feed = std::get_if<Feed>(&operation);
      if (feed != nullptr && feed->at.sequence == circle.n) {
        ++pieces;
        each_point(before, feed->end_machine, [&](const AxisVector& p) {
          const Point flat{p[2], p[3] * kDegree * kRadius}, center{circle.z, circle.c * kDegree * kRadius};
          worst = std::max(worst, std::fabs(distance(flat, center) - circle.radius));
        });
        double squares = 0;
        for (std::size_t i = 0; i < 8; ++i) squares += std::pow(feed->end_machine[i] - before[i], 2);
        minutes += std::sqrt(squares) / feed->feed;
      }
      if (const Motion* m = motion_of(operation)) before = m->end_machine;
    }
    EXPECT_GT(pieces, 5) << "N" << circle.n;
    EXPECT_LT(pieces, 400) << "N" << circle.n;
    EXPECT_LT(worst, kSurfaceTolerance_mm + 0.001) << "N" << circle.n;  // centres are given to 0.001
    EXPECT_NEAR(minutes * 250, circle.radius * circle.sweep_deg * kDegree, 0.01) << "N" << circle.n;
  }
}

TEST(CylinderRules, WhatMayNotBeCommanded) {
  const auto alarm = [](const std::string& text) {
    Bench bench("fanuc-0i-m", "C");
    bench.data.parameters["1022/C"] = 5;
    return alarm_of(bench.run(text + "\nM30\n"));
  };
  EXPECT_EQ(alarm("G00 X1.\nG07.1 C10."), "PS0176");            // in the G00 state
  EXPECT_EQ(alarm("G01 F100\nG07.1 X10."), "PS0175");           // not a rotary axis
  EXPECT_EQ(alarm("G01 F100\nG07.1 C10. X1."), "PS0175");       // two axes
  EXPECT_EQ(alarm("G01 F100\nG07.1 C10.\nG00 C5."), "PS0176");  // positioning
  EXPECT_EQ(alarm("G01 F100\nG07.1 C10.\nG28 Z0"), "PS0176");
  EXPECT_EQ(alarm("G01 F100\nG07.1 C10.\nG54"), "PS0176");
  EXPECT_EQ(alarm("G01 F100\nG07.1 C10.\nG07.1 C20."), "PS0176");  // again without cancelling
  EXPECT_EQ(alarm("G01 F100\nG18 Z0 C0\nG07.1 C10.\nG02 Z5. C5. K1."), "PS0176");
  EXPECT_EQ(alarm("G17 G01 F100\nG07.1 C10.\nG02 X5. Y5. R5."), "PS0175");  // the plane has no rotary axis
}

class Polar : public testing::Test {
 protected:
  Bench bench{"fanuc-0i-t", "C"};  // axes X Z C
  static constexpr std::size_t kX = 0, kC = 2;
  static Point flat(const AxisVector& p) {
    return {p[kX] * std::cos(p[kC] * kDegree), p[kX] * std::sin(p[kC] * kDegree)};
  }
};

TEST_F(Polar, LinesAndArcsOfAContour) {
  // X by diameter, C in mm: a square of 40 with one rounded corner, begun at X40 on the side of it.
  const auto made = bench.run(
      "G98 G00 X80. C0\nG12.1\nG01 X40. F100\nC10.\nG03 X20. C20. R10.\nG01 X-40.\nC-20.\nX40.\nC0\nG01 "
      "X80.\nG13.1\n"
      "G00 C400.\nM30\n");
  ASSERT_EQ(alarm_of(made), "");
  struct Way {
    std::uint32_t line;
    Point from, to;
    double length;
  };
  const Way ways[] = {{3, {40, 0}, {20, 0}, 20},
                      {4, {20, 0}, {20, 10}, 10},
                      {5, {20, 10}, {10, 20}, 10 * std::numbers::pi / 2},
                      {6, {10, 20}, {-20, 20}, 30},
                      {7, {-20, 20}, {-20, -20}, 40},
                      {8, {-20, -20}, {20, -20}, 40},
                      {9, {20, -20}, {20, 0}, 20}};
  AxisVector before{};
  std::size_t way = 0;
  double minutes = 0, worst = 0;
  for (const Operation& operation : made) {
    const Motion* m = motion_of(operation);
    if (m == nullptr) continue;
    const auto* feed = std::get_if<Feed>(&operation);
    if (feed != nullptr && way < std::size(ways) && feed->at.line == ways[way].line) {
      each_point(before, feed->end_machine, [&](const AxisVector& p) {
        const double off = ways[way].line == 5 ? std::fabs(distance(flat(p), {10, 10}) - 10)
                                               : from_line(flat(p), ways[way].from, ways[way].to);
        worst = std::max(worst, off);
      });
      minutes += std::sqrt(std::pow(feed->end_machine[kX] - before[kX], 2) +
                           std::pow(feed->end_machine[kC] - before[kC], 2)) /
                 feed->feed;
      if (distance(flat(feed->end_machine), ways[way].to) < 1e-6) {
        EXPECT_NEAR(minutes * 100, ways[way].length, 0.01) << "line " << ways[way].line;
        ++way;
        minutes = 0;
      }
    }
    before = m->end_machine;
  }
  EXPECT_EQ(way, std::size(ways));
  EXPECT_LT(worst, kSurfaceTolerance_mm + kSlack);
  // Once round: C stands at 360 and the next command goes on from there, not back a turn.
  double last_cut = 0, last = 0;
  for (const Operation& operation : made) {
    if (const auto* feed = std::get_if<Feed>(&operation)) last_cut = feed->end_machine[kC];
    if (const Motion* m = motion_of(operation)) last = m->end_machine[kC];
  }
  EXPECT_NEAR(last_cut, 360, kSlack);
  EXPECT_NEAR(last, 400, kSlack);
}

TEST_F(Polar, ALineThroughThePoleTurnsTheAxisOnTheSpot) {
  const auto made = bench.run("G98 G00 X20. C0\nG12.1\nG01 X-20. F100\nG13.1\nM30\n");
  ASSERT_EQ(alarm_of(made), "");
  double smallest = 10, last_x = 0, last_c = 0;
  std::size_t pieces = 0;
  for (const Operation& operation : made) {
    const auto* feed = std::get_if<Feed>(&operation);
    if (feed == nullptr) continue;
    ++pieces;
    EXPECT_GE(feed->end_machine[kX], -1e-6);  // the slide never crosses the centre
    smallest = std::min(smallest, feed->end_machine[kX]);
    last_x = feed->end_machine[kX];
    last_c = feed->end_machine[kC];
  }
  EXPECT_LT(smallest, 0.001);
  EXPECT_LT(pieces, 200u);
  EXPECT_NEAR(last_x, 10, kSlack);
  EXPECT_NEAR(std::fabs(last_c), 180, kSlack);
}

TEST_F(Polar, GoesOnFromWhereTheOperatorLeftTheAxes) {
  bench.interpreter.start(
      program::source_from_text("G98 G00 X40. C0\nG12.1\nG01 C20. F100\nX0 C20.\nG13.1\nM30\n"), {});
  Operation operation;
  for (;;) {
    ASSERT_EQ(bench.interpreter.next(operation), Pull::operation);
    if (const Motion* m = motion_of(operation); m != nullptr && m->at.line == 3) break;
  }
  AxisVector moved{};
  moved[kX] = 30;
  moved[kC] = 90;  // in the plane: (0, 30)
  bench.interpreter.set_position(moved);
  const auto made = bench.rest();
  const Motion* last = nullptr;
  for (const Operation& one : made) {
    if (const Motion* m = motion_of(one)) last = m;
  }
  ASSERT_NE(last, nullptr);
  EXPECT_NEAR(last->end_machine[kX], 20, kSlack);  // (0, 20)
  EXPECT_NEAR(last->end_machine[kC], 90, kSlack);
}

TEST(PolarRules, WhatMayNotBeCommanded) {
  const auto alarm = [](const std::string& text, std::string_view axes = "C") {
    Bench bench("fanuc-0i-t", axes);
    return alarm_of(bench.run("G98 G00 X40.\n" + text + "\nM30\n"));
  };
  EXPECT_EQ(alarm("G12.1", ""), "PS0145");  // no rotary axis
  EXPECT_EQ(alarm("G12.1\nG00 X10."), "PS0146");
  EXPECT_EQ(alarm("G12.1\nX10."), "PS0146");  // the G00 state
  EXPECT_EQ(alarm("G12.1\nG28 U0"), "PS0146");
  EXPECT_EQ(alarm("G12.1\nG50 X0"), "PS0146");
  EXPECT_EQ(alarm("G12.1\nG12.1"), "PS0146");
  EXPECT_EQ(alarm("G12.1\nT0101"), "PS0146");
  EXPECT_EQ(alarm("G12.1\nG01 X20. C5. F50\nG04 P100\nG13.1\nG00 X50."), "");
}

}  // namespace
}  // namespace headstock::interp

// The spline by itself: no jump of its second derivative and no interval out of proportion, whatever the
// lengths.
#include "motion/smoothing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

namespace headstock::motion {
namespace {

class Path {
 public:
  Path() { smoother_.reset(0); }
  void line(double x, double y) {
    Move move;
    move.geometry = Line{{x, y}};
    Piece piece;
    piece.curve = Curve::from(at_, move, 2);
    piece.begin = length_;
    piece.end = length_ += piece.curve.length;
    piece.tolerance = 0.01;
    at_ = piece.curve.end;
    smoother_.add(piece);
  }
  void forward(double length, double turn) {
    heading_ += turn;
    line(at_[0] + length * std::cos(heading_), at_[1] + length * std::sin(heading_));
  }
  std::vector<Span> spans() {
    smoother_.stop_at_end();
    std::vector<Span> all;
    for (Span span; smoother_.next(span);) all.push_back(span);
    return all;
  }

 private:
  Smoother smoother_{2};
  AxisVector at_{};
  double length_ = 0, heading_ = 0;
};

void expect_smooth(const std::vector<Span>& spans, const std::string& what) {
  ASSERT_FALSE(spans.empty());
  for (std::size_t k = 0; k + 1 < spans.size(); ++k) {
    const Span &a = spans[k], &b = spans[k + 1];
    const double h = a.end - a.begin;
    EXPECT_EQ(a.end, b.begin) << what;
    EXPECT_GT(h, 1e-6) << what;
    for (std::size_t i = 0; i < 2; ++i) {
      const double before = 2 * a.c[2][i] + 6 * a.c[3][i] * h, after = 2 * b.c[2][i];
      EXPECT_NEAR(before, after, 1e-3 + 1e-6 * std::abs(after)) << what << " at " << a.end;
    }
  }
}

// The allowed distance of knots is often a multiple of a neighbour's length: a knot that falls on the end of
// a line, but for rounding, must not become a second one there.
TEST(Smoothing, LinesOfExactlyTheAllowedLengthHaveNoDoubleKnot) {
  for (const double unit : {0.1, 0.32, 0.3235799746589, 0.7, 1.0 / 3}) {
    for (int whole = 0; whole < 40; ++whole) {  // where along the path it is decides how the sums are rounded
      Path path;
      for (int i = 0; i < whole; ++i) path.forward(1.7 * unit, i % 2 ? 0.3 : -0.3);
      for (const double times : {1.0, 1.0, 2.0, 1.5, 1.0, 2.0, 4.0, 1.0}) path.forward(times * unit, 0.02);
      expect_smooth(path.spans(), std::to_string(unit) + " behind " + std::to_string(whole));
    }
  }
}

TEST(Smoothing, SecondDerivativeIsContinuousOnRandomPolylines) {
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> one(-1, 1);
  for (int round = 0; round < 300; ++round) {
    Path path;
    const double unit = std::pow(10.0, 1.5 * one(generator) - 0.5);
    for (int i = 0; i < 60; ++i) {
      const double times = static_cast<double>(1 + generator() % 4);  // multiples of one length, on purpose
      path.forward(unit * times, (generator() % 4 == 0 ? 1.5 : 0.1) * one(generator));
    }
    expect_smooth(path.spans(), std::to_string(round));
  }
}

}  // namespace
}  // namespace headstock::motion

// Short segments flow: what a CAM program is cut into, and rounded to, must not show in speed or
// acceleration.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "rig.hpp"

namespace headstock::motion {
namespace {

constexpr double kCircle_mm = 30, kFlow_mm_s = 100;
constexpr double kFlowJerks[] = {50'000, 500'000, 1e12};

std::vector<Move> chords_of_a_circle() {
  std::vector<Move> moves;
  const int count = static_cast<int>(2 * M_PI * kCircle_mm / 0.1);
  for (int i = 1; i <= count; ++i) {
    const double angle = 2 * M_PI * i / count;
    moves.push_back(
        rig::line({kCircle_mm * std::cos(angle) - kCircle_mm, kCircle_mm * std::sin(angle)}, kFlow_mm_s));
    moves.back().tag = moves.size();
  }
  return moves;
}

/// One pass over the wavy surface of the benchmark; numbers rounded to `grid_mm`.
std::vector<Move> wave(double grid_mm) {
  std::vector<Move> moves;
  for (int i = 1; i <= 400; ++i) {
    const double x = 0.1 * i, z = 2 * std::sin(0.8 * x);
    moves.push_back(rig::line({x, std::round(z / grid_mm) * grid_mm}, kFlow_mm_s));
    moves.back().tag = moves.size();
  }
  return moves;
}

rig::Run flowing(const machine::Machine& machine, const std::vector<Move>& moves, double feed_override = 1) {
  rig::Options options;
  options.overrides = [=](std::size_t) {
    Overrides overrides;
    overrides.feed = feed_override;
    return overrides;
  };
  auto kernel = std::make_unique<Kernel>(machine);
  auto run = rig::run(*kernel, machine, moves, options);
  EXPECT_TRUE(run.finished);
  EXPECT_EQ(rig::violations(machine, run), "");
  EXPECT_LE(run.path_error, 0.01);
  return run;
}

double distance_to_chord(const AxisVector& p, const AxisVector& a, const AxisVector& b) {
  const double x = b[0] - a[0], y = b[1] - a[1], square = x * x + y * y;
  const double share =
      square > 0 ? std::clamp(((p[0] - a[0]) * x + (p[1] - a[1]) * y) / square, 0.0, 1.0) : 0;
  return std::hypot(p[0] - a[0] - share * x, p[1] - a[1] - share * y);
}

TEST(Flow, SpeedRipplesOnePercentAtMostOnChordsOfACircle) {
  for (const double jerk : kFlowJerks) {
    const auto run = flowing(rig::machine(2, 500, 2000, jerk), chords_of_a_circle());
    double slowest = kFlow_mm_s, fastest = 0;
    for (std::size_t i = run.samples.size() / 8; i < 7 * run.samples.size() / 8; ++i) {
      slowest = std::min(slowest, run.samples[i].path_speed_mm_s);
      fastest = std::max(fastest, run.samples[i].path_speed_mm_s);
    }
    EXPECT_LE(fastest, 1.01 * slowest) << jerk;
    EXPECT_GT(slowest, 0.99 * kFlow_mm_s) << jerk;
  }
}

TEST(Flow, AccelerationDoesNotReturnToZeroAtJunctions) {
  for (const double jerk : kFlowJerks) {
    const auto run = flowing(rig::machine(2, 500, 2000, jerk), chords_of_a_circle());
    const double of_the_circle = kFlow_mm_s * kFlow_mm_s / kCircle_mm;
    for (std::size_t i = run.samples.size() / 8; i < 7 * run.samples.size() / 8; ++i) {
      const auto& p = run.samples;
      double square = 0;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double second = p[i + 1].position[axis] - 2 * p[i].position[axis] + p[i - 1].position[axis];
        square += second * second * 1e12;
      }
      EXPECT_NEAR(std::sqrt(square), of_the_circle, 0.05 * of_the_circle) << jerk << " in period " << i;
    }
  }
}

TEST(Flow, ThePathIsTheSameAtEveryOverride) {
  const auto machine = rig::machine(2, 500, 2000, 500'000);
  for (const auto& moves : {chords_of_a_circle(), wave(0.001)}) {
    const auto slow = flowing(machine, moves, 0.1).samples;  // 0.01 mm a period: its chords leave out 2e-5 mm
    for (const double feed : {0.3, 0.75, 1.0, 1.5, 2.54}) {
      std::size_t at = 0;
      double farthest = 0;
      for (const Sample& sample : flowing(machine, moves, feed).samples) {
        double nearest = 1;
        for (std::size_t k = at; k + 1 < slow.size() && k < at + 100; ++k) {
          const double off = distance_to_chord(sample.position, slow[k].position, slow[k + 1].position);
          if (off >= nearest) continue;
          nearest = off;
          at = k;
        }
        farthest = std::max(farthest, nearest);
      }
      EXPECT_LT(farthest, 2e-5) << feed;
    }
  }
}

TEST(Flow, MoreThanTwoThousandSegmentsAreLookedAhead) {
  // In the middle of a long run of segments the axes go as fast as they can still be stopped from inside what is known.
  constexpr double kSegment_mm = 0.01, kRadius_mm = 1000, kAcceleration_mm_s2 = 2000;
  constexpr int kSegments = 12'000, kAhead = 2'000;
  std::vector<Move> moves;
  for (int i = 1; i <= kSegments; ++i) {
    const double angle = kSegment_mm * i / kRadius_mm;
    moves.push_back(rig::line({kRadius_mm * std::sin(angle), kRadius_mm * (1 - std::cos(angle))}, 450));
    moves.back().tag = moves.size();
  }
  for (const double jerk : {500'000.0, 1e12}) {
    const rig::Run run = flowing(rig::machine(2, 500, kAcceleration_mm_s2, jerk), moves);
    double fastest = 0;
    for (const Sample& sample : run.samples) fastest = std::max(fastest, sample.path_speed_mm_s);
    EXPECT_GT(fastest, std::sqrt(2 * kAcceleration_mm_s2 * kAhead * kSegment_mm)) << jerk;
  }
}

TEST(Flow, SharpCornersTakeAsLongAtEveryPeriod) {
  // What a corner costs does not come in whole periods.
  std::vector<Move> moves;
  for (int i = 1; i <= 400; ++i) {
    moves.push_back(rig::line({0.25 * i, i % 2 ? 0.1 : 0.0}, kFlow_mm_s));
    moves.back().tag = moves.size();
  }
  const auto time_at = [&](unsigned period_us) {
    auto machine = rig::machine(2, 500, 2000, 1e12);
    machine.period_us = period_us;
    return flowing(machine, moves).time_s;
  };
  const double fine = time_at(250);
  for (const unsigned period_us : {500u, 1000u, 4000u, 8000u})
    EXPECT_NEAR(time_at(period_us), fine, 0.002 * fine + 2e-6 * period_us) << period_us;
}

TEST(Flow, RoundingTheProgramToMicrometresCostsNoTime) {
  for (const double jerk : kFlowJerks) {
    const auto machine = rig::machine(2, 500, 2000, jerk);
    EXPECT_LT(flowing(machine, wave(0.001)).time_s, 1.03 * flowing(machine, wave(1e-9)).time_s) << jerk;
  }
}

}  // namespace
}  // namespace headstock::motion

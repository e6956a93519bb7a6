// Positioning that is not interpolated: what the axes do by themselves, as one path.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"
#include "motion/path_error.hpp"
#include "operation/free_path.hpp"

namespace headstock::operation {
namespace {

TEST(FreePath, AnAxisGoesFromRestToRestAtItsOwnRateAndAcceleration) {
  const AxisCourse whole{-100, 200, 1000};  // 20 mm each to speed up and to brake
  EXPECT_NEAR(whole.time_s(), 0.7, 1e-12);
  EXPECT_NEAR(whole.at(0.1), -5, 1e-12);
  EXPECT_NEAR(whole.at(0.35), -50, 1e-12);
  EXPECT_NEAR(whole.at(0.6), -95, 1e-12);
  EXPECT_EQ(whole.at(2), -100);
  const AxisCourse near{10, 200, 1000};
  EXPECT_NEAR(near.time_s(), 0.2, 1e-12);
  EXPECT_NEAR(near.at(0.1), 5, 1e-12);
  EXPECT_EQ((AxisCourse{0, 200, 1000}).at(0), 0);
}

TEST(FreePath, IsOnePieceWhereTheAxesArriveTogether) {
  const std::vector<AxisCourse> together{{30, 200, 1000}, {-30, 200, 1000}}, one{{30, 200, 1000}, {0, 100, 500}};
  EXPECT_EQ(free_path({}, together).size(), 1u);
  ASSERT_EQ(free_path({5, 7}, one).size(), 1u);
  EXPECT_EQ(free_path({5, 7}, one)[0], (machine::AxisVector{35, 7}));
}

TEST(FreePath, LiesWhereTheAxesAreAtTheSameTime) {
  const machine::AxisVector from{10, -4, 3};
  const std::vector<AxisCourse> courses{{60, 400, 2000}, {-20, 200, 2000}, {35, 300, 700}};
  const auto corners = free_path(from, courses);
  ASSERT_GT(corners.size(), 5u);
  EXPECT_EQ(corners.back(), (machine::AxisVector{70, -24, 38}));
  double before_s = 0;
  for (const auto& corner : corners) {
    // X is the time; where it stands, the last one to arrive is Z.
    double least_s = before_s, most_s = 2;
    while (most_s - least_s > 1e-12) {
      const double middle = 0.5 * (least_s + most_s);
      (courses[2].at(middle) < corner[2] - from[2] ? least_s : most_s) = middle;
    }
    for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(corner[i], from[i] + courses[i].at(most_s), 1e-5) << i;
    EXPECT_GT(most_s, before_s);
    before_s = most_s;
  }
}

/// @return how long the mill takes from start to end
double takes_s(const std::string& program) {
  Bench bench("fanuc-0i-m");
  bench.controller.edit_data([](interp::MachineData& data) { data.parameters["1401#1"] = 0; }, {}, "test");
  bench.load("O1\nG90 G94 G21\n" + program + "M30\n");
  EXPECT_TRUE(bench.start());
  EXPECT_TRUE(bench.until_state(State::idle, 120));
  return static_cast<double>(bench.periods) * bench.controller.machine().period_us * 1e-6;
}

// No axis waits for another: it takes what the slowest takes alone.
TEST(FreePath, TakesAsLongAsTheSlowestAxis) {
  std::string alone, both;
  for (int i = 0; i < 10; ++i) {
    const std::string x = i % 2 ? "0" : "60.", y = i % 2 ? "0" : "25.";
    alone += "G00 X" + x + "\n";
    both += "G00 X" + x + " Y" + y + "\n";
  }
  const double start_s = takes_s("G00 X0\n");
  const double alone_s = takes_s(alone) - start_s, both_s = takes_s(both) - start_s;
  EXPECT_GT(both_s, 0.995 * alone_s);
  EXPECT_LT(both_s, 1.03 * alone_s);
}

// One positioning is many moves: what the kernel still has to trace is not written over when its queue is full.
TEST(FreePath, AFullQueueKeepsThePath) {
  Bench bench("fanuc-0i-m");
  std::string program = "O1\nG90 G94 G21\nF30000\n";
  for (int i = 0; i < 6'000; ++i) {
    const bool positioning = i % 300 == 150;
    program += positioning ? "G00 X90. Y40.\n"
                           : "G01 X" + std::to_string(0.2 * (i % 300)) + " Y" + std::to_string(0.1 * (i % 7)) + "\n";
  }
  bench.load(program + "M30\n");
  motion::PathError error(bench.controller.machine().axes.size());
  error.start(bench.controller.sample().position);
  bench.controller.on_move([&](const motion::Move& move) { error.add(move); });
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until(
      [&] {
        const motion::Sample& sample = bench.controller.sample();
        if (sample.moving) error.judge(sample.position, sample.tag);
        return bench.state() == State::idle;
      },
      600));
  EXPECT_LE(error.max(), 0.01);
}

}  // namespace
}  // namespace headstock::operation

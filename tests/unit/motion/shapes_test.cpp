// How moves speed up and slow down by a shape: the bell before interpolation, filters of the axes behind it.
// Figures worked out by hand, the limits of every sample, and that nothing else of the kernel changes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>

#include "motion/axis_filter.hpp"
#include "random_programs.hpp"
#include "rig.hpp"

namespace headstock::motion {
namespace {

constexpr double kPeriod_s = 0.001;

AccelerationShape linear(double time_s, double bell_s = 0) {
  AccelerationShape shape;
  shape.after = FilterShape::linear;
  shape.after_s.fill(time_s);
  shape.after_bell_s.fill(bell_s);
  return shape;
}
AccelerationShape exponential(double time_s) {
  AccelerationShape shape;
  shape.after = FilterShape::exponential;
  shape.after_s.fill(time_s);
  return shape;
}
AccelerationShape bell(double time_s) {
  AccelerationShape shape;
  shape.bell_s = time_s;
  return shape;
}

const AccelerationShape kEveryShape[] = {linear(0.064),     linear(0.05, 0.03), linear(0.001),
                                         exponential(0.06), exponential(0.008), bell(0.05),
                                         bell(0.2)};

std::unique_ptr<Kernel> kernel_with(const machine::Machine& machine, const AccelerationShape& shape) {
  auto kernel = std::make_unique<Kernel>(machine);
  kernel->set_shapes({AccelerationShape{}, shape});
  return kernel;
}

std::vector<Move> shaped(std::vector<Move> moves) {
  for (std::size_t i = 0; i < moves.size(); ++i) {
    moves[i].tag = i + 1;
    moves[i].shape = 1;
  }
  return moves;
}

double off_by(const AxisVector& a, const AxisVector& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

rig::Run run_shaped(const machine::Machine& machine, const std::vector<Move>& moves,
                    const AccelerationShape& shape, const rig::Options& options = {}) {
  return rig::run(*kernel_with(machine, shape), machine, shaped(moves), options);
}

// ---- the filter alone: what comes in moves at 100 mm/s from one period to the next

struct Ramp {
  double highest = 0;         ///< mm/s²
  double after_63_s = 0;      ///< from when 63.2 % of the speed is reached
  double full_s = 0;          ///< all of it
  double lag_mm = 0;          ///< at constant speed
  double stops_within_s = 0;  ///< from when nothing comes in any more
  bool exact = false;
};

Ramp ramp_of(const AccelerationShape& shape) {
  AxisVector jerk{};
  jerk.fill(50'000);
  AxisFilter filter(1, kPeriod_s, jerk);
  filter.set(shape, {}, 0, 0);
  Ramp ramp;
  double x = 0, before = 0, speed_before = 0;
  const auto step = [&](double speed) {
    x += speed * kPeriod_s;
    const double out = filter.step({x}, x)[0];
    const double now = (out - before) / kPeriod_s;
    before = out;
    ramp.highest = std::max(ramp.highest, std::abs(now - speed_before) / kPeriod_s);
    speed_before = now;
    return now;
  };
  EXPECT_TRUE(filter.empty());
  for (int i = 1; i <= 3000; ++i) {
    const double now = step(100);
    if (ramp.after_63_s == 0 && now > 63.2) ramp.after_63_s = i * kPeriod_s;
    if (ramp.full_s == 0 && now > 100 - 1e-6) ramp.full_s = i * kPeriod_s;
    EXPECT_FALSE(filter.empty());
  }
  ramp.lag_mm = x - before;
  EXPECT_NEAR(filter.lag_s(), ramp.lag_mm / 100, 1e-9);
  for (int i = 1; i <= 3000 && !filter.empty(); ++i) {
    step(0);
    ramp.stops_within_s = i * kPeriod_s;
  }
  EXPECT_TRUE(filter.empty());
  ramp.exact = before == x && filter.length() == x;
  for (int i = 0; i < 10; ++i) EXPECT_EQ(step(0), 0) << "and stays";
  return ramp;
}

TEST(AxisFilter, LinearIsAnEvenRampOfItsTime) {
  const Ramp ramp = ramp_of(linear(0.1));
  EXPECT_NEAR(ramp.highest, 1000, 0.01);  // 100 mm/s in 0.1 s
  EXPECT_NEAR(ramp.full_s, 0.1, 1e-9);
  EXPECT_NEAR(ramp.lag_mm, 100 * 0.0495, 1e-6);  // half of its time, less half a period
  EXPECT_LE(ramp.stops_within_s, 0.1);
  EXPECT_TRUE(ramp.exact);
}

TEST(AxisFilter, BellTakesBothTimes) {
  const Ramp ramp = ramp_of(linear(0.06, 0.04));
  EXPECT_NEAR(ramp.highest, 100 / 0.06, 0.01);
  EXPECT_NEAR(ramp.full_s, 0.1, 1e-9);
  EXPECT_TRUE(ramp.exact);
  const Ramp even = ramp_of(linear(0.05, 0.05));
  EXPECT_NEAR(even.highest, 2000, 2000 * 0.03);  // a triangle of acceleration
  EXPECT_NEAR(even.full_s, 0.1, 1e-9);
}

TEST(AxisFilter, ExponentialHasDone63PercentInItsTimeAndEnds) {
  const Ramp ramp = ramp_of(exponential(0.1));
  EXPECT_NEAR(ramp.highest, 1000, 10);  // its beginning is that of the linear one
  EXPECT_NEAR(ramp.after_63_s, 0.1, 0.0011);
  EXPECT_NEAR(ramp.lag_mm, 100 * 0.0995, 0.001);
  EXPECT_LT(ramp.stops_within_s, 0.1 * 12) << "it does not creep for ever";
  EXPECT_TRUE(ramp.exact);
}

// ---- in the kernel

TEST(Shapes, LimitsHoldAndTheEndIsExactOnRandomPrograms) {
  for (unsigned seed = 0; seed < 16; ++seed) {
    const auto machine = rig::machine(3, 300, 2000, seed % 3 == 0 ? 1e12 : seed % 3 == 1 ? 500'000 : 50'000);
    const auto moves = rig::random_program(seed, 40);
    const AccelerationShape& shape = kEveryShape[seed % std::size(kEveryShape)];
    const auto run = run_shaped(machine, moves, shape);
    EXPECT_TRUE(run.finished) << seed;
    EXPECT_EQ(rig::violations(machine, run), "") << seed;
    EXPECT_EQ(run.samples.back().position, rig::end_of(moves.back())) << seed;
    if (shape.bell_s > 0) {
      EXPECT_LE(run.path_error, moves[0].tolerance_mm) << seed;
    }
  }
}

TEST(Shapes, LimitsHoldWhateverTheOperatorDoes) {
  for (unsigned seed = 100; seed < 114; ++seed) {
    const auto machine = rig::machine(3, 300, 2000, seed % 2 ? 500'000 : 50'000);
    const auto moves = rig::random_program(seed, 30);
    std::mt19937 generator(seed);
    Overrides now;
    rig::Options options;
    options.overrides = [&](std::size_t) {
      if (generator() % 40 == 0) {
        now.hold = generator() % 4 == 0;
        now.feed = static_cast<double>(generator() % 255) / 100;
        now.single_block = generator() % 3 == 0;
        now.in_position = generator() % 4 != 0;
      }
      if (generator() % 60 == 0) ++now.go;
      return now;
    };
    const auto run = run_shaped(machine, moves, kEveryShape[seed % std::size(kEveryShape)], options);
    EXPECT_TRUE(run.finished) << seed;
    EXPECT_EQ(rig::violations(machine, run), "") << seed;
    EXPECT_EQ(run.samples.back().position, rig::end_of(moves.back())) << seed;
  }
}

TEST(Shapes, ABellBeforeInterpolationTakesItsTimeAndKeepsThePath) {
  const auto machine = rig::machine(2, 500, 1000, 1e12);
  std::vector<Move> moves{rig::line({100, 0}, 100)};
  const auto run = run_shaped(machine, moves, bell(0.05));
  // 100 mm/s at 1000 mm/s²: 0.1 s, and 0.05 s for the acceleration to rise and fall; jerk 1000 / 0.05.
  EXPECT_NEAR(run.acceleration[0], 1000, 10);
  EXPECT_NEAR(run.jerk[0], 20'000, 600);
  EXPECT_NEAR(run.time_s, 1 + 0.1 + 0.05, 0.012);
  // Corners and curves stay inside the tolerance.
  for (unsigned seed = 200; seed < 208; ++seed) {
    const auto program = rig::random_program(seed, 40);
    const auto bent = run_shaped(rig::machine(3, 300, 2000, 500'000), program, bell(0.064));
    EXPECT_LE(bent.path_error, program[0].tolerance_mm) << seed;
    EXPECT_EQ(rig::violations(rig::machine(3, 300, 2000, 500'000), bent), "") << seed;
  }
}

std::vector<Move> circles(double radius, double speed, double turns) {
  Move move;
  Arc arc;
  arc.center_1 = -radius;
  arc.end = {0, 0};
  arc.angle_rad = 2 * M_PI * turns;
  move.geometry = arc;
  move.feed = PathFeed{speed};
  return {move};
}

TEST(Shapes, ACircleBecomesSmallerAsOnTheRealControl) {
  const auto machine = rig::machine(2, 500, 2000, 1e12);
  const double v = 100, r = 20;
  const auto smaller_by = [&](const AccelerationShape& shape) {
    const auto run = run_shaped(machine, circles(r, v, 4), shape);
    const AxisVector at = run.samples[run.samples.size() / 2].position;
    EXPECT_TRUE(run.finished);
    return r - std::hypot(at[0] + r, at[1]);
  };
  EXPECT_NEAR(smaller_by(linear(0.1)), v * v * 0.1 * 0.1 / (24 * r), 0.01);
  EXPECT_NEAR(smaller_by(exponential(0.03)), v * v * 0.03 * 0.03 / (2 * r), 0.01);
  EXPECT_NEAR(smaller_by(bell(0.05)), 0, 1e-4) << "before interpolation nothing changes";
}

TEST(Shapes, AnExactStopIsReachedThroughTheFilter) {
  const auto machine = rig::machine(2, 500, 2000, 500'000);
  for (const AccelerationShape& shape : kEveryShape) {
    for (const bool exact : {true, false}) {
      std::vector<Move> moves{rig::line({20, 0}, 100), rig::line({20, 20}, 100)};
      moves[0].exact_stop = exact;
      const auto run = run_shaped(machine, moves, shape);
      double nearest = 1e9;
      for (const Sample& sample : run.samples) nearest = std::min(nearest, off_by(sample.position, {20, 0}));
      if (exact) {
        EXPECT_EQ(nearest, 0);
      } else {
        EXPECT_GT(nearest, 0);
        EXPECT_LT(nearest, 100 * 0.12) << "less than the axes lag";
      }
    }
  }
}

TEST(Shapes, BetweenTwoShapesTheAxesStop) {
  const auto machine = rig::machine(2, 500, 2000, 500'000);
  std::vector<Move> moves = shaped({rig::line({20, 0}, 100), rig::line({20, 20}, 100)});
  moves[1].shape = 2;
  auto kernel = std::make_unique<Kernel>(machine);
  kernel->set_shapes({AccelerationShape{}, linear(0.1), exponential(0.03)});
  const auto run = rig::run(*kernel, machine, moves);
  double nearest = 1e9, up = 0, before = 0;
  for (const Sample& sample : run.samples) {
    nearest = std::min(nearest, off_by(sample.position, {20, 0}));
    if (sample.tag == 1) up = std::max(up, (sample.path_speed_mm_s - before) / kPeriod_s);
    before = sample.path_speed_mm_s;
  }
  EXPECT_EQ(nearest, 0);
  EXPECT_NEAR(up, 1000, 20) << "the first by its own";
  EXPECT_EQ(run.samples.back().position[1], 20);
}

// What is shown is what moves: the tag is that of the block the axes are in, not of the one that is
// calculated.
TEST(Shapes, TheTagIsThatOfTheMoveTheAxesAreIn) {
  const auto machine = rig::machine(2, 500, 2000, 500'000);
  std::vector<Move> moves{rig::line({20, 0}, 100), rig::line({40, 0}, 100), rig::line({40, 20}, 50)};
  moves[1].exact_stop = true;
  for (const AccelerationShape& shape : kEveryShape) {
    const auto run = run_shaped(machine, moves, shape);
    for (const Sample& sample : run.samples) {
      const double along = sample.position[0] + sample.position[1];
      const std::uint64_t wanted = along < 20 ? 1 : along < 40 ? 2 : 3;
      // At an exact place either may be shown.
      if (std::abs(along - 20) > 0.11 && std::abs(along - 40) > 1e-6 && sample.moving) {
        ASSERT_EQ(sample.tag, wanted) << along;
      }
    }
  }
}

TEST(Shapes, AnAbortStandsWhereItIsShown) {
  std::mt19937 generator(5);
  for (int round = 0; round < 60; ++round) {
    const auto seed = static_cast<unsigned>(generator() % 1000);
    const auto machine = rig::machine(3, 300, 2000, 500'000);
    const auto moves = shaped(rig::random_program(seed, 30));
    auto kernel = kernel_with(machine, kEveryShape[generator() % std::size(kEveryShape)]);
    const std::size_t periods = rig::run(*kernel, machine, moves).samples.size();
    kernel->set_position({});
    LimitsCheck limits(3, kPeriod_s);
    limits.add({});
    for (const Move& move : moves) kernel->push(move);
    kernel->finish();
    while (kernel->plan()) {
    }
    Sample shown;
    const std::size_t at = generator() % periods;
    for (std::size_t i = 0; i < at; ++i) limits.add((shown = kernel->step({}, 0, 0)).position);
    kernel->abort();
    for (int i = 0; i < 20'000 && !kernel->aborted(); ++i)
      limits.add((shown = kernel->step({}, 0, 0)).position);
    ASSERT_TRUE(kernel->aborted());
    rig::Run run;
    run.velocity = limits.max_velocity();
    run.acceleration = limits.max_acceleration();
    run.jerk = limits.max_jerk();
    EXPECT_EQ(rig::violations(machine, run), "") << seed << " at " << at;
    Overrides pressed;
    for (int i = 0; i < 50; ++i) {
      ++pressed.go;
      const Sample later = kernel->step(pressed, 0.1 * i, 1000);
      ASSERT_EQ(later.position, shown.position);
      ASSERT_FALSE(later.moving);
    }
  }
}

TEST(Shapes, ASkipLatchesWhereTheAxesAre) {
  const auto machine = rig::machine(2, 500, 2000, 500'000);
  std::vector<Move> moves = shaped({rig::line({50, 0}, 50)});
  moves[0].skip = moves[0].exact_stop = true;
  auto kernel = kernel_with(machine, linear(0.1));
  kernel->set_position({});
  kernel->push(moves[0]);
  kernel->finish();
  while (kernel->plan()) {
  }
  Sample sample;
  while (sample.position[0] < 20) sample = kernel->step({}, 0, 0);
  Overrides touched;
  touched.skip_signal = true;
  sample = kernel->step(touched, 0, 0);
  const double at = sample.position[0];
  EXPECT_TRUE(sample.skipped);
  EXPECT_EQ(sample.skip_position[0], at);
  for (int i = 0; i < 1000 && sample.moving; ++i) sample = kernel->step(touched, 0, 0);
  EXPECT_EQ(sample.skip_position[0], at);
  EXPECT_FALSE(sample.moving);
  // What was still in the filter, and the kernel's own way to rest: 50 mm/s × half of 0.1 s and 50² / 2 /
  // 2000.
  EXPECT_LT(sample.position[0] - at, 50 * 0.05 + 0.625 + 0.3);
}

TEST(Shapes, TheSameBitsInEveryRun) {
  const auto machine = rig::machine(3, 300, 2000, 500'000);
  const auto moves = shaped(rig::random_program(3, 40));
  for (const AccelerationShape& shape : kEveryShape) {
    auto kernel = kernel_with(machine, shape);
    const auto first = rig::run(*kernel, machine, moves);
    const auto again = rig::run(*kernel, machine, moves);
    ASSERT_EQ(first.samples.size(), again.samples.size());
    for (std::size_t i = 0; i < first.samples.size(); ++i)
      ASSERT_EQ(std::memcmp(&first.samples[i].position, &again.samples[i].position, sizeof(AxisVector)), 0);
  }
}

// A shape nobody asks for changes nothing.
TEST(Shapes, WithoutOneItIsThePathOfToday) {
  const auto machine = rig::machine(3, 300, 2000, 500'000);
  auto moves = shaped(rig::random_program(4, 40));
  const auto asked = rig::run(*kernel_with(machine, {}), machine, moves);
  for (Move& move : moves) move.shape = 0;
  auto kernel = std::make_unique<Kernel>(machine);
  const auto plain = rig::run(*kernel, machine, moves);
  ASSERT_EQ(asked.samples.size(), plain.samples.size());
  for (std::size_t i = 0; i < plain.samples.size(); ++i)
    ASSERT_EQ(std::memcmp(&asked.samples[i].position, &plain.samples[i].position, sizeof(AxisVector)), 0);
}

// The lag of the filter is known: the groove is where it would be without one.
TEST(Shapes, AThreadKeepsItsPhaseAndItsPitch) {
  const auto machine = rig::machine(2, 500, 2000, 500'000);
  for (const AccelerationShape& shape : kEveryShape) {
    for (const double rpm : {570.0, 600.0, 630.0}) {
      Move cut = rig::line({0, 60}, 0);
      cut.tag = cut.shape = 1;
      cut.feed = ThreadFeed{2.0, 0, 0.5};
      auto kernel = kernel_with(machine, shape);
      kernel->set_position({});
      kernel->push(cut);
      kernel->finish();
      while (kernel->plan()) {
      }
      double phase = 0.4, worst_rad = 0;
      int seen = 0;
      bool done = false;
      for (int i = 0; i < 20'000 && !done; ++i) {
        phase += rpm / 60 * kPeriod_s * 2 * M_PI;
        const Sample sample = kernel->step({}, phase, rpm);
        // Behind the run-in and before the run-out.
        if (sample.position[1] > 15 && sample.position[1] < 45) {
          const double groove = std::remainder(phase - sample.position[1] / 2.0 * 2 * M_PI - 0.5, 2 * M_PI);
          worst_rad = std::max(worst_rad, std::abs(groove));
          ++seen;
        }
        done = sample.queue_empty;
      }
      EXPECT_TRUE(done);
      EXPECT_GT(seen, 1000);
      EXPECT_LT(worst_rad, 0.1 * M_PI / 180) << rpm;
    }
  }
}

TEST(InPosition, AnExactStopWaitsForTheDrivesAndOthersDoNot) {
  const auto machine = rig::machine(2, 500, 2000, 500'000);
  std::vector<Move> moves{rig::line({20, 0}, 100), rig::line({40, 0}, 100), rig::line({20, 0}, 100)};
  moves[0].exact_stop =
      true;  // the reversal behind the second is a stop as well, but nobody has asked for it
  rig::Options options;
  bool held = false;
  AxisVector stood{};
  std::size_t standing = 0;
  options.overrides = [&](std::size_t) {
    Overrides now;
    now.in_position = standing > 200;
    return now;
  };
  options.watch = [&](const Sample& sample) {
    if (sample.moving || sample.position == AxisVector{}) return;
    if (standing == 0) stood = sample.position;
    held = held || standing > 100;
    standing += sample.position == stood;
  };
  auto kernel = std::make_unique<Kernel>(machine);
  for (std::size_t i = 0; i < moves.size(); ++i) moves[i].tag = i + 1;
  const auto run = rig::run(*kernel, machine, moves, options);
  EXPECT_TRUE(run.finished);
  EXPECT_TRUE(held);
  EXPECT_EQ(stood, (AxisVector{20, 0}));

  moves[0].exact_stop = false;
  options.overrides = [](std::size_t) {
    Overrides now;
    now.in_position = false;
    return now;
  };
  options.watch = nullptr;
  const auto through = rig::run(*kernel, machine, moves, options);
  EXPECT_TRUE(through.finished) << "no exact stop, no waiting";
}

}  // namespace
}  // namespace headstock::motion

#include "motion/kernel.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>

#include "rig.hpp"

namespace headstock::motion {
namespace {

using rig::line;

std::vector<Move> tagged(std::vector<Move> moves) {
  for (std::size_t i = 0; i < moves.size(); ++i) moves[i].tag = i + 1;
  return moves;
}

rig::Run traced(const machine::Machine& machine, const std::vector<Move>& moves,
                const rig::Options& options = {}) {
  auto kernel = std::make_unique<Kernel>(machine);
  return rig::run(*kernel, machine, tagged(moves), options);
}

double off(const AxisVector& a, const AxisVector& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

/// Bit for bit the same motion; when it begins depends on when the look-ahead was ready.
bool identical(const rig::Run& a, const rig::Run& b) {
  const auto begin = [](const rig::Run& run) {
    std::size_t i = 0;
    while (i < run.samples.size() && !run.samples[i].moving) ++i;
    return i;
  };
  const std::size_t from_a = begin(a), from_b = begin(b);
  if (a.samples.size() - from_a != b.samples.size() - from_b) return false;
  for (std::size_t i = 0; from_a + i < a.samples.size(); ++i)
    if (std::memcmp(&a.samples[from_a + i].position, &b.samples[from_b + i].position, sizeof(AxisVector)) !=
        0)
      return false;
  return true;
}

std::vector<Move> chords(double radius, double chord, double speed) {
  std::vector<Move> moves;
  const int n = static_cast<int>(2 * M_PI * radius / chord);
  for (int i = 1; i <= n; ++i)
    moves.push_back(
        line({radius * std::cos(2 * M_PI * i / n) - radius, radius * std::sin(2 * M_PI * i / n)}, speed));
  return moves;
}

/// Lines and arcs of lengths over five decades, exact stops, several feeds.
std::vector<Move> random_program(unsigned seed, std::size_t count) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> one(-1, 1);
  const double scale = std::pow(10.0, 2 * one(generator) - 0.5);
  std::vector<Move> moves;
  AxisVector p{};
  for (std::size_t i = 0; i < count; ++i) {
    double size = scale;
    if (seed % 4 == 1) size = std::pow(10.0, 2 * one(generator) - 1);
    if (seed % 4 == 2) size = generator() % 4 ? 0.1 : 5;
    Move move = line(p, 5 + 200 * std::abs(one(generator)));
    if (seed % 4 == 3 && generator() % 2) {
      Arc arc;
      const double x = one(generator) * size, y = one(generator) * size;
      arc.center_1 = p[0] - x;
      arc.center_2 = p[1] - y;
      arc.angle_rad = 7 * one(generator);
      p[0] = arc.center_1 + std::cos(arc.angle_rad) * x - std::sin(arc.angle_rad) * y;
      p[1] = arc.center_2 + std::sin(arc.angle_rad) * x + std::cos(arc.angle_rad) * y;
      if (generator() % 2) p[2] += one(generator) * size;
      arc.end = p;
      move.geometry = arc;
    } else {
      for (std::size_t k = 0; k < 3; ++k)
        if (generator() % 3) p[k] += one(generator) * size;
      move.geometry = Line{p};
    }
    move.exact_stop = generator() % 20 == 0;
    moves.push_back(move);
  }
  return moves;
}

machine::Machine uneven_machine(double jerk) {
  machine::Machine machine = rig::machine(3, 300, 2000, jerk);
  machine.axes[1].max_acceleration_mm_s2 = 700;
  machine.axes[2].max_jerk_mm_s3 = 0.3 * jerk;
  machine.axes[2].max_feed_mm_min = 3000;
  return machine;
}

void expect_good(const machine::Machine& machine, const rig::Run& run, const AxisVector& end,
                 const std::string& what) {
  EXPECT_TRUE(run.finished) << what;
  EXPECT_EQ(rig::violations(machine, run), "") << what;
  EXPECT_LE(run.path_error, 0.01) << what;
  ASSERT_FALSE(run.samples.empty()) << what;
  EXPECT_LT(off(run.samples.back().position, end), 1e-12) << what;
}

AxisVector end_of(const Move& move) {
  return std::visit([](const auto& geometry) { return geometry.end; }, move.geometry);
}

TEST(Kernel, SingleLineEndsExactlyAndInTheTimeOfItsLimits) {
  const auto machine = rig::machine(2, 500, 2000, 50'000);
  const auto run = traced(machine, {line({100, 0}, 100)});
  expect_good(machine, run, {100, 0}, "line");
  // Cruise, acceleration and half a jerk ramp at each end: nothing faster exists; 10 % on top is ours.
  EXPECT_GT(run.time_s, 1.0 + 100.0 / 2000 + 2000.0 / 50'000 - 0.001);
  EXPECT_LT(run.time_s, 1.10 * (1.0 + 100.0 / 2000 + 2000.0 / 50'000));
}

TEST(Kernel, UnlimitedJerkIsNearTheSecondOrderOptimum) {
  const auto machine = rig::machine(1, 500, 2000, 1e12);
  const auto run = traced(machine, {line({10}, 100)});
  expect_good(machine, run, {10}, "line");
  EXPECT_LT(run.time_s, 1.04 * (0.1 + 100.0 / 2000));
}

TEST(Kernel, TheSmallestMoveIsMade) {
  const auto machine = rig::machine(1, 500, 2000, 50'000);
  for (const double length : {1e-6, 1e-4, 1e-3}) {
    const auto run = traced(machine, {line({length}, 100)});
    expect_good(machine, run, {length}, std::to_string(length));
  }
}

TEST(Kernel, MovesOfNoLengthKeepTagAndExactStop) {
  const auto machine = rig::machine(2, 500, 2000, 50'000);
  std::vector<Move> moves{line({10, 0}, 100), line({10, 0}, 100), line({10, 10}, 100), line({10, 10}, 100)};
  moves[1].exact_stop = true;
  const auto run = traced(machine, moves);
  expect_good(machine, run, {10, 10}, "no length");
  EXPECT_EQ(run.samples.back().tag, 4u);
  double nearest = 1;
  for (const Sample& sample : run.samples) nearest = std::min(nearest, off(sample.position, {10, 0}));
  EXPECT_EQ(nearest, 0);
  EXPECT_TRUE(traced(machine, {line({0, 0}, 100)}).finished);
}

TEST(Kernel, AMoveTooManyStopsTheAxesAndIsNotTraced) {
  const auto machine = rig::machine(2, 300, 2000, 50'000);
  Kernel kernel(machine);
  kernel.set_position({});
  for (std::size_t i = 1; i <= Kernel::kQueueMoves; ++i) kernel.push(line({0.5 * static_cast<double>(i), 0}, 50));
  while (kernel.plan()) {
  }
  for (int period = 0; period < 100; ++period) kernel.step({}, 0, 0);
  while (kernel.can_push()) kernel.push(line({3'000, 0}, 50));
  kernel.push(line({0, 700}, 50));
  Sample sample;
  for (int period = 0; period < 1'000 && !kernel.aborted(); ++period) {
    kernel.plan();
    sample = kernel.step({}, 0, 0);
    EXPECT_EQ(sample.position[1], 0);
  }
  EXPECT_TRUE(kernel.aborted());
  EXPECT_FALSE(sample.moving);
}

TEST(Kernel, ChordsOfACircleFlow) {
  for (const double jerk : {50'000.0, 500'000.0, 1e12}) {
    const auto machine = rig::machine(2, 500, 2000, jerk);
    const auto moves = chords(30, 0.1, 100);
    const auto run = traced(machine, moves);
    expect_good(machine, run, {0, 0}, "chords");
    double low = 1e9, high = 0;
    for (std::size_t i = run.samples.size() / 4; i < 3 * run.samples.size() / 4; ++i) {
      low = std::min(low, run.samples[i].path_speed_mm_s);
      high = std::max(high, run.samples[i].path_speed_mm_s);
    }
    EXPECT_LE(high, 1.01 * low) << jerk;
    EXPECT_GT(low, 99) << jerk;
  }
}

TEST(Kernel, ArcsLieOnTheArc) {
  for (const double radius : {0.05, 0.5, 10.0, 300.0}) {
    const auto machine = rig::machine(2, 500, 2000, 50'000);
    Move move = line({0, 0}, 200);
    move.geometry = Arc{{0, 0}, 0, 1, -radius, 0, 2 * M_PI};
    const auto run = traced(machine, {move});
    expect_good(machine, run, {0, 0}, "circle");
    double worst = 0;
    for (std::size_t i = run.samples.size() / 4; i < 3 * run.samples.size() / 4; ++i) {
      const auto& p = run.samples[i].position;
      worst = std::max(worst, std::abs(std::hypot(p[0] + radius, p[1]) - radius));
    }
    EXPECT_LT(worst, 2e-6 * std::max(1.0, radius)) << radius;
  }
}

TEST(Kernel, HelixOfSeveralTurnsThenATangent) {
  const auto machine = rig::machine(3, 500, 2000, 50'000);
  Move helix = line({}, 100);
  helix.geometry = Arc{{0, 0, 5}, 0, 1, -5, 0, 6 * M_PI};
  expect_good(machine, traced(machine, {helix, line({0, 50, 5}, 100)}), {0, 50, 5}, "helix");
}

TEST(Kernel, ReversalsKeepTheLimits) {
  const auto machine = rig::machine(2, 500, 2000, 50'000);
  expect_good(
      machine,
      traced(machine, {line({10, 0}, 100), line({0, 0}, 100), line({0.02, 0}, 100), line({0, 0}, 100)}), {},
      "reversal");
}

TEST(Kernel, ExactStopReachesTheCorner) {
  const auto machine = rig::machine(2, 500, 2000, 50'000);
  std::vector<Move> moves{line({10, 0}, 100), line({10, 10}, 100)};
  moves[0].exact_stop = true;
  const auto run = traced(machine, moves);
  expect_good(machine, run, {10, 10}, "exact stop");
  double nearest = 1;
  for (const Sample& sample : run.samples) nearest = std::min(nearest, off(sample.position, {10, 0}));
  EXPECT_EQ(nearest, 0);
  EXPECT_LT(run.path_error, 1e-12);
}

TEST(Kernel, RapidKeepsEachAxisAtItsOwnRate) {
  auto machine = rig::machine(2, 50, 2000, 50'000, 400);
  machine.axes[1].rapid_mm_min = 100 * 60;
  Move rapid = line({200, 150}, 0);
  rapid.feed = RapidFeed{};
  const auto run = traced(machine, {rapid});
  EXPECT_TRUE(run.finished);
  EXPECT_EQ(rig::violations(machine, run, true), "");
  EXPECT_LT(run.path_error, 1e-9);
  EXPECT_NEAR(run.velocity[1], 100, 0.2);
}

TEST(Kernel, FeedPerRevolutionFollowsTheSpindle) {
  const auto machine = rig::machine(1, 500, 2000, 50'000);
  Move cut = line({50}, 0);
  cut.feed = RevolutionFeed{0.2, 1200};
  rig::Options options;
  options.rpm = [](std::size_t period) { return period < 2000 ? 1200.0 : 600.0; };
  const auto run = traced(machine, {cut}, options);
  EXPECT_NEAR(run.samples[1000].path_speed_mm_s, 4, 0.01);
  EXPECT_NEAR(run.samples[4000].path_speed_mm_s, 2, 0.01);
  EXPECT_TRUE(run.finished);
}

TEST(Kernel, RandomProgramsKeepLimitsAndTolerance) {
  for (unsigned seed = 1; seed <= 24; ++seed)
    for (const double jerk : {50'000.0, 1e12}) {
      const auto machine = uneven_machine(jerk);
      const auto moves = random_program(seed, 60);
      expect_good(machine, traced(machine, moves), end_of(moves.back()),
                  "seed " + std::to_string(seed) + " jerk " + std::to_string(jerk));
    }
}

TEST(Kernel, OverrideAndHoldAtRandomInstantsKeepLimitsAndTolerance) {
  for (unsigned seed = 1; seed <= 24; ++seed) {
    const auto machine = uneven_machine(seed % 2 ? 50'000 : 1e12);
    const auto moves = random_program(seed, 40);
    rig::Options options;
    std::mt19937 generator(seed);
    Overrides now;
    options.overrides = [&](std::size_t) {
      if (generator() % 40 == 0) {
        now.hold = generator() % 4 == 0;
        now.feed = static_cast<double>(generator() % 255) / 100;
      }
      return now;
    };
    expect_good(machine, traced(machine, moves, options), end_of(moves.back()),
                "seed " + std::to_string(seed));
  }
}

TEST(Kernel, EveryMoveOfOneLineHasItsOwnFeed) {
  for (const double jerk : {1e12, 500'000.0, 50'000.0}) {
    const auto machine = rig::machine(2, 500, 2000, jerk);
    const std::vector<std::pair<double, double>> ends_feeds = {{10, 20}, {20, 40}, {30, 40}, {34, 5}, {70, 100}, {90, 30}};
    std::vector<Move> moves;
    for (const auto& [end, feed] : ends_feeds) moves.push_back(line({end, 0.5 * end}, feed * std::hypot(1, 0.5)));
    const auto run = traced(machine, moves);
    ASSERT_TRUE(run.finished);
    EXPECT_EQ(rig::violations(machine, run), "");
    double begin = 0;
    for (const auto& [end, feed] : ends_feeds) {
      double fastest = 0;
      for (std::size_t i = 1; i < run.samples.size(); ++i) {
        const double before = run.samples[i - 1].position[0], now = run.samples[i].position[0];
        if (before >= begin && now <= end) fastest = std::max(fastest, (now - before) / (machine.period_us * 1e-6));
      }
      EXPECT_NEAR(fastest, feed, 0.002 * feed) << "up to " << end << " mm, jerk " << jerk;
      begin = end;
    }
  }
}

TEST(Kernel, FeedsThatChangeOnOneLineKeepLimitsUnderOverrideAndHold) {
  for (unsigned seed = 1; seed <= 24; ++seed) {
    std::mt19937 generator(seed);
    const auto machine = uneven_machine(std::array{1e12, 500'000.0, 50'000.0}[seed % 3]);
    std::vector<Move> moves;
    double x = 0;
    for (int i = 0; i < 60; ++i) {  // lengths and feeds over four decades, now and then a corner
      x += std::pow(10.0, static_cast<double>(generator() % 4000) / 1000 - 3);
      moves.push_back(line({x, 0.25 * x, static_cast<double>(i / 20)}, std::pow(10.0, static_cast<double>(generator() % 3000) / 1000 - 0.5)));
    }
    rig::Options options;
    Overrides now;
    options.overrides = [&](std::size_t) {
      if (seed > 12 && generator() % 40 == 0) {
        now.hold = generator() % 4 == 0;
        now.feed = static_cast<double>(10 + generator() % 245) / 100;
      }
      return now;
    };
    expect_good(machine, traced(machine, moves, options), end_of(moves.back()), "seed " + std::to_string(seed));
  }
}

TEST(Kernel, HoldStopsOnThePathAndGoesOn) {
  const auto machine = rig::machine(2, 500, 2000, 50'000);
  rig::Options options;
  options.overrides = [](std::size_t period) { return Overrides{1, 1, period >= 300 && period < 900}; };
  const auto moves = chords(20, 0.1, 100);
  const auto run = traced(machine, moves, options);
  expect_good(machine, run, {0, 0}, "hold");
  EXPECT_LT(run.samples[301].path_speed_mm_s, run.samples[299].path_speed_mm_s);  // acts in the next period
  EXPECT_FALSE(run.samples[600].moving);
  EXPECT_EQ(off(run.samples[600].position, run.samples[890].position), 0);
}

TEST(Kernel, TheSameSamplesHoweverPlanningIsCut) {
  const auto machine = uneven_machine(50'000);
  const auto moves = random_program(6, 3000);
  const auto whole = traced(machine, moves);
  rig::Options slices;
  slices.plans_per_step = 1;
  EXPECT_TRUE(identical(whole, traced(machine, moves, slices)));
  EXPECT_TRUE(identical(whole, traced(machine, moves)));
}

TEST(Kernel, AfterAnAbortTheNextRunIsTheSame) {
  const auto machine = uneven_machine(50'000);
  const auto moves = tagged(random_program(5, 60));
  auto kernel = std::make_unique<Kernel>(machine);
  const auto first = rig::run(*kernel, machine, moves);
  std::mt19937 generator(1);
  for (int round = 0; round < 20; ++round) {
    kernel->set_position({});
    LimitsCheck limits(3, 0.001);
    limits.add({});
    for (const Move& move : moves) kernel->push(move);
    kernel->finish();
    while (kernel->plan()) {
    }
    const std::size_t at = generator() % first.samples.size();
    AxisVector last{};
    for (std::size_t i = 0; i < at; ++i) limits.add(last = kernel->step({}, 0, 0).position);
    kernel->abort();
    for (int i = 0; i < 3000 && !kernel->aborted(); ++i) limits.add(last = kernel->step({}, 0, 0).position);
    ASSERT_TRUE(kernel->aborted());
    for (int i = 0; i < 100; ++i)
      EXPECT_EQ(off(kernel->step({}, 0, 0).position, last), 0);  // nothing starts by itself
    rig::Run aborted;
    aborted.velocity = limits.max_velocity();
    aborted.acceleration = limits.max_acceleration();
    aborted.jerk = limits.max_jerk();
    EXPECT_EQ(rig::violations(machine, aborted), "") << at;
  }
  EXPECT_TRUE(identical(first, rig::run(*kernel, machine, moves)));
}

TEST(Kernel, StarvationStopsInsideTheLimitsOnTheSamePath) {
  const auto machine = rig::machine(2, 500, 2000, 50'000);
  const auto moves = tagged(chords(20, 0.1, 100));
  auto kernel = std::make_unique<Kernel>(machine);
  kernel->set_position({});
  LimitsCheck limits(2, 0.001);
  PathError error(2);
  limits.add({});
  error.start({});
  bool starved = false;
  std::size_t next = 0;
  Sample sample;
  for (int period = 0; period < 20'000; ++period) {
    if (period % 400 == 0)  // 40 moves, then nothing for 0.4 s
      for (int i = 0; i < 40 && next < moves.size(); ++i) {
        error.add(moves[next]);
        kernel->push(moves[next++]);
      }
    if (next == moves.size()) kernel->finish();
    while (kernel->plan()) {
    }
    sample = kernel->step({}, 0, 0);
    starved = starved || (sample.starved && !sample.moving);
    limits.add(sample.position);
    error.sample(sample.position, sample.tag);
  }
  EXPECT_TRUE(starved);
  EXPECT_TRUE(sample.queue_empty);
  EXPECT_LT(off(sample.position, {0, 0}), 1e-12);
  EXPECT_LE(error.max(), 0.01);
  rig::Run run;
  run.velocity = limits.max_velocity();
  run.acceleration = limits.max_acceleration();
  run.jerk = limits.max_jerk();
  EXPECT_EQ(rig::violations(machine, run), "");
}

TEST(Kernel, ThreadPassesMeetTheSameGroove) {
  const auto machine = rig::machine(2, 500, 2000, 50'000);
  double first = 0;
  for (int pass = 0; pass < 10; ++pass) {
    Move cut = line({0, 30}, 0);
    cut.tag = 1;
    cut.feed = ThreadFeed{2.0, 0, 0.5};
    const double rpm = 600 * (0.95 + 0.01 * pass);
    auto kernel = std::make_unique<Kernel>(machine);
    kernel->set_position({});
    kernel->push(cut);
    kernel->finish();
    while (kernel->plan()) {
    }
    double phase = 0.37 * pass, groove = 0;
    bool measured = false;
    for (int i = 0; i < 10'000; ++i) {
      phase += rpm / 60 * 0.001 * 2 * M_PI;
      const Sample sample = kernel->step({}, phase, rpm);
      if (sample.position[1] > 15 && !measured) {
        groove = std::remainder(phase - sample.position[1] / 2.0 * 2 * M_PI, 2 * M_PI);
        measured = true;
      }
      if (sample.queue_empty) break;
    }
    ASSERT_TRUE(measured);
    EXPECT_NEAR(groove, 0.5, 0.1 * M_PI / 180) << rpm;
    if (pass == 0) first = groove;
    EXPECT_NEAR(groove, first, 0.1 * M_PI / 180) << rpm;
  }
}

}  // namespace
}  // namespace headstock::motion

// Limits are law: random programs, overrides, holds, single blocks and skips at random instants; every sample
// is judged from outside.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>

#include "random_programs.hpp"
#include "rig.hpp"

namespace headstock::motion {
namespace {

machine::Machine machine_for(unsigned seed, double jerk) {
  machine::Machine machine = rig::machine(3, 300, 2000, jerk);
  if (seed % 2 == 0) return machine;
  machine.axes[1].max_acceleration_mm_s2 = 700;
  machine.axes[2].max_jerk_mm_s3 = 0.3 * jerk;
  machine.axes[2].max_feed_mm_min = 3000;
  return machine;
}

double off(const AxisVector& a, const AxisVector& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

void expect_lawful(const machine::Machine& machine, const std::vector<Move>& moves, const rig::Run& run,
                   const std::string& what) {
  EXPECT_TRUE(run.finished) << what;
  EXPECT_EQ(rig::violations(machine, run), "") << what;
  EXPECT_LE(run.path_error, moves[0].tolerance_mm) << what;
  ASSERT_FALSE(run.samples.empty()) << what;
  EXPECT_EQ(off(run.samples.back().position, rig::end_of(moves.back())), 0) << what;
}

struct Case {
  double jerk;
  unsigned first, last;
};
class Law : public testing::TestWithParam<Case> {};

/// HEADSTOCK_LAW_PROGRAMS=1000 motion_test --gtest_filter='*Law*': that many programs for each limit, for a night.
unsigned last_seed(const Case& one) {
  const char* many = std::getenv("HEADSTOCK_LAW_PROGRAMS");
  return many ? one.first + static_cast<unsigned>(std::atoi(many)) - 1 : one.last;
}

TEST_P(Law, HoldsOnEveryRandomProgram) {
  for (unsigned seed = GetParam().first; seed <= last_seed(GetParam()); ++seed) {
    const auto machine = machine_for(seed, GetParam().jerk);
    const auto moves = rig::random_program(seed, 50);
    auto kernel = std::make_unique<Kernel>(machine);
    expect_lawful(machine, moves, rig::run(*kernel, machine, moves), "seed " + std::to_string(seed));
  }
}

TEST_P(Law, HoldsWhateverTheOperatorDoes) {
  for (unsigned seed = GetParam().first; seed <= last_seed(GetParam()); ++seed) {
    const auto machine = machine_for(seed, GetParam().jerk);
    const auto moves = rig::random_program(seed, 40);
    std::mt19937 generator(seed);
    Overrides now;
    rig::Options options;
    options.overrides = [&](std::size_t) {
      if (generator() % 40 == 0) {
        now.hold = generator() % 4 == 0;
        now.feed = static_cast<double>(generator() % 255) / 100;
        now.single_block = generator() % 3 == 0;
      }
      if (generator() % 60 == 0) ++now.go;
      return now;
    };
    auto kernel = std::make_unique<Kernel>(machine);
    expect_lawful(machine, moves, rig::run(*kernel, machine, moves, options), "seed " + std::to_string(seed));
  }
}

TEST_P(Law, HoldsAtEveryPeriod) {
  for (unsigned seed = GetParam().first; seed < GetParam().first + 4; ++seed)
    for (const unsigned period_us : {250u, 700u, 8000u}) {
      auto machine = machine_for(seed, GetParam().jerk);
      machine.period_us = period_us;
      const auto moves = rig::random_program(seed, 20);
      auto kernel = std::make_unique<Kernel>(machine);
      expect_lawful(machine, moves, rig::run(*kernel, machine, moves),
                    "seed " + std::to_string(seed) + " at " + std::to_string(period_us) + " us");
    }
}

INSTANTIATE_TEST_SUITE_P(Jerk, Law,
                         testing::Values(Case{50'000, 1, 32}, Case{500'000, 33, 64}, Case{1e12, 65, 96}));

TEST(SingleBlock, StopsAtTheEndOfTheBlockThatIsCutAndGoesOnWithTheNext) {
  const auto machine = rig::machine(2, 300, 2000, 50'000);
  std::vector<Move> moves{rig::line({20, 0}, 100), rig::line({20, 20}, 100), rig::line({0, 20}, 100),
                          rig::line({0, 0}, 100)};
  for (std::size_t i = 0; i < moves.size(); ++i) moves[i].tag = i + 1;
  moves[1].block_end = false;  // moves 2 and 3 are one block
  std::mt19937 generator(3);
  for (int round = 0; round < 40; ++round) {
    auto kernel = std::make_unique<Kernel>(machine);
    Overrides now;
    const std::size_t at = generator() % 800;
    std::vector<AxisVector> stops;
    std::size_t stood = 0;
    std::uint64_t traced = 0;
    rig::Options options;
    options.overrides = [&](std::size_t period) {
      now.single_block = period >= at;
      if (stood > 5) {
        ++now.go;
        stood = 0;
      }
      return now;
    };
    options.watch = [&](const Sample& sample) {
      if (sample.block_stopped && stood++ == 0) stops.push_back(sample.position);
      EXPECT_FALSE(sample.block_stopped && sample.moving);
      traced = std::max(traced, sample.tag);
    };
    const auto run = rig::run(*kernel, machine, moves, options);
    expect_lawful(machine, moves, run, "switched on in period " + std::to_string(at));
    EXPECT_LE(stops.size(), 2u);
    EXPECT_TRUE(at > 150 || stops.size() == 2) << at;  // still in the first block, far from its end
    for (const AxisVector& stop : stops)
      EXPECT_LE(std::min(off(stop, {20, 0}), off(stop, {0, 20})), 0.01) << at;
  }
}

TEST(SingleBlock, AnExactStopIsTheProgrammedPoint) {
  const auto machine = rig::machine(2, 300, 2000, 50'000);
  std::vector<Move> moves{rig::line({0.1, 0.7}, 100), rig::line({20, 20}, 100)};
  moves[0].tag = 1;
  moves[1].tag = 2;
  moves[0].exact_stop = true;
  auto kernel = std::make_unique<Kernel>(machine);
  Overrides now;
  now.single_block = true;
  bool stopped = false;
  rig::Options options;
  options.overrides = [&](std::size_t) { return now; };
  options.watch = [&](const Sample& sample) {
    if (!sample.block_stopped) return;
    stopped = true;
    EXPECT_EQ(off(sample.position, {0.1, 0.7}), 0);
    ++now.go;
  };
  EXPECT_TRUE(rig::run(*kernel, machine, moves, options).finished);
  EXPECT_TRUE(stopped);
}

TEST(Skip, LatchesInThePeriodItHappensAndBrakesInsideTheLimits) {
  const auto machine = rig::machine(2, 300, 2000, 50'000);
  Move probe = rig::line({100, 40}, 50);
  probe.tag = 1;
  probe.skip = probe.exact_stop = true;
  for (const std::size_t at : {100u, 500u, 1000u}) {
    auto kernel = std::make_unique<Kernel>(machine);
    kernel->set_position({});
    kernel->push(probe);
    kernel->finish();
    while (kernel->plan()) {
    }
    LimitsCheck limits(2, 0.001);
    limits.add({});
    Sample sample;
    AxisVector expected{};
    for (std::size_t period = 0; period < 20'000 && !kernel->aborted(); ++period) {
      Overrides now;
      now.skip_signal = period >= at && period < at + 3;  // a short contact is enough
      sample = kernel->step(now, 0, 0);
      limits.add(sample.position);
      if (period == at) {
        EXPECT_TRUE(sample.skipped);
        expected = sample.position;
      }
    }
    EXPECT_TRUE(kernel->aborted());
    EXPECT_EQ(off(sample.skip_position, expected), 0);
    EXPECT_LT(sample.position[0], 90);
    EXPECT_GT(sample.position[0], expected[0]);
    rig::Run run;
    run.velocity = limits.max_velocity();
    run.acceleration = limits.max_acceleration();
    run.jerk = limits.max_jerk();
    EXPECT_EQ(rig::violations(machine, run), "");
  }
}

TEST(Skip, OtherMovesDoNotCare) {
  const auto machine = rig::machine(2, 300, 2000, 50'000);
  rig::Options options;
  options.overrides = [](std::size_t) {
    Overrides now;
    now.skip_signal = true;
    return now;
  };
  auto kernel = std::make_unique<Kernel>(machine);
  const auto run = rig::run(*kernel, machine, {rig::line({10, 0}, 50)}, options);
  EXPECT_TRUE(run.finished);
  EXPECT_EQ(run.samples.back().position[0], 10);
}

TEST(Determinism, FirstTenthAndAfterAnAbortAreTheSameBits) {
  const auto machine = machine_for(1, 50'000);
  const auto moves = rig::random_program(3, 60);  // lines and arcs
  auto kernel = std::make_unique<Kernel>(machine);
  const auto same = [&](const rig::Run& a, const rig::Run& b) {
    if (a.samples.size() != b.samples.size()) return false;
    for (std::size_t i = 0; i < a.samples.size(); ++i)
      if (a.samples[i].position != b.samples[i].position) return false;
    return true;
  };
  const auto first = rig::run(*kernel, machine, moves);
  for (int i = 2; i <= 10; ++i) {
    const auto again = rig::run(*kernel, machine, moves);
    EXPECT_TRUE(same(first, again)) << i;
  }
  kernel->set_position({});
  for (const Move& move : moves) kernel->push(move);
  kernel->finish();
  while (kernel->plan()) {
  }
  for (int i = 0; i < 777; ++i) kernel->step({}, 0, 0);
  kernel->abort();
  for (int i = 0; i < 5000 && !kernel->aborted(); ++i) kernel->step({}, 0, 0);
  ASSERT_TRUE(kernel->aborted());
  EXPECT_TRUE(same(first, rig::run(*kernel, machine, moves)));
}

}  // namespace
}  // namespace headstock::motion

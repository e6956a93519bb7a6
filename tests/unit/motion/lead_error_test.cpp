// The pitch of cut threads: the judge against figures worked out by hand, then the kernel judged by it.
#include "motion/lead_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "rig.hpp"

namespace headstock::motion {
namespace {

Move thread(double length, double lead, double change = 0) {
  Move move = rig::line({0, length}, 0);
  move.tag = 1;
  move.feed = ThreadFeed{lead, change, 0.5};
  return move;
}

/// Fed with a tool that goes `lead(turn)` in each turn of 100 periods.
double judged(const Move& cut, double (*lead)(int turn)) {
  LeadError judge(2);
  judge.start({});
  judge.add(cut);
  double way = 0;
  for (int period = 0; period <= 1000; ++period) {
    Sample sample;
    sample.tag = 1;
    sample.moving = true;
    sample.position[1] = way;
    judge.sample(sample, 2 * M_PI * period / 100);
    way += lead(period / 100) / 100;
  }
  EXPECT_EQ(judge.threads(), 1u);
  EXPECT_GE(judge.turns(), 6u);
  return judge.max_mm();
}

TEST(LeadError, IsWhatATurnIsTooLongOrTooShort) {
  EXPECT_NEAR(judged(thread(20, 2), [](int) { return 2.0; }), 0, 1e-9);
  EXPECT_NEAR(judged(thread(20, 2), [](int turn) { return turn == 5 ? 2.03 : 2.0; }), 0.03, 1e-9);
  EXPECT_NEAR(judged(thread(20, 2), [](int turn) { return turn == 5 ? 1.9 : 2.0; }), 0.1, 1e-9);
}

TEST(LeadError, RunInAndRunOutAreNotThread) {
  EXPECT_NEAR(judged(thread(20, 2), [](int turn) { return turn == 0   ? 0.7
                                                          : turn == 9 ? 0.4
                                                                      : 2.0; }), 0,
              1e-9);
}

LeadError cut_by_kernel(const machine::Machine& machine, const Move& move,
                        const std::function<double(std::size_t)>& rpm) {
  LeadError judge(2);
  judge.start({});
  judge.add(move);
  auto kernel = std::make_unique<Kernel>(machine);
  kernel->set_position({});
  kernel->push(move);
  kernel->finish();
  while (kernel->plan()) {
  }
  double phase = 0.4;
  bool done = false;
  for (std::size_t period = 0; period < 20'000 && !done; ++period) {
    phase += rpm(period) / 60 * 0.001 * 2 * M_PI;
    const Sample sample = kernel->step({}, phase, rpm(period));
    judge.sample(sample, phase);
    done = sample.queue_empty;
  }
  EXPECT_TRUE(done);
  EXPECT_EQ(judge.threads(), 1u);
  EXPECT_GT(judge.turns(), 20u);
  return judge;
}

TEST(LeadError, OfTheKernelAtConstantSpeedIsNothing) {
  for (const double jerk : {50'000.0, 500'000.0, 1e12}) {
    const auto machine = rig::machine(2, 500, 2000, jerk);
    const LeadError judge = cut_by_kernel(machine, thread(60, 2), [](std::size_t) { return 600.0; });
    EXPECT_LT(judge.max_mm(), 1e-6) << jerk;
    EXPECT_LT(judge.run_in_mm(), 2) << jerk;
  }
}

TEST(LeadError, OfAVariableLeadIsNothing) {
  const auto machine = rig::machine(2, 500, 2000, 500'000);
  const LeadError judge = cut_by_kernel(machine, thread(80, 2, 0.05), [](std::size_t) { return 600.0; });
  EXPECT_LT(judge.max_mm(), 1e-3);
}

// The speed swings by 5 % once a second: what the tool is late by then is its smoothing time.
TEST(LeadError, StaysSmallWhileTheSpindleSpeedVaries) {
  const auto machine = rig::machine(2, 500, 2000, 50'000);
  const LeadError judge = cut_by_kernel(machine, thread(60, 2), [](std::size_t period) {
    return 600 * (1 + 0.05 * std::sin(2 * M_PI * 0.001 * static_cast<double>(period)));
  });
  EXPECT_LT(judge.max_mm(), 0.02);
}

}  // namespace
}  // namespace headstock::motion

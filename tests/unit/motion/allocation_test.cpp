// The real-time cycle must not allocate: every operator new of this program is counted.
#include <gtest/gtest.h>

#include <cmath>

#include "rig.hpp"
#include "tests/unit/counted_allocations.hpp"

namespace headstock::motion {
namespace {

TEST(Allocation, TheCounterCounts) {
  const std::size_t before = thread_allocations;
  int* volatile kept = new int;  // not to be optimised away
  delete kept;
  EXPECT_GT(thread_allocations, before);
}

TEST(Allocation, StepDoesNotAllocate) {
  const auto machine = rig::machine(5, 500, 2000, 50'000);
  Kernel kernel(machine);
  kernel.set_position({});
  for (int i = 1; i < 1000; ++i) {
    Move move = rig::line({0.1 * i, std::sin(0.1 * i), 0, 0, 0}, 100);
    move.tag = static_cast<std::uint64_t>(i);
    move.exact_stop = i % 100 == 0;
    if (i > 900) move.feed = RapidFeed{};
    if (i == 999) move.feed = ThreadFeed{2, 0, 0};
    kernel.push(move);
  }
  kernel.finish();
  while (kernel.plan()) {
  }
  const std::size_t before = thread_allocations;
  bool empty = false;
  int periods = 0;
  for (; periods < 100'000 && !empty; ++periods) {
    Overrides overrides;
    overrides.feed = 0.01 * (periods % 255);
    overrides.hold = periods % 1000 > 900;
    empty = kernel.step(overrides, 0.1 * periods, 1000).queue_empty;
  }
  kernel.abort();
  for (int i = 0; i < 100; ++i) kernel.step({}, 0, 0);
  EXPECT_EQ(thread_allocations, before);
  EXPECT_TRUE(empty);
}

TEST(Allocation, NorDoesItWithShapes) {
  const auto machine = rig::machine(3, 500, 2000, 50'000);
  AccelerationShape linear, exponential, bell;
  linear.after = FilterShape::linear;
  linear.after_s.fill(kLongestFilter_s);
  linear.after_bell_s.fill(0.1);
  exponential.after = FilterShape::exponential;
  exponential.after_s.fill(0.05);
  bell.bell_s = kLongestBell_s;
  Kernel kernel(machine);
  kernel.set_shapes({AccelerationShape{}, linear, exponential, bell});
  kernel.set_position({});
  for (int i = 1; i < 200; ++i) {
    Move move = rig::line({0.5 * i, std::sin(0.1 * i), 0}, 100);
    move.tag = static_cast<std::uint64_t>(i);
    move.shape = static_cast<std::uint8_t>(i / 50);
    kernel.push(move);
  }
  kernel.finish();
  while (kernel.plan()) {
  }
  const std::size_t before = thread_allocations;
  bool empty = false;
  for (int periods = 0; periods < 100'000 && !empty; ++periods)
    empty = kernel.step({}, 0.1 * periods, 1000).queue_empty;
  EXPECT_EQ(thread_allocations, before);
  EXPECT_TRUE(empty);
}

}  // namespace
}  // namespace headstock::motion

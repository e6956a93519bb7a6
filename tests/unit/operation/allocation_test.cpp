// The real-time thread must not allocate: operator new counts while a period is made.
#include <gtest/gtest.h>

#include "bench.hpp"
#include "tests/unit/counted_allocations.hpp"

namespace headstock::operation {
namespace {

TEST(Period, NeverAllocatesWhateverHappens) {
  ControllerOptions options;  // with the simulated servo drive
  options.now_ms = [] { return std::int64_t{0}; };
  Bench bench("fanuc-0i-t", std::move(options));
  bench.load(
      "O1\nG21 G98\nG50 S2000\nG96 S150 M03\nT0101\nM08\nG00 X40. Z2.\nG01 Z-20. F3000.\nG02 X50. Z-25. R5.\n"
      "G04 P300\nG99 G01 X60. F0.5\nM09\nM05\nM30\n");
  ASSERT_TRUE(bench.start());
  std::uint64_t moving = 0, allocated = 0;
  for (int i = 0; i < 40'000; ++i) {
    if (i == 3000 || i == 9000) bench.press(Action::feed_hold);
    if (i == 3500 || i == 9500) bench.start();
    if (i == 5000) bench.press(Action::set_feed_override, 0.5);
    if (i == 15'000) bench.press(Action::reset);
    if (i == 16'000) bench.start();
    if (i == 20'000) bench.press(Action::emergency_stop);
    if (i == 21'000) bench.press(Action::emergency_stop_release);
    if (i == 22'000) bench.start();
    bench.commit();
    while (bench.controller.work()) {
    }
    const auto before = thread_allocations;
    bench.controller.step();
    allocated += thread_allocations - before;
    moving += bench.controller.sample().moving;
  }
  EXPECT_EQ(allocated, 0u);
  EXPECT_GT(moving, 1000u);
}

}  // namespace
}  // namespace headstock::operation

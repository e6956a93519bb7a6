// G31 when the signal comes: the program goes on from where the axes stand (0i-D 4.6, examples E9-E11).
#include <gtest/gtest.h>

#include "tests/unit/coordinates/bench.hpp"

namespace headstock::interp {
namespace {

AxisVector next_end(Interpreter& interpreter) {
  Operation operation;
  while (interpreter.next(operation) == Pull::operation) {
    if (const Motion* m = motion_of(operation)) return m->end_machine;
  }
  return {};
}

AxisVector after_skip(const std::string& text, double stopped_at) {
  Bench bench("fanuc-0i-m");
  bench.start("G01 F500\n" + text + "\nM30\n");
  Operation operation;
  while (bench.interpreter.next(operation) == Pull::operation) {
    const auto* feed = std::get_if<Feed>(&operation);
    if (feed == nullptr || feed->skip_signals == 0) continue;
    AxisVector at = feed->end_machine;
    at[0] = stopped_at;
    bench.interpreter.skip_ended(at, true);
    return next_end(bench.interpreter);
  }
  return {};
}

TEST(Skip, AnIncrementCountsFromWhereTheAxesStopped) {
  const AxisVector end = after_skip("G31 G91 X100.0 F100\nY50.0", 61.25);
  EXPECT_DOUBLE_EQ(end[0], 61.25);
  EXPECT_DOUBLE_EQ(end[1], 50);
}

TEST(Skip, AnAbsoluteMoveOfOneAxisLeavesTheOther) {
  const AxisVector end = after_skip("G31 G90 X200.0 F100\nY100.0", 61.25);
  EXPECT_DOUBLE_EQ(end[0], 61.25);
  EXPECT_DOUBLE_EQ(end[1], 100);
}

TEST(Skip, AnAbsoluteMoveOfBothGoesToItsEnd) {
  const AxisVector end = after_skip("G31 G90 X200.0 F100\nX300.0 Y100.0", 61.25);
  EXPECT_DOUBLE_EQ(end[0], 300);
  EXPECT_DOUBLE_EQ(end[1], 100);
}

TEST(Skip, NothingIsReadBeyondTheSkipMove) {
  Bench bench("fanuc-0i-m");
  bench.start("G01 F500\nG31 X100.\nX50.\nM30\n");
  Operation operation;
  ASSERT_EQ(bench.interpreter.next(operation), Pull::operation);
  ASSERT_NE(std::get_if<Feed>(&operation), nullptr);
  EXPECT_EQ(std::get<Feed>(operation).at.line, 2u);
  EXPECT_TRUE(std::get<Feed>(operation).exact_stop);
}

}  // namespace
}  // namespace headstock::interp

// Direct input of measured values: what the page shows afterwards, and what is refused.
#include <gtest/gtest.h>

#include "bench.hpp"
#include "interpreter/data_values.hpp"
#include "operation/data_edit.hpp"

namespace headstock::operation {
namespace {

double value(Bench& bench, const std::string& what) {
  std::vector<char> names;
  for (const auto& axis : bench.controller.machine().axes) names.push_back(axis.name);
  return interp::read_value(bench.controller.data(), names, what).value.value_or(-1e9);
}

void run(Bench& bench, const std::string& program) {
  bench.load(program);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.state() == State::idle; }));
}

// After the entry the same program leads the tip to the surface that was measured.
TEST(Touch, ToolOffsetOfALathe) {
  for (const char* profile : {"fanuc-0i-t", "gsk-2000tc", "gsk-218t", "k2000tc", "lathe-200t"}) {
    SCOPED_TRACE(profile);
    Bench bench(profile);
    run(bench, "O1\nG00 X60. Z20.\nM30\n%\n");
    const Live before = bench.controller.live();
    ASSERT_TRUE(bench.controller.touch({"tool/3/geometry/X", before.absolute[0] - 12.5, "wang"}).accepted);
    const double sign = std::string_view(profile) == "lathe-200t" ? -1 : 1;
    EXPECT_NEAR(value(bench, "tool/3/geometry/X"), sign * 12.5, 1e-6);
  }
}

TEST(Touch, WearIsTakenUpByTheGeometry) {
  Bench bench("fanuc-0i-t");
  EditRequest stored;
  stored.values = {{"tool/3/geometry/Z", 0, 5}, {"tool/3/wear/Z", 0, 0.25}};
  stored.origin = "panel";
  ASSERT_TRUE(bench.controller.edit_values(stored).accepted);
  run(bench, "O1\nT0303\nG00 X60. Z20.\nM30\n%\n");
  ASSERT_EQ(bench.controller.live().offset, 3);
  const EditResult result = bench.controller.touch({"tool/3/geometry/Z", 19, ""});  // it says 20 and is 19
  ASSERT_TRUE(result.accepted) << result.reason;
  EXPECT_NEAR(value(bench, "tool/3/geometry/Z"), 6.25, 1e-6);
  EXPECT_EQ(value(bench, "tool/3/wear/Z"), 0);
  // The same slides, the same tool: the page calls the place by its name now.
  const double slide = bench.controller.live().machine[1];
  run(bench, "O1\nT0303\nG00 Z19.\nM30\n%\n");
  EXPECT_NEAR(bench.controller.live().machine[1], slide, 1e-3);
}

TEST(Touch, WorkZeroPointInForceOnly) {
  Bench bench("fanuc-0i-m");
  run(bench, "O1\nG90 G55 G00 X30. Y20. Z10.\nM30\n%\n");
  EXPECT_EQ(bench.controller.touch({"work/G54/X", 0, ""}).reason, "other_offset");
  EXPECT_EQ(bench.controller.touch({"work/G54.1P3/X", 0, ""}).reason, "other_offset");
  const double before = value(bench, "work/G55/X");
  ASSERT_TRUE(bench.controller.touch({"work/G55/X", 1.5, ""}).accepted);
  EXPECT_NEAR(value(bench, "work/G55/X"), before + 28.5, 1e-6);
}

TEST(Touch, LengthOfAMill) {
  Bench bench("fanuc-0i-m");
  run(bench, "O1\nG90 G00 Z40.\nM30\n%\n");
  ASSERT_TRUE(bench.controller.touch({"tool/7/geometry/Z", 3, ""}).accepted);
  EXPECT_NEAR(value(bench, "tool/7/geometry/Z"), 37, 1e-6);
}

TEST(Touch, Refused) {
  Bench bench("fanuc-0i-t");
  run(bench, "O1\nT0303\nG00 X60. Z20.\nM30\n%\n");
  EXPECT_EQ(bench.controller.touch({"tool/4/geometry/X", 40, ""}).reason, "other_offset");
  EXPECT_EQ(bench.controller.touch({"tool/3/wear/X", 40, ""}).reason, "bad_place");
  EXPECT_EQ(bench.controller.touch({"variable/500", 40, ""}).reason, "bad_place");
  EXPECT_EQ(bench.controller.touch({"", 40, ""}).reason, "bad_place");
  EXPECT_FALSE(
      bench.controller.touch({"tool/3/geometry/X", 1e6, ""}).accepted);  // larger than the page takes
  bench.load("O1\nG98 G01 X10. F10.\nM30\n%\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until([&] { return bench.state() == State::running; }));
  EXPECT_EQ(bench.controller.touch({"tool/3/geometry/X", 40, ""}).reason, "running");
}

}  // namespace
}  // namespace headstock::operation

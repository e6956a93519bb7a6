// What RESET leaves: reset state and clear state, group by group (0i-D 3, No.3402#6, No.3406…3409).
#include <gtest/gtest.h>

#include "tests/unit/coordinates/bench.hpp"

namespace headstock::interp {
namespace {

constexpr const char* kModes = "G01 G18 G91 G20 G55 G23 G61 F10.\nG68 X0 Z0 R30.\nM00\n";

std::int16_t group(Bench& bench, std::size_t number) {
  return bench.interpreter.modal().g[number];
}

TEST(Reset, WithoutClearStateEveryModeStays) {
  Bench bench("fanuc-0i-m");
  bench.run(kModes);
  bench.interpreter.reset({});
  EXPECT_EQ(group(bench, 1), 10);
  EXPECT_EQ(group(bench, 2), 180);
  EXPECT_EQ(group(bench, 3), 910);
  EXPECT_EQ(group(bench, 6), 200);
  EXPECT_EQ(group(bench, 14), 550);
  EXPECT_EQ(group(bench, 16), 680);
}

TEST(Reset, ClearStateBringsThePowerOnCodesExceptUnitAndStrokeCheck) {
  Bench bench("fanuc-0i-m");
  bench.data.parameters["3402#6"] = 1;
  bench.run(kModes);
  bench.interpreter.reset({});
  EXPECT_EQ(group(bench, 1), 0);
  EXPECT_EQ(group(bench, 2), 170);
  EXPECT_EQ(group(bench, 3), 900);
  EXPECT_EQ(group(bench, 4), 230);
  EXPECT_EQ(group(bench, 6), 200);
  EXPECT_TRUE(bench.interpreter.modal().inch);
  EXPECT_EQ(group(bench, 14), 540);
  EXPECT_EQ(group(bench, 15), 640);
  EXPECT_EQ(group(bench, 16), 690);
  // The rotation is gone, not only its code: X1 inch goes along X.
  const auto made = bench.run("G00 X1.\nM30\n");
  ASSERT_NE(motion_of(made[0]), nullptr);
  EXPECT_NEAR(motion_of(made[0])->end_machine[0], 25.4, 1e-9);
  EXPECT_NEAR(motion_of(made[0])->end_machine[2], 0, 1e-9);
}

TEST(Reset, AGroupIsKeptByItsParameter) {
  for (const auto& [parameter, number, kept] :
       {std::tuple("3406#1", 1, 10), std::tuple("3406#2", 2, 180), std::tuple("3406#3", 3, 910),
        std::tuple("3407#6", 14, 550), std::tuple("3407#7", 15, 610), std::tuple("3408#0", 16, 680)}) {
    Bench bench("fanuc-0i-m");
    bench.data.parameters["3402#6"] = 1;
    bench.data.parameters[parameter] = 1;
    bench.run(kModes);
    bench.interpreter.reset({});
    EXPECT_EQ(group(bench, static_cast<std::size_t>(number)), kept) << parameter;
    EXPECT_EQ(group(bench, 1), number == 1 ? 10 : 0) << parameter;
  }
}

TEST(Reset, LocalCoordinatesGoByTheirParameters) {
  const auto zero_after = [](const char* parameter) {
    Bench bench("fanuc-0i-m");
    if (parameter[0] != '\0') bench.data.parameters[parameter] = 1;
    bench.run("G55 G52 X10.\nM00\n");
    bench.interpreter.reset({});
    return bench.interpreter.modal().work_zero[0];
  };
  EXPECT_EQ(zero_after(""), 10);
  EXPECT_EQ(zero_after("1202#3"), 0);
  EXPECT_EQ(zero_after("1201#7"), 0);
  EXPECT_EQ(zero_after("3402#6"), 0);
}

TEST(Reset, PolarInterpolationEndsWhereTheAxesStand) {
  Bench bench("fanuc-0i-t", "C");
  bench.run("G98 G00 X40.\nG12.1\nG01 C10. F100\nM00\nM30\n");
  AxisVector at{};
  at[0] = 22;
  at[2] = 27;
  bench.interpreter.reset(at);
  const auto shown = bench.interpreter.to_work(at, bench.interpreter.modal());
  EXPECT_NEAR(shown[0], 44, 1e-9);
  EXPECT_NEAR(shown[2], 27, 1e-9);
}

}  // namespace
}  // namespace headstock::interp

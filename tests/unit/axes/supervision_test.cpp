// Following error, synchronous axes, spindle speed fluctuation.
#include "axes/supervision.hpp"

#include <gtest/gtest.h>

namespace headstock::axes {
namespace {

machine::Machine supervised_mill() {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.axes[0].following_error_mm = 4;
  machine.axes[0].following_error_stopped_mm = 0.5;
  return machine;
}

TEST(AxisSupervision, TellsMovingFromStanding) {
  AxisSupervision watch(supervised_mill());
  AxisVector commanded{}, actual{};
  for (int i = 0; i < 100; ++i) {
    commanded[0] += 0.1;
    actual[0] = commanded[0] - 3.9;
    ASSERT_EQ(watch.check(commanded, actual).kind, FaultKind::none);
  }
  actual[0] = commanded[0] + 0.1 - 4.1;
  commanded[0] += 0.1;
  const Fault moving = watch.check(commanded, actual);
  EXPECT_EQ(moving.kind, FaultKind::following_error_moving);
  EXPECT_EQ(moving.axis, 0u);
}

TEST(AxisSupervision, AtRestTheNarrowLimitCountsOnceItHasSettled) {
  AxisSupervision watch(supervised_mill());
  AxisVector commanded{}, actual{};
  actual[0] = 0.6;
  int periods = 0;
  while (watch.check(commanded, actual).kind == FaultKind::none) ASSERT_LT(++periods, 1000);
  EXPECT_GT(periods, 100) << "the lag of a stop must have time to run out";
  EXPECT_EQ(watch.check(commanded, actual).kind, FaultKind::following_error_stopped);
  watch.restart();
  EXPECT_EQ(watch.check(commanded, actual).kind, FaultKind::none);
}

TEST(AxisSupervision, InPositionIsEachAxisOwnWidth) {
  machine::Machine machine = supervised_mill();
  machine.axes[1].in_position_um = 5;
  const AxisSupervision watch(machine);
  AxisVector commanded{}, actual{};
  actual[0] = 0.015;
  EXPECT_TRUE(watch.in_position(commanded, actual));
  actual[1] = 0.006;
  EXPECT_FALSE(watch.in_position(commanded, actual));
}

TEST(AxisSupervision, SynchronousAxesThatPart) {
  machine::Machine machine = supervised_mill();
  machine::Axis slave = machine.axes[1];
  slave.name = 'V';
  slave.follows = 'Y';
  slave.synchronous_error_mm = 0.05;
  machine.axes.push_back(slave);
  AxisSupervision watch(machine);
  AxisVector commanded{}, actual{};
  actual[1] = 0.3;
  actual[3] = 0.27;
  EXPECT_EQ(watch.check(commanded, actual).kind, FaultKind::none);
  actual[3] = 0.24;
  const Fault parted = watch.check(commanded, actual);
  EXPECT_EQ(parted.kind, FaultKind::synchronous_error);
  EXPECT_EQ(parted.axis, 3u);
}

// 0i-D 6.5: q = 15 %, r = 10 %, i = 50 min⁻¹, p = 500 ms.
TEST(SpindleWatch, BeginsWhenTheSpeedIsReachedOrTheTimeIsOver) {
  SpindleWatch watch;
  watch.set({true, 0.5, 0.15, 0.10, 50});
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(watch.check(1000, i * 8, 0.001)) << "running up";
  EXPECT_FALSE(watch.check(1000, 905, 0.001));
  EXPECT_TRUE(watch.check(1000, 899, 0.001));

  watch.set({true, 0.5, 0.15, 0.10, 50});
  int periods = 0;
  while (!watch.check(1000, 500, 0.001)) ASSERT_LT(++periods, 2000) << "it never reaches its speed";
  EXPECT_NEAR(periods, 500, 2);
}

TEST(SpindleWatch, TheWiderOfRatioAndWidthCountsAndANewSpeedBeginsAnew) {
  SpindleWatch watch;
  watch.set({true, 0.5, 0.15, 0.10, 50});
  EXPECT_FALSE(watch.check(200, 200, 0.001));
  EXPECT_FALSE(watch.check(200, 155, 0.001)) << "22 % but within 50 min⁻¹";
  EXPECT_TRUE(watch.check(200, 149, 0.001));
  EXPECT_FALSE(watch.check(2000, 200, 0.001)) << "a new S";
  EXPECT_FALSE(watch.check(0, 200, 0.001)) << "stopping is no fluctuation";
  watch.set({});
  EXPECT_FALSE(watch.check(2000, 100, 0.001));
}

}  // namespace
}  // namespace headstock::axes

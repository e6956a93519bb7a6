// Reference return over a dog, what is not allowed before it, and that the machine knows where it is after
// it.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"
#include "limits.hpp"

namespace headstock::operation {
namespace {

machine::Machine with_dog(bool negative) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine::Axis& x = machine.axes[0];
  x.homing = machine::Homing::dog;
  x.home_negative = negative;
  x.dog_mm = negative ? -80 : 80;
  x.dog_width_mm = 20;
  x.grid_mm = 5;
  x.creep_mm_min = 240;
  x.rapid_mm_min = x.max_feed_mm_min = 6'000;
  x.min_mm = -100;
  x.max_mm = 100;
  return machine;
}

struct DogBench {
  explicit DogBench(const machine::Machine& machine, double standing_at)
      : DogBench(machine, standing_at, std::make_unique<axes::SimulatedDrive>(machine)) {}
  DogBench(const machine::Machine& machine, double standing_at, std::unique_ptr<axes::SimulatedDrive> made)
      : drive(made.get()), bench(machine, options(std::move(made))) {
    drive->place(0, standing_at);
  }
  static ControllerOptions options(std::unique_ptr<axes::Drive> drive) {
    ControllerOptions made;
    made.drive = std::move(drive);
    made.now_ms = [] { return std::int64_t{0}; };
    return made;
  }
  void mode(Mode wanted) { ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(wanted)).accepted); }
  axes::SimulatedDrive* drive;
  Bench bench;
};

TEST(Homing, OverTheDogToTheNextZeroMark) {
  for (const bool negative : {false, true}) {
    for (const double standing : {0.0, 13.7, -41.2}) {
      DogBench dog(with_dog(negative), standing);
      Bench& bench = dog.bench;
      EXPECT_EQ(bench.controller.live().homed & 1, 0u);
      dog.mode(Mode::reference);
      LimitsOnBench limits(bench);
      ASSERT_TRUE(bench.controller.reference_return(0).accepted);
      double fastest = 0;
      bool slow = false;
      ASSERT_TRUE(limits.until(
          [&] {
            const double v = std::abs(bench.controller.sample().velocity[0]);
            fastest = std::max(fastest, v);
            slow = slow || (fastest > 90 && v < 5 && v > 0);
            return slow && v == 0;
          },
          60))
          << standing;
      limits.expect_inside();
      ASSERT_TRUE(bench.until([&] { return (bench.controller.live().homed & 1) != 0; }, 5));
      EXPECT_GT(fastest, 90) << "rapid towards the dog";
      for (int i = 0; i < 500; ++i) bench.period();
      // The first mark behind the dog (80 ± 10, marks every 5).
      EXPECT_NEAR(dog.drive->true_position(0), negative ? -95 : 95, 1e-3) << standing;
      EXPECT_NEAR(bench.controller.live().machine[0], bench.controller.machine().axes[0].reference_mm, 1e-6);
      EXPECT_EQ(bench.state(), State::idle);
    }
  }
}

TEST(Homing, TwoReturnsFindTheSamePlaceAndTheSecondGoesThereAtOnce) {
  DogBench dog(with_dog(false), -20);
  Bench& bench = dog.bench;
  dog.mode(Mode::reference);
  ASSERT_TRUE(bench.controller.reference_return(0).accepted);
  ASSERT_TRUE(bench.until([&] { return (bench.controller.live().homed & 1) != 0; }, 60));
  for (int i = 0; i < 500; ++i) bench.period();
  const double first = dog.drive->true_position(0);
  dog.mode(Mode::jog);
  ASSERT_TRUE(bench.controller.step_axis(0, -30).accepted);
  for (int i = 0; i < 3000; ++i) bench.period();
  EXPECT_NEAR(dog.drive->true_position(0), first - 30, 1e-3);
  dog.mode(Mode::reference);
  ASSERT_TRUE(bench.controller.reference_return(0).accepted);
  for (int i = 0; i < 3000; ++i) bench.period();
  EXPECT_NEAR(dog.drive->true_position(0), first, 1e-3);
}

TEST(Homing, ADogTooShortForTheSpeedIsAnAlarmAndNoReferencePoint) {
  machine::Machine machine = with_dog(false);
  machine.axes[0].dog_width_mm = 1;
  DogBench dog(machine, 0);
  Bench& bench = dog.bench;
  dog.mode(Mode::reference);
  ASSERT_TRUE(bench.controller.reference_return(0).accepted);
  ASSERT_TRUE(bench.until_state(State::alarm, 30));
  EXPECT_EQ(bench.controller.live().alarms.front().code, "PS0090");
  EXPECT_EQ(bench.controller.live().homed & 1, 0u);
  EXPECT_FALSE(bench.controller.sample().moving);
}

TEST(Homing, BeforeItProgramsDoNotMoveTheAxis) {
  DogBench dog(with_dog(false), 0);
  Bench& bench = dog.bench;
  bench.load("O1\nG90 G94 G21\nG01 Y5. F1000.\nX5.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(bench.until_state(State::alarm, 20));
  EXPECT_EQ(bench.controller.live().alarms.front().code, "PS0224");
  EXPECT_EQ(bench.controller.sample().position[0], 0);
  EXPECT_NEAR(bench.controller.sample().position[1], 5, 1e-9) << "an axis that knows where it is moves";
}

TEST(Homing, BeforeItARapidJogIsAJogAndHasNoSoftLimit) {
  DogBench dog(with_dog(false), 0);
  Bench& bench = dog.bench;
  dog.mode(Mode::jog);
  ASSERT_TRUE(bench.controller.jog(0, 1, Controller::JogSpeed::rapid).accepted);
  for (int i = 0; i < 1000; ++i) bench.period();
  EXPECT_NEAR(bench.controller.sample().velocity[0], 1000.0 / 60, 0.05);
  bench.controller.jog(0, 0);
  for (int i = 0; i < 500; ++i) bench.period();
  EXPECT_FALSE(bench.controller.sample().moving);
}

TEST(Homing, ResetEndsTheSearchAndNothingIsSet) {
  DogBench dog(with_dog(false), 0);
  Bench& bench = dog.bench;
  dog.mode(Mode::reference);
  ASSERT_TRUE(bench.controller.reference_return(0).accepted);
  for (int i = 0; i < 200; ++i) bench.period();
  EXPECT_TRUE(bench.controller.sample().moving);
  bench.press(Action::reset);
  ASSERT_TRUE(bench.until_state(State::idle, 5));
  for (int i = 0; i < 500; ++i) bench.period();
  EXPECT_FALSE(bench.controller.sample().moving);
  EXPECT_EQ(bench.controller.live().homed & 1, 0u);
}

}  // namespace
}  // namespace headstock::operation

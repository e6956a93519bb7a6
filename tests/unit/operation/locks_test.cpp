// The real-time cycle takes no lock, allocates nothing, waits for nothing and calls nothing of the system,
// whatever the machine is doing: every such call inside a period is counted.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <thread>

#include "bench.hpp"
#include "forbidden_calls.hpp"

namespace headstock::operation {
namespace {

// ---- that it would be seen

template <typename Act>
std::uint64_t counted(Act act) {
  const ForbiddenCalls calls;
  act();
  return calls.count();
}

class CountedCalls : public testing::Test {
 protected:
  void SetUp() override {
    if (!ForbiddenCalls::watched()) GTEST_SKIP() << "a sanitizer has its own functions there";
  }
};

TEST_F(CountedCalls, ADeliberateLockIsSeen) {
  std::mutex mutex;
  EXPECT_GT(counted([&] { const std::lock_guard lock(mutex); }), 0u);
  EXPECT_GT(counted([&] {
              if (mutex.try_lock()) mutex.unlock();
            }),
            0u);
  std::recursive_mutex recursive;
  EXPECT_GT(counted([&] { const std::lock_guard lock(recursive); }), 0u);
  std::shared_mutex shared;
  EXPECT_GT(counted([&] { const std::shared_lock lock(shared); }), 0u);
  EXPECT_GT(counted([&] { const std::unique_lock lock(shared); }), 0u);
  std::condition_variable condition;
  EXPECT_GT(counted([&] { condition.notify_all(); }), 0u);
}

TEST_F(CountedCalls, WaitingMemoryAndTheSystemAreSeen) {
  std::atomic<int> waited{0};
  std::thread other([&] {
    waited = 1;
    waited.notify_all();
  });
  other.join();
  EXPECT_GT(counted([] { std::this_thread::sleep_for(std::chrono::microseconds(1)); }), 0u);
  EXPECT_GT(counted([] { std::this_thread::yield(); }), 0u);
  EXPECT_GT(counted([] { const auto kept = std::make_unique<std::vector<int>>(1000); }), 0u);
  EXPECT_GT(counted([] {
              void* volatile memory = std::malloc(10);
              std::free(memory);
            }),
            0u);
  EXPECT_GT(counted([] {
              char byte = 0;
              [[maybe_unused]] const auto n = ::read(-1, &byte, 1);
            }),
            0u);
  EXPECT_EQ(counted([&] { waited.store(2); }), 0u) << "an atomic is none";
}

TEST_F(CountedCalls, OutsideAPeriodNothingCounts) {
  std::mutex mutex;
  const ForbiddenCalls* none = nullptr;
  {
    const ForbiddenCalls calls;
    none = &calls;
    EXPECT_EQ(calls.count(), 0u);
  }
  ASSERT_NE(none, nullptr);
  { const std::lock_guard lock(mutex); }
  EXPECT_EQ(counted([] {}), 0u);
}

// ---- the machine

ControllerOptions servo_options() {
  ControllerOptions options;  // none given: the simulated servo drive
  options.now_ms = [] { return std::int64_t{0}; };
  return options;
}

/// A bench whose every period is watched.
class WatchedBench {
 public:
  explicit WatchedBench(machine::Machine machine, ControllerOptions options = servo_options())
      : bench(std::move(machine), std::move(options)) {}
  explicit WatchedBench(const std::string& profile) : WatchedBench(*machine::default_machine(profile)) {}
  ~WatchedBench() {
    EXPECT_EQ(calls, 0u) << "the last: " << last;
    EXPECT_GT(moving, 50u) << "nothing was looked at";
  }

  void period() {
    bench.commit();
    while (bench.controller.work()) {
    }
    {
      const ForbiddenCalls watched;
      bench.controller.step();
      calls += watched.count();
      if (watched.count() > 0) last = watched.last();
    }
    moving += bench.controller.sample().moving;
  }
  void periods(int n) {
    for (int i = 0; i < n; ++i) period();
  }
  template <typename Condition>
  ::testing::AssertionResult until(Condition condition, int most = 200'000) {
    for (int i = 0; i < most; ++i) {
      if (condition()) return ::testing::AssertionSuccess();
      period();
    }
    return ::testing::AssertionFailure()
           << "not within " << most << " periods, at line " << bench.controller.live().at.line;
  }
  ::testing::AssertionResult until_state(State state) {
    return until([&] { return bench.state() == state; });
  }
  ::testing::AssertionResult stands() {
    periods(5);
    return until([&] { return !bench.controller.sample().moving; });
  }
  /// Not before what a hand has ordered is done.
  void mode(Mode wanted) {
    ASSERT_TRUE(until([&] { return bench.press(Action::set_mode, static_cast<double>(wanted)).accepted; }));
  }
  double at(std::size_t axis) const { return bench.controller.sample().position[axis]; }

  Bench bench;
  std::uint64_t calls = 0, moving = 0;
  std::string last;
};

TEST(NoLockInTheCycle, ProgramHoldOverridesSingleBlockResetEmergencyStop) {
  WatchedBench run("fanuc-0i-t");
  Bench& bench = run.bench;
  bench.load(
      "O1\nG21 G98\nG50 S2000\nG96 S150 M03\nT0101\nM08\nG00 X40. Z2.\nG01 Z-20. F3000.\nG02 X50. Z-25. R5.\n"
      "G04 P300\nG99 G01 X60. F0.5\nM01\nM09\nM05\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until([&] { return bench.controller.cutting() && run.at(1) < -3; }));
  bench.press(Action::feed_hold);
  ASSERT_TRUE(run.stands());
  ASSERT_TRUE(bench.start());
  for (int i = 0; i < 300; ++i) {
    bench.press(Action::set_feed_override, 0.01 * (i % 255));
    bench.press(Action::set_rapid_override, i % 4 * 0.25);
    bench.press(Action::set_spindle_override, 0.5 + 0.01 * (i % 70));
    run.period();
  }
  bench.press(Action::set_feed_override, 1);
  bench.press(Action::set_rapid_override, 1);
  bench.press(Action::set_single_block, 1);
  ASSERT_TRUE(run.until([&] { return bench.state() != State::running; }));
  bench.press(Action::set_single_block, 0);
  bench.start();
  ASSERT_TRUE(run.until_state(State::idle));

  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until([&] { return run.at(1) < -3; }));
  ASSERT_TRUE(bench.press(Action::reset).accepted);
  ASSERT_TRUE(run.until_state(State::idle));
  bench.press(Action::set_dry_run, 1);
  bench.press(Action::set_machine_lock, 1);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until_state(State::idle));
  bench.press(Action::set_machine_lock, 0);
  bench.press(Action::set_dry_run, 0);
  run.periods(10);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until([&] { return run.at(1) < -3; }));
  bench.press(Action::emergency_stop);
  run.periods(500);
  bench.press(Action::emergency_stop_release);
  ASSERT_TRUE(run.until_state(State::idle));
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until_state(State::idle));
}

TEST(NoLockInTheCycle, Threads) {
  WatchedBench run("fanuc-0i-t");
  Bench& bench = run.bench;
  bench.load(
      "O1\nG21 G97 S600 M03\nG00 X30. Z10.\nG92 X28. Z-20. F2.\nX27.\nG00 X40. Z10.\nG34 Z-20. F2. K0.05\n"
      "G26\nG04 P500\nG25\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until([&] { return bench.controller.sample().threading; }));
  bench.press(Action::feed_hold);
  run.periods(100);
  ASSERT_TRUE(run.stands());
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until_state(State::idle));
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until([&] { return bench.controller.sample().threading; }));
  ASSERT_TRUE(bench.press(Action::reset).accepted);
  ASSERT_TRUE(run.until_state(State::idle));
}

TEST(NoLockInTheCycle, AccelerationBehindTheInterpolation) {
  WatchedBench run("fanuc-0i-m");
  Bench& bench = run.bench;
  ASSERT_TRUE(bench.controller
                  .edit_data(
                      [](interp::MachineData& data) {
                        for (const char* name : {"X", "Y", "Z"}) {
                          data.parameters[std::string("1622/") + name] = 80;  // exponential
                          data.parameters[std::string("1769/") + name] = 40;  // linear
                          data.parameters[std::string("1660/") + name] = 800;
                        }
                        data.parameters["1602#6"] = 1;
                        data.parameters["1772"] = 50;
                      },
                      {}, "test")
                  .accepted);
  bench.load("O1\nG90 G94 G21\nG01 X20. F3000.\nY20.\nG05.1 Q1\nX0.\nY0.\nG05.1 Q0\nG00 X30.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until([&] { return run.at(0) > 5; }));
  bench.press(Action::feed_hold);
  ASSERT_TRUE(run.stands());
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until_state(State::idle));
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until([&] { return run.at(1) > 5; }));
  ASSERT_TRUE(bench.press(Action::reset).accepted);
  ASSERT_TRUE(run.until_state(State::idle));
}

TEST(NoLockInTheCycle, TapsAndPullingOneOut) {
  WatchedBench run("fanuc-0i-m");
  Bench& bench = run.bench;
  bench.load("O1\nG90 G94 G21 G00 Z0.\nM29 S600\nG99 G84 Z-20. R-5. F900.\nG80\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until_state(State::idle));
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until([&] { return run.at(2) < -12; }));
  ASSERT_TRUE(bench.press(Action::reset).accepted);
  ASSERT_TRUE(run.until_state(State::idle));
  ASSERT_TRUE(run.stands());
  ASSERT_TRUE(bench.press(Action::tap_retract).accepted);
  ASSERT_TRUE(run.until([&] { return run.at(2) == -5; }));
  run.periods(50);
}

TEST(NoLockInTheCycle, AlarmsOfProgramTravelServoAndSpindle) {
  const machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  auto made = std::make_unique<axes::SimulatedDrive>(machine);
  axes::SimulatedDrive* drive = made.get();
  ControllerOptions options = servo_options();
  options.drive = std::move(made);
  WatchedBench run(machine, std::move(options));
  Bench& bench = run.bench;
  const auto raised_by = [&](const std::string& program) {
    bench.load(program, "O" + std::to_string(2 + bench.events.size()));
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(run.until_state(State::alarm));
    ASSERT_TRUE(bench.press(Action::reset).accepted);
    ASSERT_TRUE(run.until_state(State::idle));
  };
  raised_by("O1\nG90 G94 G21\nG01 X5. F3000.\n#3000=7\nM30\n");
  raised_by("O1\nG90 G94 G21\nG00 X99999.\nM30\n");
  bench.load("O1\nG90 G94 G21\nG01 X-50. F3000.\nM30\n");
  ASSERT_TRUE(bench.start());
  const double from = run.at(0);
  ASSERT_TRUE(run.until([&] { return run.at(0) < from - 2; }));
  drive->jam(0, true);
  ASSERT_TRUE(run.until_state(State::alarm));
  drive->jam(0, false);
  run.periods(300);
  ASSERT_TRUE(bench.press(Action::reset).accepted);
  ASSERT_TRUE(run.until_state(State::idle));
}

TEST(NoLockInTheCycle, ByHand) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.axes[0].homing = machine::Homing::dog;
  machine.axes[0].dog_mm = 20;
  machine.axes[0].dog_width_mm = 20;
  machine.axes[0].grid_mm = 5;
  machine.axes[0].rapid_mm_min = 6'000;
  machine.axes[1].backlash_um = 10;
  machine::Axis b;
  b.name = 'B';
  b.rotary = b.plc = true;
  machine.axes.push_back(b);
  WatchedBench run(machine);
  Bench& bench = run.bench;
  run.mode(Mode::reference);
  ASSERT_TRUE(bench.controller.reference_return(0).accepted);
  ASSERT_TRUE(run.until([&] { return (bench.controller.live().homed & 1) != 0; }));
  run.mode(Mode::jog);
  ASSERT_TRUE(bench.controller.jog(1, 1).accepted);
  run.periods(500);
  bench.controller.jog(1, 0);
  ASSERT_TRUE(run.stands());
  ASSERT_TRUE(bench.controller.jog(1, -1, Controller::JogSpeed::rapid).accepted);
  run.periods(200);
  bench.press(Action::reset);
  ASSERT_TRUE(run.stands());
  ASSERT_TRUE(run.until_state(State::idle));
  run.mode(Mode::handle);
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(bench.controller.step_axis(2, i % 2 ? 0.1 : -0.2).accepted);
    run.periods(20);
  }
  ASSERT_TRUE(run.stands());
  run.mode(Mode::memory);

  // In a held program: away, back by cycle start, back along the path by the handle, an axis of the ladder.
  bench.load("O1\nG90 G94 G21\nG01 X-20. Y-20. F1200.\nX-40.\nG03 X-50. Y-30. R10.\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until([&] { return bench.controller.live().at.line == 4; }));
  ASSERT_TRUE(bench.controller.move_plc_axis(3, 20, 600).accepted);
  run.periods(100);
  bench.press(Action::feed_hold);
  ASSERT_TRUE(run.until([&] { return bench.state() == State::hold; }));
  ASSERT_TRUE(run.stands());
  run.mode(Mode::handle);
  ASSERT_TRUE(bench.controller.retrace(-5).accepted);
  run.periods(100);
  ASSERT_TRUE(run.stands());
  run.mode(Mode::jog);
  ASSERT_TRUE(bench.controller.jog(2, 1).accepted);
  run.periods(200);
  bench.controller.jog(2, 0);
  ASSERT_TRUE(run.stands());
  run.mode(Mode::memory);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until_state(State::idle));
}

TEST(NoLockInTheCycle, SkipInterruptionOrientationContourAxisAndPolygon) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-t");
  machine.interruption_input = true;
  machine::Axis b;
  b.name = 'B';
  b.rotary = true;
  b.rapid_mm_min = b.max_feed_mm_min = 1'000'000;
  b.max_acceleration_mm_s2 = 40'000;
  b.max_jerk_mm_s3 = 4'000'000;
  b.min_mm = -1e6;
  b.max_mm = 1e6;
  machine.axes.push_back(b);
  machine.polygon_axis = 'B';
  machine.skip_input = true;
  ControllerOptions options = servo_options();
  options.skip_input = true;
  WatchedBench run(machine, std::move(options));
  Bench& bench = run.bench;
  bench.controller.edit_data([](interp::MachineData& data) { data.parameters["7610"] = 3; }, {}, "test");
  bench.programs->texts["O13"] = "O13\nG04 P100\nM99\n";
  bench.load(
      "O1\nG98 G21 G97\nG00 X60. Z5.\nG31 Z-5. F300.\nM96 P13\nG01 Z-20. F600.\nM97\nM03 S500\n"
      "G51.2 P1 Q2\nG01 Z-25. F300.\nG50.2\nM19\nM05\nM30\n");
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until([&] { return bench.controller.cutting() && run.at(1) < 3; }));
  bench.controller.set_skip_signals(1);
  run.periods(50);
  bench.controller.set_skip_signals(0);
  ASSERT_TRUE(run.until([&] { return run.at(1) < -8; }));
  bench.controller.set_interruption_signal(true);
  bench.controller.set_interruption_signal(false);
  ASSERT_TRUE(run.until([&] { return bench.state() == State::idle || bench.state() == State::alarm; }));
  EXPECT_EQ(bench.state(), State::idle);
}

TEST(NoLockInTheCycle, DataThatRunOut) {
  WatchedBench run("fanuc-0i-m");
  Bench& bench = run.bench;
  auto feeder = std::make_shared<Feeder>();
  feeder->text = "G90 G94 G21\n";
  for (int i = 1; i <= 400; ++i) feeder->text += "G01 X" + std::to_string(i) + ". F6000.\n";
  feeder->text += "M30\n";
  feeder->released = 1000;
  ASSERT_TRUE(bench.press(Action::set_mode, static_cast<double>(Mode::remote)).accepted);
  ASSERT_TRUE(
      bench.controller.select_stream("line", "hash", std::make_unique<FedSource>(feeder), 0).accepted);
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until_state(State::hold));
  feeder->released = feeder->text.size();
  feeder->closed = true;
  ASSERT_TRUE(bench.start());
  ASSERT_TRUE(run.until_state(State::idle));
}

}  // namespace
}  // namespace headstock::operation

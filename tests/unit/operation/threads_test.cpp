// The arrangement of the agent: a real-time, a look-ahead, a storage and some asking threads at once. Run
// under tsan.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "bench.hpp"

namespace headstock::operation {
namespace {

TEST(Threads, PartsAreCountedWhileEverybodyAsks) {
  ControllerOptions options;
  Bench bench("fanuc-0i-m", std::move(options));
  bench.load("O1\nG90 G94 G21\nM03 S100\nG01 X3. F6000.\nG02 X6. Y0. I1.5 J0.\nG01 X0.\nG04 P10\nM05\nM30\n");
  Controller& controller = bench.controller;
  constexpr std::uint64_t kParts = 5;
  std::atomic<bool> over{false};
  std::atomic<std::uint64_t> stored_parts{0}, lives{0}, torn{0};

  std::thread realtime([&] {
    // As fast as it can, but not faster than the look-ahead gets the lock.
    while (!over) {
      for (int i = 0; i < 16; ++i) controller.step();
      std::this_thread::yield();
    }
  });
  std::thread look_ahead([&] {
    while (!over)
      if (!controller.work()) std::this_thread::yield();
  });
  std::thread storage([&] {
    std::uint64_t taken = 0;
    TimedEvent event;
    while (!over) {
      bool any = false;
      while (controller.take_event(event)) {
        ++taken;
        any = true;
        if (std::holds_alternative<PartCounted>(event.event)) ++stored_parts;
      }
      if (any) controller.committed(taken);
      std::this_thread::yield();
    }
  });
  std::thread screen([&] {
    while (!over) {
      const Live live = controller.live();
      ++lives;
      // One instant: absolute follows machine with the work zero at the machine's.
      for (int i = 0; i < 3; ++i)
        if (std::abs(live.absolute[static_cast<std::size_t>(i)] - live.machine[static_cast<std::size_t>(i)]) >
            1e-9)
          ++torn;
      std::this_thread::yield();
    }
  });

  std::uint64_t started = 0;
  for (std::uint64_t presses = 0; stored_parts < kParts || controller.live().state != State::idle;
       ++presses) {
    const State state = controller.live().state;
    if (state == State::idle && stored_parts == started && started < kParts)
      started += controller.command({Action::cycle_start, Origin::panel, 0}).accepted;
    else if (state == State::running && presses % 50 == 0)
      controller.command({Action::feed_hold, Origin::network, 0});
    else if (state == State::hold)
      controller.command({Action::cycle_start, Origin::panel, 0});
    std::this_thread::yield();
  }
  over = true;
  for (std::thread* thread : {&realtime, &look_ahead, &storage, &screen}) thread->join();
  EXPECT_EQ(stored_parts, kParts);
  EXPECT_EQ(controller.live().parts, kParts);
  EXPECT_GT(lives, 0u);
  EXPECT_EQ(torn, 0u);
}

}  // namespace
}  // namespace headstock::operation

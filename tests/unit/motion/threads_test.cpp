// The look-ahead and the real-time side on two real threads; meant for the thread sanitizer as well.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <thread>

#include "rig.hpp"

namespace headstock::motion {
namespace {

TEST(KernelThreads, LimitsAndPathHoldWhateverTheTiming) {
  const auto machine = rig::machine(2, 500, 2000, 50'000);
  std::vector<Move> moves;
  for (std::size_t i = 1; i <= 6000; ++i) {
    const double angle = 0.002 * static_cast<double>(i);
    moves.push_back(rig::line({50 * std::cos(angle) - 50, 50 * std::sin(angle)}, 100));
    moves.back().tag = i;
    moves.back().exact_stop = i % 1500 == 0;
  }
  for (const bool abort_midway : {false, true, false, true, false, true, false, true}) {  // timing is never the same
    auto kernel = std::make_unique<Kernel>(machine);
    kernel->set_position({});
    std::atomic<bool> stop{false};
    std::thread look_ahead([&] {
      for (std::size_t i = 0; i < moves.size() && !stop;) {
        if (kernel->can_push()) {
          kernel->push(moves[i++]);
        } else if (!kernel->plan()) {
          std::this_thread::yield();
        }
      }
      kernel->finish();
      while (!stop)
        if (!kernel->plan()) std::this_thread::yield();
    });
    PathError error(2);
    error.start({});
    for (const Move& move : moves) error.add(move);
    rig::Run run;
    LimitsCheck limits(2, 0.001);
    limits.add({});
    Sample sample;
    std::size_t moving = 0;
    for (;;) {
      sample = kernel->step({}, 0, 0);
      limits.add(sample.position);
      if (sample.moving || sample.tag > 0) error.sample(sample.position, sample.tag);
      moving += sample.moving ? 1 : 0;
      if (abort_midway && moving == 1000) kernel->abort();
      if (abort_midway ? kernel->aborted() : sample.queue_empty && sample.tag == moves.back().tag) break;
      if (!sample.moving) std::this_thread::yield();
    }
    stop = true;
    look_ahead.join();
    run.velocity = limits.max_velocity();
    run.acceleration = limits.max_acceleration();
    run.jerk = limits.max_jerk();
    EXPECT_EQ(rig::violations(machine, run), "");
    EXPECT_LE(error.max(), 0.01);
    if (abort_midway) {
      kernel->set_position(sample.position);  // and it can be used again, from the period on that takes this up
      while (!kernel->can_push()) kernel->step({}, 0, 0);
      Move back = rig::line({}, 100);
      back.tag = 1;
      kernel->push(back);
      kernel->finish();
      while (kernel->plan()) {
      }
      for (int i = 0; i < 10'000 && !(sample = kernel->step({}, 0, 0)).queue_empty; ++i) {
      }
    }
    const AxisVector& end = std::get<Line>(moves.back().geometry).end;
    EXPECT_NEAR(sample.position[0], abort_midway ? 0 : end[0], 1e-9);
    EXPECT_NEAR(sample.position[1], abort_midway ? 0 : end[1], 1e-9);
  }
}

}  // namespace
}  // namespace headstock::motion

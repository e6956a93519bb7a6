// The threads that make a controller run: one on a clock for the real-time part, one for the look-ahead. For simulated
// machines there is also a clock that runs as fast as the computer can while the axes move.
#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "agent/lateness.hpp"
#include "operation/controller.hpp"

namespace headstock::agent {

enum class Clock {
  real,  ///< a period is period_us of wall time; real-time scheduling where permitted
  fast   ///< simulated drives only: the next period begins when the last is done
};

class MachineClock {
 public:
  /// The controller must outlive the clock. The threads start here.
  MachineClock(operation::Controller& controller, Clock clock);
  ~MachineClock();
  MachineClock(const MachineClock&) = delete;
  MachineClock& operator=(const MachineClock&) = delete;

  /// Ends the threads. Afterwards lateness() may be read.
  void stop();
  /// How late the periods began. Precondition: stop() has returned.
  const Lateness& lateness() const { return lateness_; }
  /// Real-time scheduling was permitted.
  bool real_time() const { return real_time_; }

 private:
  void run_real_time(const std::stop_token& stop);
  void run_look_ahead(const std::stop_token& stop);
  void run_fast(const std::stop_token& stop);

  operation::Controller& controller_;
  Lateness lateness_;  // real-time thread
  std::atomic<bool> real_time_{false};
  std::jthread look_ahead_, periods_;
};

}  // namespace headstock::agent

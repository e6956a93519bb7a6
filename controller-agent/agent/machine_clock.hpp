// The threads that make a controller run: one on a clock for the real-time part, one for the look-ahead. For simulated
// machines there is also a clock that runs as fast as the computer can while the axes move.
#pragma once

#include <string>
#include <thread>

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

 private:
  void run_real_time(const std::stop_token& stop);
  void run_look_ahead(const std::stop_token& stop);
  void run_fast(const std::stop_token& stop);

  operation::Controller& controller_;
  std::jthread look_ahead_, periods_;
};

}  // namespace headstock::agent

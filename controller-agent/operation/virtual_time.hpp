// A controller run in virtual time on one thread, as fast as the computer can: for simulation, timing and
// tests. The same code as on the machine; only the clock differs.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "operation/controller.hpp"

namespace headstock::operation {

/// Options for a controller in virtual time: ideal drives, and a clock that counts periods.
ControllerOptions virtual_options(const interp::Switches& switches = {});

/// Programs with one main program, known as "main", and perhaps a place for its sub-programs.
std::shared_ptr<program::Programs> single_program(std::function<std::unique_ptr<program::Source>()> open,
                                                  std::shared_ptr<program::Programs> others = nullptr);

enum class RunEnd : std::uint8_t {
  completed,
  alarm,
  stopped,        ///< a program stop nobody answers (VirtualRun::answer_stops is off)
  stuck,          ///< nothing moves any more and never will: feed per revolution with the spindle standing
  out_of_budget,  ///< the callback said stop
  refused         ///< cycle start was refused: VirtualRun::reason
};

/// How long the calls of step() took: a histogram, so that hours of periods need no memory.
class PeriodCost {
 public:
  void add(std::uint64_t ns);
  /// @param share 0…1: the cost that this share of the periods does not exceed [µs], to 20 ns; 1 gives the
  /// maximum.
  double percentile_us(double share) const;

 private:
  static constexpr std::uint64_t kBin_ns = 20;
  std::array<std::uint64_t, 10'000> bins_{};
  std::uint64_t count_ = 0, max_ns_ = 0;
};

/// Runs one program to its end.
class VirtualRun {
 public:
  explicit VirtualRun(Controller& controller) : controller_(controller) {}

  bool answer_stops = true;        ///< M00, M01: cycle start is pressed at once
  std::string reason;              ///< of a refusal
  std::uint64_t periods = 0;       ///< made so far
  PeriodCost* cost = nullptr;      ///< measures step() when set; not owned
  std::vector<TimedEvent> events;  ///< taken from the controller; alarms are kept here too

  /// Presses cycle start and goes on until the run ends. `each_period` is called after every period while the
  /// program runs; false ends the run.
  RunEnd run(const std::function<bool()>& each_period);

  /// One period: all the look-ahead there is to do, then one step. For tests that press buttons in between.
  void period();

 private:
  void take_events();

  Controller& controller_;
  std::uint64_t taken_ = 0;
};

}  // namespace headstock::operation

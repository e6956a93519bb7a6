// How long a program takes on a machine, what it touches and whether an alarm would stop it, before any
// machine sees it: the controller itself in virtual time.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "interpreter/interpreter.hpp"
#include "machine/machine.hpp"

namespace headstock::operation {

struct RunAlarm {
  std::string code;  ///< as the controller prints it
  std::string text_en, text_zh;
  interp::SourcePosition at;
};

/// Limits of what an estimate may cost. Whatever is reached first ends it; `RunEstimate::complete` is false
/// then.
struct EstimateBudget {
  std::uint64_t max_blocks = 10'000'000;
  double max_machine_s = 24 * 3600.0;  ///< predicted machine time
  std::chrono::milliseconds max_wall{30'000};
  const std::atomic<bool>* cancel = nullptr;  ///< set from another thread
};

struct RunEstimate {
  bool complete = false;          ///< ran to the program's end or to an alarm
  std::string incomplete_reason;  ///< "budget" "cancelled" "stuck" (feed per revolution, spindle standing),
                                  ///< or the refusal
  double time_s = 0;              ///< M functions, dwell and tool changes included (plc::Times)
  double cutting_s = 0, rapid_s = 0;
  double length_mm = 0, cutting_length_mm = 0;  ///< of the programmed path
  std::uint64_t blocks = 0;                     ///< blocks that made an operation, counted each time
  machine::AxisVector min_mm{}, max_mm{};       ///< machine coordinates touched, slide position
  std::vector<RunAlarm> alarms;                 ///< the controller stops at the first
  std::vector<std::int32_t> tools;              ///< in the order of first use
  bool counts_part = false;
  std::map<std::int32_t, double> life_needed;  ///< tool life group → uses or seconds that the run takes of it
};

/// Opens the main program; called twice (length, run).
using OpenProgram = std::function<std::unique_ptr<program::Source>()>;

/// @param sub_programs may be empty. Any thread; the work is done on the caller's. Memory does not grow with
/// the program.
RunEstimate estimate(const machine::Machine& machine, const interp::MachineData& data, OpenProgram main,
                     std::shared_ptr<program::Programs> sub_programs, const interp::Switches& switches = {},
                     const EstimateBudget& budget = {});

}  // namespace headstock::operation

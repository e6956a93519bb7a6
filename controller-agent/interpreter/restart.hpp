// A program taken up in its middle.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "interpreter/canonical.hpp"
#include "interpreter/interpreter.hpp"
#include "interpreter/machine_data.hpp"

namespace headstock::interp {

struct RestartRun {
  RestartPoint point;
  std::uint32_t seen = 0;  ///< times the sequence number was passed
  bool reached = false;
  RestartState state;
  /// What the search writes: that has been written by the run that was broken off. While the search is at
  /// work it stands in Executor::data, and the machine's data here.
  std::unique_ptr<MachineData> data;
};

}  // namespace headstock::interp

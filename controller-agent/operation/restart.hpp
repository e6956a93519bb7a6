// A restart under way (restart.cpp). Look-ahead, under the controller's lock.
#pragma once

#include <deque>
#include <memory>

#include "interpreter/interpreter.hpp"
#include "operation/breakpoint.hpp"
#include "program/source.hpp"

namespace headstock::operation {

struct Restart {
  std::unique_ptr<program::Source> source;  ///< before the search begins
  interp::RestartPoint point;
  bool found = false;  ///< the block is found, the axes are still where they were
  RestartReport report;
  std::deque<interp::Operation> approach;  ///< moves there, one axis each
};

}  // namespace headstock::operation

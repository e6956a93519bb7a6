// G31: moves that a signal ends.
#pragma once

#include "machine/axes.hpp"

namespace headstock::interp {

/// How the last skip move ended: what #5061… show.
struct SkipState {
  machine::AxisVector machine{};  ///< slide position; the programmed end where no signal came
  bool triggered = false;         ///< a signal ended it
};

}  // namespace headstock::interp

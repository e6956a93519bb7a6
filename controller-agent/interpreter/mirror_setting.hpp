// Mirror image by a setting (0i-D 10.10, No.0012#0): not a code of the program. From where the axis stands
// when it is switched on, every motion of a program goes the other way, whatever zero points and offsets do
// meanwhile.
#pragma once

#include <cstdint>

#include "machine/axes.hpp"

namespace headstock::interp {

struct MirrorSetting {
  std::uint32_t axes = 0;    ///< bit: axis
  machine::AxisVector at{};  ///< where each was switched on, machine coordinates, slide mm
};

}  // namespace headstock::interp

// The fixed-size vector of axis values that every layer of the controller shares.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace headstock::machine {

/// Most axes one path can drive (DESIGN: "up to 8 axes and 2 spindles").
inline constexpr std::size_t kMaxAxes = 8;

/// One value an axis, in the order of Machine::axes; mm for linear axes, degrees for rotary ones. Unused entries are 0.
using AxisVector = std::array<double, kMaxAxes>;

}  // namespace headstock::machine

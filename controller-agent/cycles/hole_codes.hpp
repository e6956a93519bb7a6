// Which code drills, bores or taps how on which control: tables.
#pragma once

#include <cstdint>
#include <span>

#include "cycles/holes.hpp"
#include "cycles/rules.hpp"

namespace headstock::cycles {

struct HoleCode {
  std::int16_t tenths;
  const char* name;
  HoleKind kind;
  char axis = 0;       ///< drilling axis where the code says so
  bool rigid = false;  ///< always in step with the spindle
};

/// Any thread; constants.
std::span<const HoleCode> hole_codes(HoleFamily family);
/// @return nullptr when the control has no such cycle.
const HoleCode* hole_code(HoleFamily family, std::int16_t tenths);

}  // namespace headstock::cycles

// Turns the moves of a hole cycle into canonical operations, hole after hole.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "cycles/holes.hpp"
#include "cycles/small_holes.hpp"
#include "interpreter/executor.hpp"

namespace headstock::cycles {

struct Target {
  std::uint32_t axes = 0;         ///< that move to the hole
  interp::AxisVector step{};      ///< nano units; added for every repetition when incremental
  std::uint32_t incremental = 0;  ///< axes whose step is an increment
};

struct HoleJob {
  Hole hole;
  std::optional<SmallHole> small;      ///< instead of `hole`
  std::size_t axis = 0;                ///< drilling axis
  std::array<std::size_t, 2> plane{};  ///< the two axes that a shift may use; `axis` where there is none
  Target target;
  std::int64_t times = 1;
  std::int32_t clamp_m = 0;  ///< clamps the rotary axis at the hole; the next number frees it. 0: none
  bool stops = false;        ///< single block stops at the hole, at R and behind the hole (0i-D L32090)
};

/// Starts the cycle: its moves are made before the next block is read.
void start_holes(interp::Executor& ex, const char* name, const HoleJob& job);

}  // namespace headstock::cycles

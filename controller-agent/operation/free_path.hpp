// Positioning that is not interpolated (0i-D No. 1401#1 = 0, 4.1): every axis goes to its end at its own rate, without
// waiting for the others. The path that they draw together, as the kernel can follow it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "machine/machine.hpp"

namespace headstock::operation {

/// How one axis goes from rest to rest.
struct AxisCourse {
  double way_mm = 0;               ///< signed
  double rate_mm_s = 0;            ///< > 0
  double acceleration_mm_s2 = 0;   ///< > 0, of braking too

  double time_s() const;
  /// Part of the way behind it [mm, signed]. @param time_s since the start, 0 and more
  double at(double time_s) const;
};

/// As many corners as a path has at most.
inline constexpr std::size_t kMostFreePieces = 24;

/// Corners of a polyline from `from` (left out) to the end (exact); one when all axes are there together. Straight
/// stretches are one piece, bends are cut finely enough that rounding the corners gives the bend.
/// @param courses of the first axes; the others stand
std::vector<machine::AxisVector> free_path(const machine::AxisVector& from, std::span<const AxisCourse> courses);

}  // namespace headstock::operation

// The programmed path as a curve over its length: what the operator's program says, before any rounding.
#pragma once

#include <cstddef>

#include "motion/kernel.hpp"

namespace headstock::motion {

/// One move's geometry by length u in 0…length. |d point/du| is 1 (on a spiral: at most 1).
struct Curve {
  AxisVector start{};
  AxisVector end{};
  AxisVector direction{};  ///< of a line, and of an arc's linear axes: change per mm of length
  double length = 0;
  bool is_arc = false;
  std::size_t axis_1 = 0, axis_2 = 1;
  double center_1 = 0, center_2 = 0;
  double angle_0 = 0;        ///< of the start point, rad
  double angle_per_mm = 0;   ///< signed
  double radius = 0;         ///< at the start
  double radius_per_mm = 0;  ///< not 0 on a spiral

  /// @param axes how many of AxisVector's entries are used
  static Curve from(const AxisVector& start, const Move& move, std::size_t axes);

  /// @param outward multiplies the radius of an arc (1: the curve itself)
  AxisVector point(double u, double outward = 1) const;
  AxisVector tangent(double u) const;
};

double distance(const AxisVector& a, const AxisVector& b);
/// What 1 mm or 1 degree of each axis counts where a tolerance in mm is meant: rotary axes have their own.
AxisVector tolerance_weights(const machine::Machine& machine);

/// Moves shorter than this have no geometry [mm].
inline constexpr double kNoLength = 1e-7;

}  // namespace headstock::motion

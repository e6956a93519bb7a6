// Programmable mirror image (G51.1), scaling (G51) and rotation (G68): what stands between the position a
// program writes and the position in the work coordinate system.
//
// A written position is mirrored first, then scaled, then rotated; the centre of a later step is itself
// carried through the earlier ones, and a mirrored plane turns the other way (0i-D: "in the scaling mode the
// centre of the rotation is scaled too, its angle is not"). Offsets, work zero points and machine coordinates
// are not touched. Positions here are relative to the work zero point, in slide mm (X as radius) or degrees.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "machine/axes.hpp"

namespace headstock::interp {

struct Transform {
  std::uint32_t mirrored = 0;       ///< axes whose sign is changed
  machine::AxisVector mirror_at{};  ///< the mirror's place on each of them
  std::uint32_t scaled = 0;         ///< axes that are scaled
  machine::AxisVector scale_center{};
  machine::AxisVector factor{};  ///< ≠ 0; negative: mirrored as well
  bool rotated = false;
  std::size_t first = 0, second = 0;  ///< axes of the rotated plane
  double center_1 = 0, center_2 = 0;
  double angle_deg = 0;  ///< from the first to the second axis
  double cosine = 1, sine = 0;
  bool spatial = false;  ///< rotated about any axis instead (K2000TC G68.1 with I J K)
  std::array<std::size_t, 3> spatial_axes{};
  std::array<double, 3> spatial_center{};
  std::array<double, 9> matrix{};  ///< rows of the rotation

  bool active() const { return (mirrored | scaled) != 0 || rotated || spatial; }

  /// Written position → position in the work system.
  machine::AxisVector apply(machine::AxisVector position) const;
  /// The way back. Every step can be undone: factors are never 0.
  machine::AxisVector undo(machine::AxisVector position) const;
  /// A direction instead of a position: centres play no part.
  machine::AxisVector turn(machine::AxisVector direction) const;
  /// An arc in this plane runs the other way round.
  bool reverses(std::size_t axis_1, std::size_t axis_2) const;
  /// How much a radius in this plane grows: the larger factor of the two.
  double radius_factor(std::size_t axis_1, std::size_t axis_2) const;
  /// Axes that move although the program named only `written`.
  std::uint32_t also_moved(std::uint32_t written) const;

  void set_angle(double degrees);

 private:
  machine::AxisVector turn_in_space(machine::AxisVector vector, bool back) const;
};

}  // namespace headstock::interp

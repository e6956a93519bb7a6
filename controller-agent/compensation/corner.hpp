// A chamfer or a tangent arc between two segments that meet in a corner. Pure functions, any thread.
#pragma once

#include <cstdint>

#include "compensation/geometry.hpp"

namespace headstock::comp {

enum class CornerShape : std::uint8_t { none, chamfer, round };

/// What the number of a chamfer means.
enum class ChamferSize : std::uint8_t {
  cut_back,   ///< from the corner to both ends of the chamfer (0i-D ,C; K2000TC NC)
  own_length  ///< of the chamfer itself (GSK2000TC L)
};

enum class CornerFault : std::uint8_t {
  none,
  not_needed,  ///< the two run on into each other: nothing is inserted
  too_large    ///< one of the two is too short for it, or no such arc exists
};

struct CutCorner {
  CornerFault fault = CornerFault::none;
  Segment first, inserted, second;  ///< what is run instead of the two; meaningful without a fault
};

/// @param size of the chamfer, or the radius of the arc [mm], > 0
CutCorner cut_corner(const Segment& first, const Segment& second, CornerShape shape, double size,
                     ChamferSize meaning);

}  // namespace headstock::comp

// Length and end of a kernel move.
#pragma once

#include <cmath>

#include "axes/arc_path.hpp"
#include "motion/kernel.hpp"

namespace headstock::operation {

inline const machine::AxisVector& end_of(const motion::Move& move) {
  return std::visit([](const auto& geometry) -> const machine::AxisVector& { return geometry.end; },
                    move.geometry);
}

/// Over all axes [mm, degrees counted like mm]; a spiral by its mean radius.
inline double path_length(const machine::AxisVector& start, const motion::Move& move) {
  const auto distance = [&](const machine::AxisVector& end) {
    double sum = 0;
    for (std::size_t i = 0; i < end.size(); ++i) sum += (end[i] - start[i]) * (end[i] - start[i]);
    return std::sqrt(sum);
  };
  const auto* arc = std::get_if<motion::Arc>(&move.geometry);
  if (!arc) return distance(end_of(move));
  const axes::ArcPath path(start, *arc);
  machine::AxisVector across = arc->end;
  across[arc->axis_1] = start[arc->axis_1];
  across[arc->axis_2] = start[arc->axis_2];
  return std::hypot((path.start_radius() + path.end_radius()) / 2 * arc->angle_rad, distance(across));
}

}  // namespace headstock::operation

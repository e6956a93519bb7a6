// The shortest time along a curve (p, z(p)) under velocity, acceleration and jerk limits of both axes: what
// the kernel's time is measured against. Shares nothing with the kernel: unknowns are the squares of dp/dt on
// an even grid, the limits are rows on neighbouring unknowns, and a barrier method brings the sum of the
// times down (a local optimum of a problem whose second-order part is convex; started from almost standing
// still).
#pragma once

#include <functional>

namespace headstock::bench {

struct Wave {
  std::function<double(double)> slope, bend, twist;  ///< dz/dp and its first two derivatives
  double length = 0;                                 ///< p goes from 0 to here, from rest to rest
};
struct AxisLimits {
  double feed = 100;            ///< along the path [mm/s]
  double acceleration = 2'000;  ///< of each axis [mm/s²]
  double jerk = 1e12;           ///< of each axis [mm/s³]; 1e9 and above: not limited
};

/// @return seconds; `cells` of the grid
double optimal_time(const Wave& wave, const AxisLimits& limits, int cells);

}  // namespace headstock::bench

// Polar coordinate command (G16 … G15): the plane's first axis word is a radius, the second an angle.
#pragma once

namespace headstock::interp {

/// The last point commanded. Lengths in slide mm relative to the work zero point, before mirror, scaling,
/// rotation.
struct PolarCommand {
  bool on = false;
  bool fixed_pole = false;  ///< the pole stays where G16 put it; incremental radii add up
  bool known = false;       ///< a point has been commanded since G16
  double center_1 = 0, center_2 = 0;
  double radius = 0;
  double angle_deg = 0;
};

}  // namespace headstock::interp

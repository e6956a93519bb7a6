// Cylindrical (G07.1) and polar coordinate interpolation (G12.1): a program writes in a flat plane, the
// machine moves a rotary axis.
//
// In the mode the rotary axis counts in millimetres for everything up to the interpreter's last stage: arcs,
// compensation and corners know nothing of it. `Executor::next_on_machine` then turns every move into moves
// of the machine's axes: pieces whose straight connection in machine coordinates departs from the programmed
// path by at most kSurfaceTolerance_mm, each with the feed that keeps F along the programmed path (the axes'
// own limits are kept by the motion side: near the pole of G12.1 the rotary axis is the slow one). Pieces are
// made one at a time: no memory grows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "interpreter/canonical.hpp"

namespace headstock::interp {

/// Largest distance between the path made and the path programmed.
inline constexpr double kSurfaceTolerance_mm = 0.001;

enum class SurfaceKind : std::uint8_t { none, cylinder, polar };

/// The mode, as the last stage needs it.
struct Surface {
  SurfaceKind kind = SurfaceKind::none;
  std::size_t rotary = 0;
  std::size_t linear = 0;    ///< polar: the axis through the pole
  double mm_per_degree = 1;  ///< cylinder: radius × π/180
  double pole = 0;           ///< polar: slide position of the linear axis at the rotary axis' centre
  double side = 1;           ///< polar: the side of the pole the slide works on, +1 or −1
  double zero_deg = 0;       ///< polar: machine position of the rotary axis where the plane's first axis lies
  double work_zero_deg = 0;  ///< machine coordinate of the rotary axis' work zero point
  AxisVector mm_per_unit{};  ///< slide mm (degrees) of a programming unit

  AxisVector to_machine(const AxisVector& plane, double near_deg) const;
  AxisVector to_plane(const AxisVector& machine) const;
  /// Position page and work zero point of a move that ends at `machine`.
  void show(Motion& motion, const AxisVector& machine) const;
};

/// What the Executor keeps of the mode besides.
struct SurfaceMode {
  Surface now;        ///< kind none: no mode
  Surface last;       ///< of the move handed out last
  AxisVector from{};  ///< in the plane: end of the move handed out last
  double saved_mm_per_unit = 1, saved_diameter = 1, saved_zeros[5] = {};
  std::int64_t saved_increment = 0;
  bool saved_rotary = true, saved_rolls_over = false;
  Plane saved_plane = Plane::xy;
  int saved_first = -1, saved_second = -1;
};

/// One move on its way to the machine's axes.
class SurfacePath {
 public:
  /// Takes over a move given in the plane; `from` is where it begins, in the plane's coordinates.
  void begin(const Surface& surface, const Operation& move, const AxisVector& from);
  bool pieces_left() const { return left_; }
  /// The next piece, in machine coordinates.
  void piece(Operation& out);
  /// The rotary axis' machine position [degrees]: runs on over full turns.
  double rotary_deg = 0;

 private:
  AxisVector on_path(double t) const;  // plane coordinates at t of 0 … 1
  double departure(double t0, double t1, const AxisVector& m0, const AxisVector& m1) const;

  Surface surface_;
  Operation move_;
  AxisVector from_{}, end_{}, here_{};
  bool arc_ = false, left_ = false;
  std::size_t axis_1_ = 0, axis_2_ = 0;
  double center_1_ = 0, center_2_ = 0, start_angle_ = 0, sweep_ = 0, radius_0_ = 0, radius_1_ = 0;
  double length_ = 0;  // along the path [mm]
  double done_ = 0, step_ = 1;
};

}  // namespace headstock::interp

// Plane geometry of turning profiles: straight lines and arcs, where they cross a level, and pieces of them.
// Lengths in mm as the slides move (X as a radius).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace headstock::cycles {

/// u along the first axis of the plane (Z in ZX), v along the second (X).
struct Point {
  double u = 0, v = 0;
};

struct Segment {
  Point from{}, to{};
  bool rapid = false;  ///< programmed as G00
  bool arc = false;
  Point center{};      ///< of an arc
  double sweep = 0;    ///< of an arc, radians, > 0 counter-clockwise from u to v
  double dwell_s = 0;  ///< after it: a G04 of the profile
};

using Path = std::vector<Segment>;

/// Shorter than this is nothing [mm]: far below every control's increment, far above rounding of doubles.
inline constexpr double kTiny = 1e-7;

double radius_of(const Segment& s);
/// Point at a fraction of the way, 0…1.
Point at(const Segment& s, double t);
/// The piece between two fractions.
Segment piece(const Segment& s, double from, double to);
/// Fractions strictly inside the segment where it crosses v = level, in order. @return how many.
std::size_t crossings(const Segment& s, double level, std::array<double, 2>& t);
/// Least and greatest u of a piece.
std::array<double, 2> range_u(const Segment& s);
/// Least and greatest v of a piece.
std::array<double, 2> range_v(const Segment& s);
/// How far the segment goes against the direction given by `sign` along u (v): 0 when it is monotonic.
double against_u(const Segment& s, double sign);
double against_v(const Segment& s, double sign);

/// A change of coordinates that makes every roughing the same: cutting goes toward +u, material is taken off
/// from +v downward.
struct View {
  bool swapped = false;  ///< u and v exchanged: facing
  double sign_u = 1, sign_v = 1;

  Point to(Point p) const {
    return swapped ? Point{sign_u * p.v, sign_v * p.u} : Point{sign_u * p.u, sign_v * p.v};
  }
  Point back(Point p) const {
    return swapped ? Point{sign_v * p.v, sign_u * p.u} : Point{sign_u * p.u, sign_v * p.v};
  }
  /// Counter-clockwise becomes clockwise.
  bool mirrors() const { return (sign_u * sign_v < 0) != swapped; }
  Segment to(const Segment& s) const;
  Segment back(const Segment& s) const;
};

Path shifted(const Path& path, Point by);

/// A stretch of a path: segment index + fraction.
struct Stretch {
  double from = 0, to = 0;
};

/// The parts of `within` where the path is not above the level, in order.
std::vector<Stretch> not_above(const Path& path, double level, Stretch within);
Point point_at(const Path& path, double place);
/// Segments of a stretch, cut at its ends.
Path cut_out(const Path& path, Stretch stretch);

}  // namespace headstock::cycles

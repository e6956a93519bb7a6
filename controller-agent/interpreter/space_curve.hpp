// Curves in space that turn about a pole: three-point arcs, Archimedean and logarithmic spirals (K2000TC
// L2652-L3402). Pure geometry in slide mm; cut into chords by whoever carries them out.
#pragma once

#include <array>
#include <cstddef>

namespace headstock::interp {

using Point3 = std::array<double, 3>;

struct SpaceCurve {
  Point3 pole{};             ///< at the start; it moves with `leg`
  Point3 along{}, across{};  ///< unit vectors: towards the start, and 90° on in the sense of the turn
  double radius_from = 0, radius_to = 0;
  double angle = 0;          ///< turned altogether, radians, ≥ 0
  bool logarithmic = false;  ///< radius grows by a factor per turn, otherwise by a length
  Point3 leg{};              ///< straight way out of the plane, run in step with the angle

  double radius_at(double turned) const;
  Point3 at(double turned) const;
  /// The largest angle from `turned` on whose chord stays within `tolerance` of the curve.
  double chord(double turned, double tolerance) const;
};

enum class CurveError : unsigned char {
  none,
  straight,        ///< three points in a line: a straight move to the end
  no_normal,       ///< the normal is zero
  pole_off_plane,  ///< further than allowed
  pole_on_start,
  no_way,  ///< start and end are the same point
  radius   ///< a logarithmic spiral from or to its pole
};

/// Start, a point between, end. @return straight when they are in a line or coincide.
CurveError three_point_arc(const Point3& start, const Point3& middle, const Point3& end, SpaceCurve& out);

/// Format 1: the pole is the start or the end; `angle` radians are turned about it.
/// @param normal counter-clockwise about it; reverse it for a clockwise turn. Any length.
CurveError spiral_about_end(const Point3& start, const Point3& end, const Point3& normal, bool pole_is_end,
                            double angle, SpaceCurve& out);

/// Format 2: pole given, and turns beyond the angle between start and end.
/// @param off_plane how far the pole may be off the plane before it is projected onto it.
CurveError spiral_about_pole(const Point3& start, const Point3& end, const Point3& pole, const Point3& normal,
                             double extra_turns, bool logarithmic, double off_plane, SpaceCurve& out);

}  // namespace headstock::interp

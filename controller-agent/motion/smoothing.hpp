// Rounding: turns the programmed curves into one cubic spline over length that every derivative limit can
// live with.
//
// The spline is Schoenberg's: knots t on the programmed length, control point of each = the programmed path
// at the mean of three neighbouring knots. It reproduces straight lines with their length exactly, is C2
// everywhere (its third derivative is bounded: no jump in acceleration at any speed), has local support, and
// never needs a system solved. A corner with a knot on it and knots d away deviates by |change of tangent| *
// d / 6, so the tolerance gives d directly. A knot three times over makes the spline pass through a point: an
// exact stop. Runs of short segments take their knots without regard to the corners, as far apart as the
// tolerance allows and with distances that change gently; the control points are there means of the path,
// weighted by the hat over the three knots (straight lines are reproduced as before), so that neither the sag
// of the chords nor the rounding of the program's numbers shows in the acceleration. Inside arcs the control
// points are moved outward so that the spline lies on the arc (error below radius * (d/radius)^4 / 300).
//
// Not thread-safe; look-ahead thread.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <limits>

#include "motion/geometry.hpp"

namespace headstock::motion {

/// A piece of the spline: position = c[0] + c[1] u + c[2] u² + c[3] u³, u = length - begin.
struct Span {
  double begin = 0, end = 0;  ///< programmed length since the start of the path [mm]
  std::array<AxisVector, 4> c{};
  bool straight = false;    ///< c[2] and c[3] are zero
  bool stop = false;        ///< the path stops at `end`
  AxisVector stop_point{};  ///< where: the programmed end, not its rounded evaluation

  AxisVector position(double length) const {
    if (stop && length >= end) return stop_point;
    const double u = length - begin;
    AxisVector p;
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = c[0][i] + u * (c[1][i] + u * (c[2][i] + u * c[3][i]));
    return p;
  }
};

/// One programmed move on the path.
struct Piece {
  Curve curve;
  double begin = 0, end = 0;  ///< programmed length of the path
  double tolerance = 0;       ///< of the corner at its end
  bool stop = false;          ///< exact stop at its end
};

class Smoother {
 public:
  explicit Smoother(std::size_t axes) : axes_(axes) { weights_.fill(1); }
  /// @param weights tolerance_weights(): what of each axis counts against Piece::tolerance
  Smoother(std::size_t axes, const AxisVector& weights) : axes_(axes), weights_(weights) {}

  /// Forgets everything; the path starts at this length.
  void reset(double length);
  /// Appends a move. Precondition: its curve is not shorter than kNoLength.
  void add(const Piece& piece);
  /// The last move added ends at rest. @return false when there is none or it already does.
  bool stop_at_end();
  /// Next finished span. @return false: more moves (or a stop) are needed first.
  bool next(Span& out);

 private:
  struct Corner {
    double turn = 0;   ///< |change of tangent|
    double width = 0;  ///< knot distance it allows
    bool run = false;  ///< needs no knot of its own when knots are no further apart than `width`
    bool measured = false;
  };
  struct Node {
    Piece piece;
    Corner corner;
  };  // corner at the piece's end

  bool place_knots();
  static constexpr std::size_t kWindow = 10;  // corners to either side that may share a blend
  /// A corner of a run and those beside it.
  struct CornersNear {
    static constexpr std::size_t kMost = 2 * kWindow + 2;
    std::array<double, kMost> distance, turn;
    std::size_t count = 0;
    double known_to = std::numeric_limits<double>::infinity();  // distance
    /// How far off the path the spline is at most with knots `width` apart; infinite: not known.
    double error(double width) const;
  };
  bool known_ahead(std::size_t index) const;
  bool alone(std::size_t index) const;
  const Corner& measured(std::size_t index);
  /// Nearer than `reach`.
  CornersNear corners_near(std::size_t index, double reach) const;
  void emit_line(double begin, double end, double before, double after);
  void emit_arc(const Piece& piece, double before, double after);
  void knot(double t);
  enum class Placed : std::uint8_t { nothing, inside, at_corner };
  Placed place_in_run(double from);
  void place_line(double from, double before);
  AxisVector control(double t1, double t2, double t3);
  /// Hat-weighted mean of the path. @return false: not across corners of a run only
  bool mean_in_run(double t1, double t2, double t3, AxisVector& mean) const;
  void forget_passed();

  double tangent_change(const Curve& from, const Curve& to) const;

  std::size_t axes_;
  AxisVector weights_;
  std::deque<Node> nodes_;
  std::size_t placing_ = 0;        // the piece that goes on from the last knot
  std::size_t control_piece_ = 0;  // the piece the last control point lies on
  double width_before_ = 0;        // what the last knot allows
  double last_interval_ = 0;
  std::deque<double> knots_;         // the first six make the next span
  std::deque<AxisVector> controls_;  // control i belongs to knots i, i + 1, i + 2
};

}  // namespace headstock::motion

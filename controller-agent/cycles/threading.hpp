// G76: a thread in many passes.
#pragma once

#include <cstdint>

#include "cycles/move.hpp"
#include "cycles/single.hpp"

namespace headstock::cycles {

/// How the depth is shared out.
enum class DepthLaw : std::uint8_t {
  constant_area,  ///< pass n at Δd·√n: equal chips
  constant_depth  ///< pass n at Δd·n
};
/// What a cut may not be less than is added to.
enum class LeastFrom : std::uint8_t {
  last_pass,  ///< depth of the last pass + least
  root        ///< Δd·√(n-1) + least (2000TC L4890)
};
enum class Infeed : std::uint8_t {
  one_flank,
  zigzag  ///< both flanks by turns
};

struct Threading {
  Point start, end;                ///< where the tool stands; root at the thread's end
  double taper = 0;                ///< radius at the start minus radius at the end
  double height = 0;               ///< k, > 0 [mm, radius]
  double first_depth = 0;          ///< Δd, > 0
  double least = 0;                ///< Δd min, ≥ 0
  double finish = 0;               ///< d, ≥ 0, < height
  std::int64_t finish_passes = 1;  ///< m, ≥ 0
  double tip_angle_deg = 0;        ///< a; 0: straight in
  DepthLaw law = DepthLaw::constant_area;
  LeastFrom least_from = LeastFrom::last_pass;
  Infeed infeed = Infeed::one_flank;
  bool finish_straight =
      false;  ///< the finishing cuts go straight down from the last roughing cut (K2000TC s = 0)
  bool finish_at_start =
      false;  ///< the finishing cuts begin at the start point itself, roughing before it (s = 1)
  double lead_mm = 0;
  double angle_deg = 0;
  std::int64_t starts = 1;
  Runout runout;
  double arc_in = 0, arc_out = 0;  ///< see ThreadPass
};

/// Depth after pass n = 1, 2 … [mm, radius]: roughing to height - finish, then the finishing passes at full
/// height.
class Depths {
 public:
  explicit Depths(const Threading& job) : job_(job) {}
  /// @return false when all passes are made.
  bool next(double& depth);
  bool finishing() const { return finished_ > 0; }

 private:
  const Threading& job_;
  std::int64_t n_ = 0, finished_ = 0;
  double depth_ = 0;
};

/// An upper bound of the number of passes, known without making them.
double most_passes(const Threading& job);

/// The pass at one depth whose tool begins `shift` further along.
ThreadPass pass_at(const Threading& job, double depth, double shift);
/// Bound: passes × starts × (5 + the chords of the arcs).
Moves threading(Threading job);

}  // namespace headstock::cycles

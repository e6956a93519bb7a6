// G71, G72: stock removal in parallel cuts (roughing.cpp: type I, pockets.cpp: type II), G73: pattern
// repeating.
#pragma once

#include <cstdint>

#include "cycles/move.hpp"

namespace headstock::cycles {

struct Roughing {
  Point start{};               ///< A: where the tool stands
  Path profile{};              ///< from A' to B, as programmed; the move A → A' is not part of it
  bool approach_rapid = true;  ///< A → A' is a G00: the tool is fed in rapidly
  Point allowance{};           ///< Δw, Δu/2: shifts the profile, signed
  double depth = 0;            ///< Δd, > 0
  double retract = 0;          ///< e, ≥ 0
  bool facing = false;         ///< G72: cuts parallel to the second axis
  /// Last cut at the profile's first level, of what is left there; otherwise the contour pass takes it (GSK
  /// 2000TC).
  bool level_cut_at_start = true;
  bool contour_pass = true;          ///< follow the contour with the allowance at the end
  bool return_by_allowance = false;  ///< B → A + allowance → A instead of B → A
  /// Pockets: leave every cut along the contour (0i-D type II; K2000TC FCRPN = 1), otherwise follow it later.
  bool contour_out = true;
};

/// How a profile lies: which way cuts go, which way material is taken off.
View view_of(const Roughing& job);

/// How far the profile rises above the start point [mm]; > 0 cannot be roughed.
double above_start(const Roughing& job);

/// The longest step back of the profile along the cutting direction and along the depth [mm]; 0: monotonic.
struct Backward {
  double along = 0, across = 0;
};
Backward backward(const Roughing& job);

/// Cuts of type I. Bound: 4 moves a level, levels ≤ distance / depth + 1, one contour.
Moves parallel_cuts(Roughing job);
/// Cuts of type II, pocket after pocket. Needs a profile that is monotonic along the cuts.
Moves pocket_cuts(Roughing job);
/// Levels between the start point and the lowest point of the profile.
double levels(const Roughing& job);
/// Most moves that `parallel_cuts` or `pocket_cuts` can make.
std::size_t most_moves(const Roughing& job);

struct Pattern {
  Point start;
  Path profile{};
  bool approach_rapid = true;
  Point allowance{};        ///< Δw, Δu/2
  Point relief{};           ///< Δk, Δi (radius), signed
  std::int64_t passes = 1;  ///< ≥ 1
};

/// G73: the contour `passes` times, each time nearer. Bound: passes × (profile + 3).
Moves repeated_pattern(Pattern job);

}  // namespace headstock::cycles

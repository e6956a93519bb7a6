// Stored stroke check 1: how far along a move the axes may go before one of them would pass its limit.
// Geometry only; which alarm a controller shows is the business of operation/.
#pragma once

#include <cstddef>
#include <optional>
#include <variant>

#include "machine/machine.hpp"
#include "motion/kernel.hpp"

namespace headstock::axes {

using machine::AxisVector;

/// Axes stop this far before a limit they would pass: one least increment, so that rounding never shows a
/// passed limit.
inline constexpr double kStopBeforeLimit_mm = 0.001;

/// Where a move leaves the permitted travel.
struct Overtravel {
  std::size_t axis = 0;   ///< index into Machine::axes
  bool positive = false;  ///< the limit max_mm (true) or min_mm (false)
  double fraction = 0;    ///< 0…1 of the line's length or of the arc's angle that may still be run
  /// The part that may be run: ends kStopBeforeLimit_mm inside the limit. Its length may be zero.
  std::variant<motion::Line, motion::Arc> allowed;
};

/// First passing of a limit on the way from `start` along `geometry`; nothing when the whole move stays
/// inside. A move that ends exactly on a limit is inside. An axis that already stands outside may only move
/// inwards. Any thread; no allocation.
std::optional<Overtravel> find_overtravel(const machine::Machine& machine, const AxisVector& start,
                                          const std::variant<motion::Line, motion::Arc>& geometry);

/// Whether any point of the move comes nearer than `distance_mm` to a limit (there corners must not be
/// rounded); of rotary axes nearer than what counts as much in tolerances.
bool near_limit(const machine::Machine& machine, const AxisVector& start,
                const std::variant<motion::Line, motion::Arc>& geometry, double distance_mm);

}  // namespace headstock::axes

// Stored stroke check 2 (G22): a box in machine coordinates that the axes must not enter, or must not leave.
// Looked at before a move begins: a move that would pass the border is not begun at all. Geometry only.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "motion/kernel.hpp"

namespace headstock::axes {

using machine::AxisVector;

struct Zone {
  std::uint32_t axes = 0;  ///< bit i: axis i has limits; the box has no border along the others
  AxisVector least{}, most{};
  bool outside_forbidden = false;  ///< false: the inside is
};

/// Where a move first passes into what is forbidden.
struct Entry {
  std::size_t axis = 0;   ///< whose border it passes; of a move that begins in it, the first axis of the zone
  bool positive = false;  ///< that axis moves in the positive direction
};

/// Arcs are looked at in chords of 1° and a border 10 µm nearer than it is. A move that begins on the
/// forbidden side may only lead out of it. Any thread; no allocation.
std::optional<Entry> find_entry(const Zone& zone, const AxisVector& start,
                                const std::variant<motion::Line, motion::Arc>& geometry);

/// Does the axis path of the move come nearer to what is forbidden than `distance` (mm, of each axis) along
/// every axis of the zone? For what the axes may leave the programmed path by. A move inside what is
/// forbidden does. Any thread; no allocation.
bool comes_near(const Zone& zone, const AxisVector& start,
                const std::variant<motion::Line, motion::Arc>& geometry, const AxisVector& distance);

}  // namespace headstock::axes

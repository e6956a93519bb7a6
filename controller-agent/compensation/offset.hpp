// The path of a tool's centre beside the programmed contour: the offset vectors at each corner and the check
// whether what is between two corners still runs the programmed way. Pure functions, any thread.
//
// A contour is followed at the distance r on one side. At the end of each block the tool's centre stands at
// the block's end point plus a vector. How many vectors a corner has, and which, is the whole of G41/G42:
//
//   inside (the workpiece side is 180° or more)   one vector, to where both offset paths cross
//   outside, 90°-180°                             lines: one, to where both offset lines cross; an arc ends
//                                                 (begins) on its own normal and reaches that point by a line
//   outside, below 90°                            each path runs on by r beyond its normal; a line links them
//   outside, circular connection                  from normal to normal on an arc about the corner
//
// Sources: 0i-D 5003, 19607#2, digest d2 4.12; K2000TC L16193-L17330; GSK218T L7700-L7900; GSK2000TC
// L6100-L6547. Their figures are lost in part; the constructions are those that all four describe in words.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "compensation/geometry.hpp"

namespace headstock::comp {

/// What the tool's centre passes at the end of one block and the start of the next: vectors from the corner. Nearly
/// always one: only those that there are have a value and are copied.
struct Vectors {
  static constexpr std::size_t kMost = 8;
  union {
    Point at[kMost];
  };
  std::size_t count = 0;
  bool circular = false;  ///< at[0] → at[1] is an arc about the corner
  double turn = 0;        ///< its sense
  int bare = -1;  ///< index of the vector that is no offset at all (G50 within compensation); -1: none

  Vectors() {}
  explicit Vectors(Point only) : count(1) { at[0] = only; }
  Vectors(const Vectors& other) { *this = other; }
  Vectors& operator=(const Vectors& other) {
    at[0] = other.count > 0 ? other.at[0] : Point{};
    for (std::size_t i = 1; i < other.count; ++i) at[i] = other.at[i];
    count = other.count;
    circular = other.circular;
    turn = other.turn;
    bare = other.bare;
    return *this;
  }
  ~Vectors() = default;

  void add(Point vector) {
    if (count < kMost) at[count++] = vector;
  }
  Point first() const { return at[0]; }
  Point last() const { return at[count - 1]; }
};
inline Vectors single(Point vector) {
  return Vectors(vector);
}

/// Start-up and cancel: how the tool comes to the contour and leaves it.
enum class StartType : std::uint8_t {
  a,  ///< straight to the normal of the compensated block
  b   ///< at outside corners around the corner at the distance r
};

struct OffsetRules {
  StartType start = StartType::a;
  bool start_by_normal =
      false;  ///< type B, obtuse: by the normal of the start-up block, then to the crossing
  bool circular_outside = false;
};

/// The vector left (r > 0) or right (r < 0) of the end or start of a segment.
Point normal_at_end(const Segment& segment, double r);
Point normal_at_start(const Segment& segment, double r);

/// @param r signed: > 0 the tool is left of the path
/// @return no vectors: the offset paths of an inside corner do not meet (alarm 33 of all controls)
Vectors corner(const Segment& a, const Segment& b, double r, const OffsetRules& rules);
/// The same with directions that are known: of `a` at its end, of `b` at its start.
Vectors corner(const Segment& a, const Point& a_end, const Segment& b, const Point& b_start, double r,
               const OffsetRules& rules);
/// `a` leads from a point without offset to the start of `b`.
Vectors start_up(const Segment& a, const Segment& b, double r, const OffsetRules& rules);
/// `b` leads to a point without offset.
Vectors cancel(const Segment& a, const Segment& b, double r, const OffsetRules& rules);
/// The side changes between the two.
Vectors change_side(const Segment& a, double r_a, const Segment& b, double r_b);
/// The vector square to a direction (I J K of a block with G41/G42), on the tool's side.
Point normal_of(Point direction, double r);
/// G40 with I J K: the contour is taken to go on from `a` as a wall in that direction. Where the path beside
/// `a` meets the path beside the wall; no crossing: the normal at the end of `a` (K2000TC L17333).
Vectors cancel_at_wall(const Segment& a, Point direction, double r);
/// A circle about the corner from normal to normal (G39). `after`: the direction that the end is normal to.
Vectors corner_arc(const Segment& a, Point after, double r);

/// What runs between two corners: from block.from + start to block.to + end.
enum class Between : std::uint8_t {
  good,
  reversed,  ///< runs against the program (or, an arc, turns by more than half a turn more or less)
};
Between check(const Segment& block, Point start, Point end);

/// The blocks before and after one, as far as they are known and followed on the same side.
struct Neighbours {
  const Segment* all[2] = {nullptr, nullptr};
};

/// Deletes vectors that cross each other at the two ends of a block, the nearest pair first, never the last
/// ones of a corner (K2000TC L18078-L18145), and only where the straight way that is left cuts neither the
/// block nor its neighbours. @return reversed: it helped not; the vectors are as they were.
/// `straight`: the block is an arc that must run as a line now.
Between settle(const Segment& block, const Neighbours& beside, Vectors& start, Vectors& end, double r,
               bool& straight);

/// Whether the straight `b` is the floor of a groove: both its neighbours rise toward the tool.
bool is_groove(const Segment& a, const Segment& b, const Segment& c, double r);

/// Whether the straight way from one point to another keeps the distance r (less 0.001 mm) from the whole
/// block.
bool clears(const Segment& block, Point from, Point to, double r);

/// Leaves out vectors nearer than `limit` to the one before, in both axes.
void merge_near(Vectors& vectors, double limit);

}  // namespace headstock::comp

// Inside the pipeline only: an operation on its way with what is known of it. Entries are handed on by
// pointer and used again: an operation is moved once on its way in and once on its way out, however long it
// waits.
#pragma once

#include "interpreter/pipeline.hpp"

namespace headstock::interp {

struct PipelineKnown {
  enum class Role : std::uint8_t { body, start };

  CompensationMode mode;
  CornerRequest request;
  comp::Segment path;  ///< programmed, in the plane
  comp::Point ahead_at_start, ahead_at_end;  ///< its directions, see aim()
  comp::Point start_vector;
  BlockVector vector;
  Role role = Role::body;
  bool motion = false;
  bool plane_move = false;  ///< moves in the plane by more than nothing
  bool zero_move = false;   ///< a move in the plane by nothing
  bool lifted = false;      ///< runs without the vector
  bool free_start = false;  ///< starts at a vector that is not its own: not checked
  bool after_gap = false;   ///< the block before it was left out because of interference

  /// After every change of `path`.
  void aim() {
    ahead_at_start = path.direction_at_start();
    ahead_at_end = path.arc ? path.direction_at_end() : ahead_at_start;
  }
};

struct PipelineEntry : PipelineKnown {
  Operation op;

  /// Used again: nothing is known yet. What describe() and take() fill in for every motion stays as it is.
  void begin() {
    if (request.asked()) request = {};
    start_vector = {};
    vector.given = false;
    role = Role::body;
    motion = plane_move = zero_move = lifted = free_start = after_gap = false;
  }
};

}  // namespace headstock::interp

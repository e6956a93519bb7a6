// Canonical motions whose path in the plane is changed: ends moved, corners inserted. Inside of the pipeline.
#pragma once

#include "compensation/geometry.hpp"
#include "interpreter/canonical.hpp"

namespace headstock::interp {

struct Executor;
struct CompensationMode;

/// Shorter than this is no move: far below every controller's increment.
inline constexpr double kNoMove_mm = 1e-7;

/// How fast a motion runs, to be given to another one.
struct MotionFeed {
  bool rapid = false, linear = false;
  double feed = 0;
  FeedUnit unit = FeedUnit::mm_per_minute;
};
MotionFeed feed_of(const Operation& operation);

/// Moves the end of a motion in the plane; both coordinates of the motion follow.
void shift_end(const Executor& ex, Motion& motion, const CompensationMode& mode, comp::Point by);
/// The motion ends where `path` ends; an arc's angle follows.
void move_end(const Executor& ex, Operation& operation, const CompensationMode& mode,
              const comp::Segment& path);
/// If it is an arc: radius and angle are those of `path`, the centre moves by `center_shift`.
void set_arc(const Executor& ex, Operation& operation, const CompensationMode& mode,
             const comp::Segment& path, comp::Point center_shift);
/// A motion of its own, with the source, state and other axes of `like`, along `path` to `end`.
Operation motion_along(const Executor& ex, const Motion& like, const CompensationMode& mode, comp::Point end,
                       const comp::Segment& path, const MotionFeed& speed);
/// The same, made where it stays; `like` is not in it.
void put_motion(const Executor& ex, Operation& into, const Motion& like, const CompensationMode& mode,
                comp::Point end, const comp::Segment& path, const MotionFeed& speed);

}  // namespace headstock::interp

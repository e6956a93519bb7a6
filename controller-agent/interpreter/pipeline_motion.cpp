#include "interpreter/pipeline_motion.hpp"

#include <numbers>

#include "interpreter/executor.hpp"

namespace headstock::interp {
namespace {

using comp::Point;

// Slide mm of a programming unit of that axis, under the state a motion was read in.
double mm_per_unit(const Executor& ex, const ModalSnapshot& modal, std::size_t axis) {
  const ProgramAxis& a = ex.axes[axis];
  return a.diameter * (modal.inch && !a.rotary ? 25.4 : 1);
}

}  // namespace

MotionFeed feed_of(const Operation& operation) {
  if (const auto* feed = std::get_if<Feed>(&operation)) return {false, false, feed->feed, feed->unit};
  if (const auto* arc = std::get_if<Arc>(&operation)) return {false, false, arc->feed, arc->unit};
  if (const auto* rapid = std::get_if<Rapid>(&operation)) return {true, rapid->linear, 0, {}};
  return {true, true, 0, {}};
}

void shift_end(const Executor& ex, Motion& motion, const CompensationMode& mode, Point by) {
  const auto shift = [&](std::size_t axis, double mm) {
    if (mm == 0) return;
    motion.end_machine[axis] += mm;
    motion.end_work[axis] += mm / mm_per_unit(ex, motion.modal, axis);
    motion.axes |= 1u << axis;
  };
  shift(mode.first, by.u);
  shift(mode.second, by.v);
}

void set_arc(const Executor& ex, Operation& operation, const CompensationMode& mode,
             const comp::Segment& path, Point shift) {
  auto* arc = std::get_if<Arc>(&operation);
  if (arc == nullptr) return;
  arc->radius_mm = path.start_radius();
  arc->turns = path.sweep / (2 * std::numbers::pi);
  const auto move = [&](std::size_t axis, double mm) {
    arc->center_machine[axis] += mm;
    arc->center_work[axis] += mm / mm_per_unit(ex, arc->modal, axis);
  };
  move(mode.first, shift.u);
  move(mode.second, shift.v);
}

void move_end(const Executor& ex, Operation& operation, const CompensationMode& mode,
              const comp::Segment& path) {
  Motion& motion = *motion_in(operation);
  shift_end(ex, motion, mode,
            path.to - Point{motion.end_machine[mode.first], motion.end_machine[mode.second]});
  set_arc(ex, operation, mode, path, {});
}

namespace {

// What all moves have in common, written where it stays: `like`, ending elsewhere.
void begin_like(const Executor& ex, Motion& made, const Motion& like, const CompensationMode& mode,
                Point end) {
  made = like;
  made.axes = 0;
  made.exact_stop = false;
  shift_end(ex, made, mode, end - Point{made.end_machine[mode.first], made.end_machine[mode.second]});
}

void arc_along(const Executor& ex, Operation& into, const Motion& like, const CompensationMode& mode, Point end,
               const comp::Segment& path, const MotionFeed& speed) {
  Arc& arc = into.emplace<Arc>();
  begin_like(ex, arc, like, mode, end);
  arc.feed = speed.feed;
  arc.unit = speed.unit;
  arc.plane = mode.plane;
  arc.turn = path.turn > 0 ? Turn::ccw : Turn::cw;
  arc.center_work = arc.end_work;
  arc.center_machine = arc.end_machine;
  const auto set = [&](std::size_t axis, double mm) {
    arc.center_machine[axis] += mm;
    arc.center_work[axis] += mm / mm_per_unit(ex, arc.modal, axis);
  };
  set(mode.first, path.center.u - end.u);
  set(mode.second, path.center.v - end.v);
  arc.radius_mm = path.start_radius();
  arc.turns = path.sweep / (2 * std::numbers::pi);
}

void rapid_along(const Executor& ex, Operation& into, const Motion& like, const CompensationMode& mode, Point end,
                 const MotionFeed& speed) {
  Rapid& rapid = into.emplace<Rapid>();
  begin_like(ex, rapid, like, mode, end);
  rapid.linear = speed.linear;
}

void feed_along(const Executor& ex, Operation& into, const Motion& like, const CompensationMode& mode, Point end,
                const MotionFeed& speed) {
  Feed& feed = into.emplace<Feed>();
  begin_like(ex, feed, like, mode, end);
  feed.feed = speed.feed;
  feed.unit = speed.unit;
}

}  // namespace

void put_motion(const Executor& ex, Operation& into, const Motion& like, const CompensationMode& mode, Point end,
                const comp::Segment& path, const MotionFeed& speed) {
  if (speed.rapid) return rapid_along(ex, into, like, mode, end, speed);
  if (path.arc) return arc_along(ex, into, like, mode, end, path, speed);
  feed_along(ex, into, like, mode, end, speed);
}

Operation motion_along(const Executor& ex, const Motion& like, const CompensationMode& mode, Point end,
                       const comp::Segment& path, const MotionFeed& speed) {
  Operation made;
  put_motion(ex, made, like, mode, end, path, speed);
  return made;
}

}  // namespace headstock::interp

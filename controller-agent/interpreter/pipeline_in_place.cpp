// Stage 2, what not every control has: start-up and cancel without a move (type C), and interference that is
// avoided by leaving a block out.
#include <cmath>
#include <utility>

#include "interpreter/executor.hpp"
#include "interpreter/pipeline.hpp"
#include "interpreter/pipeline_entry.hpp"
#include "interpreter/pipeline_motion.hpp"

namespace headstock::interp {

using comp::Point;

// G41 or G42 stood in a block without a move: the tool goes square to the start of the next block first.
void Pipeline::step_onto_vector(Executor& ex, const Entry& entry) {
  kept_ = comp::normal_at_start(entry.path, entry.mode.radius);
  kept_mode_ = entry.mode;
  Operation copy = entry.op;
  Motion like = *motion_in(copy);
  like.end_machine = passed_machine_;
  like.end_work = passed_work_;
  const Point to = entry.path.from + kept_ + entry.mode.tip;
  send(ex, motion_along(ex, like, entry.mode, to, comp::line(entry.path.from, to), feed_of(entry.op)));
  on_ = true;
}

// G40 in a block without a move: off the vector square to the end of the last block.
void Pipeline::step_off_vector(Executor& ex) {
  settle_here(ex);
  if (stopped_) return;
  on_ = false;
  const Motion* last = motion_in(passed_);
  if (last == nullptr) return;
  Motion like = *last;
  like.end_machine = coming_machine_;
  like.end_work = coming_work_;
  const Point to{coming_machine_[kept_mode_.first], coming_machine_[kept_mode_.second]};
  send(ex, motion_along(ex, like, kept_mode_, to, comp::line(to + kept_, to), feed_of(passed_)));
}

// `last_` cannot be run: its neighbours are run up to where their own offset paths meet (0i-D CAV). Refused
// where they do not meet, or where the tool would cut into the block that is left out.
Pipeline::Closed Pipeline::leave_out(Executor& ex, const Entry& next) {
  const SourcePosition at = motion_in(last_->op)->at;
  const auto refuse = [&](AlarmReason reason) {
    raise(ex, reason, at, 0, {});
    return Closed::stopped;
  };
  const double r = last_->mode.radius;
  const bool alike = has_previous_ && previous_->role == PipelineKnown::Role::body &&
                     previous_->mode.radius == r && next.mode.radius == r && corner_.bare < 0;
  if (!alike) return refuse(AlarmReason::compensation_no_avoidance);
  const comp::Crossings meet =
      comp::intersect(comp::offset_curve(previous_->path, r, true), comp::offset_curve(next.path, r, false));
  if (meet.count == 0) return refuse(AlarmReason::compensation_no_avoidance);
  const Point middle = (last_->path.from + last_->path.to) * 0.5;
  Point at_point = meet.point[0];
  if (meet.count == 2 && comp::length(meet.point[1] - middle) < comp::length(at_point - middle))
    at_point = meet.point[1];
  const Point end = at_point - previous_->path.to, begin = at_point - next.path.from;
  // Neither the way to where they meet nor the way on from there may cut any of the three.
  const Point came_from = previous_->path.from + previous_->start_vector;
  const Point goes_to = next.path.to + comp::normal_at_end(next.path, r);
  bool safe = comp::check(previous_->path, previous_->start_vector, end) == comp::Between::good;
  const comp::Segment* const blocks[] = {&previous_->path, &last_->path, &next.path};
  for (const comp::Segment* block : blocks) {
    safe = safe && comp::clears(*block, at_point, at_point, std::fabs(r));
    if (!previous_->path.arc) safe = safe && comp::clears(*block, came_from, at_point, std::fabs(r));
    if (!next.path.arc) safe = safe && comp::clears(*block, at_point, goes_to, std::fabs(r));
  }
  if (!safe) return refuse(AlarmReason::compensation_danger);
  corner_ = comp::single(end);
  release_previous(ex, last_.get());
  for (EntryPtr& entry : after_) send_displaced(ex, std::move(entry));
  after_.clear();
  corner_ = comp::single(begin);
  has_last_ = false;
  return Closed::left_out;
}

}  // namespace headstock::interp

// Intake and stage 1: chamfers, corner rounds, open lines of drawing dimensions.
#include "interpreter/pipeline.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "interpreter/executor.hpp"
#include "interpreter/pipeline_entry.hpp"
#include "interpreter/pipeline_motion.hpp"

namespace headstock::interp {

using comp::CornerFault;
using comp::CornerShape;
using comp::Point;

Pipeline::Pipeline() = default;
Pipeline::Pipeline(Pipeline&& other) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&& other) noexcept = default;
Pipeline::~Pipeline() = default;

Pipeline::EntryPtr Pipeline::fresh() {
  if (spare_.empty()) return std::make_unique<Entry>();
  EntryPtr entry = std::move(spare_.back());
  spare_.pop_back();
  entry->begin();
  return entry;
}

void Pipeline::recycle(EntryPtr&& entry) {
  if (entry == nullptr) return;
  if (intake_ == nullptr) {  // the next block's
    entry->begin();
    intake_ = std::move(entry);
  } else {
    spare_.push_back(std::move(entry));
  }
}

// A motion that is run as it is.
void Pipeline::send_entry(Executor& ex, EntryPtr&& entry) {
  send(ex, std::move(entry->op));
  recycle(std::move(entry));
}

void Pipeline::clear() {
  Pipeline empty;
  empty.d_number = d_number;
  empty.intake_ = std::move(intake_);  // a block may clear while it emits
  empty.caller_ = caller_;
  *this = std::move(empty);
}

void Pipeline::open_intake(Executor& ex) {
  if (intake_ == nullptr) intake_ = fresh();
  caller_ = std::exchange(ex.out, &intake_->op);
}

void Pipeline::close_intake(Executor& ex) {
  if (caller_ == nullptr) return;
  ex.out = std::exchange(caller_, nullptr);
  if (ex.out_used) *ex.out = std::move(intake_->op);
}

void Pipeline::activate(const AxisVector& machine_position, const AxisVector& work_position) {
  if (!active_) {
    touch_ = lift_block_ = false;  // said of a block before this one, when nothing was compensated
    position_ = coming_machine_ = machine_position;
    coming_work_ = work_position;
  }
  active_ = true;
}

void Pipeline::close_line(const AxisVector& end_machine, const AxisVector& end_work, std::uint32_t moved) {
  Motion& motion = *motion_in(held_->op);
  motion.end_machine = end_machine;
  motion.end_work = end_work;
  motion.axes |= moved;
  held_->path.to = {end_machine[held_->mode.first], end_machine[held_->mode.second]};
  held_->plane_move = comp::length(held_->path.to - held_->path.from) > kNoMove_mm;
  held_->aim();
  held_->request.open = open_ = false;
  position_ = end_machine;
}

// Where the next operation goes.
Operation& Pipeline::place(Executor& ex) {
  ex.at_standstill = false;
  if (ex.out_used) return ex.queue.emplace_back();
  ex.out_used = true;
  return *ex.out;
}

void Pipeline::send(Executor& ex, Operation&& op) {
  ex.at_standstill = false;
  if (!ex.out_used) {
    ex.out_used = true;
    *ex.out = std::move(op);
  } else {
    ex.queue.push_back(std::move(op));
  }
}

void Pipeline::raise(Executor& ex, AlarmReason reason, const SourcePosition& at, std::uint32_t column,
                     std::string detail) {
  if (stopped_) return;
  abandon(ex);
  Alarm alarm;
  alarm.at = at;
  alarm.at.column = column;
  alarm.code = ex.dialect.alarm_code(reason);
  alarm.detail = std::move(detail);
  send(ex, std::move(alarm));
  ex.finished = true;
  ex.modal_memory.alarm_raised(at.block);
  stopped_ = true;
}

void Pipeline::describe(const Executor& ex, Entry& entry) {
  Motion* motion = motion_in(entry.op);
  entry.motion = motion != nullptr;
  if (motion == nullptr) return;
  const std::size_t u = entry.mode.first, v = entry.mode.second;
  const Point from{position_[u], position_[v]};
  const Point to{motion->end_machine[u], motion->end_machine[v]};
  if (const auto* arc = std::get_if<Arc>(&entry.op)) {
    if (arc->plane == entry.mode.plane) {
      entry.path.from = from;
      entry.path.to = to;
      entry.path.arc = true;
      entry.path.center = {arc->center_machine[u], arc->center_machine[v]};
      entry.path.turn = arc->turn == Turn::ccw ? 1 : -1;
      entry.path.sweep = arc->turns * (2 * std::numbers::pi);
      entry.plane_move = true;
      entry.aim();
    } else {
      entry.lifted = true;
    }
  } else {
    entry.path.from = from;
    entry.path.to = to;
    entry.path.arc = false;
    const Point way = to - from;
    const double length = comp::length(way);
    entry.ahead_at_start = entry.ahead_at_end = length > 0 ? way * (1 / length) : Point{1, 0};
    entry.plane_move = length > kNoMove_mm;
    entry.zero_move = !entry.plane_move && (motion->axes & (1u << u | 1u << v)) != 0;
  }
  const auto* rapid = std::get_if<Rapid>(&entry.op);
  const bool finishing = motion->cycle != nullptr && ex.dialect.compensated_cycle == motion->cycle;
  entry.lifted = entry.lifted || lift_block_ || (rapid != nullptr && rapid->machine_coordinates) ||
                 (motion->cycle != nullptr && !finishing) || std::holds_alternative<Thread>(entry.op);
  position_ = motion->end_machine;
}

void Pipeline::take(Executor& ex) {
  const auto come_in = [this](Operation& op) {
    EntryPtr entry = fresh();
    entry->op = std::move(op);
    incoming_.push_back(std::move(entry));
  };
  if (caller_ != nullptr) {
    ex.out = std::exchange(caller_, nullptr);
    if (ex.out_used) incoming_.push_back(std::move(intake_));
  } else if (ex.out_used) {
    come_in(*ex.out);
  }
  for (std::size_t i = ex.queue_head; i < ex.queue.size(); ++i) come_in(ex.queue[i]);
  ex.queue.clear();
  ex.queue_head = 0;
  ex.out_used = false;

  mode_of(ex);
  bool moved = false;
  for (EntryPtr& entry : incoming_) {
    if (stopped_) break;
    entry->mode = mode_;
    describe(ex, *entry);
    if (entry->motion) {
      if (request_.asked()) entry->request = std::exchange(request_, CornerRequest{});
      if (vector_.given) entry->vector = std::exchange(vector_, BlockVector{});
      moved = moved || entry->plane_move || entry->lifted || entry->request.open;
    }
    corners(ex, std::move(entry));
  }
  incoming_.clear();
  if (block_counts_ && !moved && !stopped_) {
    if (held_corner_) {
      if (++blocks_between_ > ex.dialect.corners.most_between) {
        raise(ex, held_->request.open ? AlarmReason::drawing_blocks : AlarmReason::corner_no_move,
              motion_in(held_->op)->at, held_->request.column, {});
      }
    } else {
      quiet_block(ex);
    }
  }
  block_counts_ = again_ = lift_block_ = written_here_ = false;
  if (request_.asked()) request_ = {};
  vector_.given = false;
  const bool busy = held_corner_ || on_ || has_last_ || has_previous_ || side_ != 0;
  if (!busy || stopped_) active_ = false;
  if (stopped_) clear();
}

void Pipeline::corners(Executor& ex, EntryPtr&& entry) {
  if (held_corner_) {
    if (entry->motion) return meet_corner(ex, std::move(entry));
    if (std::holds_alternative<Alarm>(entry->op)) {
      held_corner_ = false;
      corner_followers_.clear();
      return compensate(ex, std::move(entry));
    }
    if (std::holds_alternative<End>(entry->op)) {
      return raise(ex, held_->request.open ? AlarmReason::drawing_no_end : AlarmReason::corner_no_move,
                   motion_in(held_->op)->at, held_->request.column, {});
    }
    corner_followers_.push_back(std::move(entry));
    return;
  }
  if (entry->motion && entry->request.asked()) {
    open_ = entry->request.open;
    open_angle_deg_ = entry->request.angle_deg;
    held_ = std::move(entry);
    held_corner_ = true;
    blocks_between_ = 0;
    return;
  }
  compensate(ex, std::move(entry));
}

// The next motion after a block that asked for something at its corner.
void Pipeline::meet_corner(Executor& ex, EntryPtr&& next) {
  const CornerRequest request = held_->request;
  const SourcePosition at = motion_in(held_->op)->at;
  const auto fail = [&](AlarmReason reason) { raise(ex, reason, at, request.column, {}); };
  if (request.open) return fail(AlarmReason::drawing_no_end);

  const bool cuts =
      std::holds_alternative<Feed>(next->op) ||
      (std::holds_alternative<Arc>(next->op) && ex.dialect.corners.arcs && !request.perpendicular);
  if (request.shape != CornerShape::none) {
    if (!cuts || next->lifted) return fail(AlarmReason::corner_not_feed);
    if (!next->plane_move) return fail(AlarmReason::corner_no_move);
    if (next->mode.plane != held_->mode.plane) return fail(AlarmReason::corner_not_feed);
  }
  if (request.perpendicular) {
    const Point d = next->path.to - next->path.from;
    const double along = request.next_is_second ? d.v : d.u;
    const double across = request.next_is_second ? d.u : d.v;
    if (std::fabs(across) > kNoMove_mm || along * request.next_sign < 0) {
      return fail(AlarmReason::corner_not_feed);
    }
  }
  comp::CutCorner cut;
  cut.fault = CornerFault::not_needed;
  if (request.shape != CornerShape::none) {
    cut = comp::cut_corner(held_->path, next->path, request.shape, request.size_mm,
                           ex.dialect.corners.chamfer_size);
  }
  if (cut.fault == CornerFault::too_large) {
    const bool chamfer = request.shape == CornerShape::chamfer;
    // Of lines: longer than the third side of their triangle, or it ends beyond one of them (2000TC 3.6.3).
    const bool lines = !held_->path.arc && !next->path.arc;
    const double third = comp::length(next->path.to - held_->path.from);
    if (!chamfer) return fail(AlarmReason::corner_too_large);
    return fail(lines && request.size_mm > third ? AlarmReason::corner_chamfer_size
                                                 : AlarmReason::corner_short_line);
  }
  // Not where compensation begins, ends or changes its side (0i-D PS0039, K2000TC L17717).
  const bool begins = held_->mode.wanted && !on_, ends = held_->mode.wanted && !next->mode.wanted;
  if (cut.fault == CornerFault::none && (begins || ends || held_->mode.radius * next->mode.radius < 0))
    return fail(AlarmReason::compensation_corner);

  EntryPtr first = std::move(held_);
  held_corner_ = false;
  if (cut.fault == CornerFault::none) {
    EntryPtr inserted = fresh();
    inserted->mode = first->mode;
    inserted->motion = inserted->plane_move = true;
    inserted->path = cut.inserted;
    inserted->aim();
    inserted->op = motion_along(ex, *motion_in(first->op), first->mode, cut.inserted.to, cut.inserted,
                                feed_of(first->op));
    if (ex.data.bit(ex.dialect.corners.stop_parameter)) ++motion_in(inserted->op)->at.part;
    move_end(ex, first->op, first->mode, cut.first);
    first->path = cut.first;
    first->aim();
    // The vector that I J K asked for belongs to the written end, which is the chamfer's now.
    inserted->vector = std::exchange(first->vector, BlockVector{});
    set_arc(ex, next->op, next->mode, cut.second, {});
    next->path = cut.second;
    next->aim();
    compensate(ex, std::move(first));
    if (!stopped_) compensate(ex, std::move(inserted));
  } else {
    compensate(ex, std::move(first));
  }
  for (EntryPtr& follower : corner_followers_) {
    if (!stopped_) compensate(ex, std::move(follower));
  }
  corner_followers_.clear();
  if (!stopped_) corners(ex, std::move(next));
}

}  // namespace headstock::interp

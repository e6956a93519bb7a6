// Stage 2: G40 G41 G42. `last_` is the motion whose end waits for the next one; `previous_` the one before
// it, whose corner with `last_` is known but may still lose vectors when `last_` turns out to run backwards.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "interpreter/executor.hpp"
#include "interpreter/offset_memory.hpp"
#include "interpreter/pipeline.hpp"
#include "interpreter/pipeline_entry.hpp"
#include "interpreter/pipeline_motion.hpp"

namespace headstock::interp {

using comp::Point;
using comp::Vectors;

namespace {

constexpr double kSameRadius_mm = 1e-6;
constexpr double kNearVectors_mm = 1e-5;
constexpr int kReadAhead = 3;

// From the nose centre to the imaginary tip, in the plane's axes (Z, X of G18).
constexpr Point kTips[10] = {{0, 0}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1},
                             {1, 0}, {0, 1}, {-1, 0}, {0, -1},  {0, 0}};

bool is_arc(const Operation& operation) {
  return std::holds_alternative<Arc>(operation);
}

/// An arc cut on its inside: the feed holds on the programmed arc, the tool's centre is slower, down to No.
/// 1710 of it; 0: not at all (0i-D M 5.4.2.2, L5154-L5198).
void slow_inner_arc(const Executor& ex, Operation& operation, double programmed_mm) {
  auto* arc = std::get_if<Arc>(&operation);
  if (arc == nullptr || !ex.dialect.compensation.by_d || arc->unit == FeedUnit::inverse_time) return;
  const double least = ex.data.parameter("1710") / 100, ratio = arc->radius_mm / programmed_mm;
  if (least > 0 && ratio < 1) arc->feed *= std::max(ratio, std::min(1.0, least));
}

}  // namespace

// Blocks in a row have the same mode: it is made again only when something of what it is made of is another.
const CompensationMode& Pipeline::mode_of(const Executor& ex) {
  if (!settings_.read || settings_.version != ex.data.version) read_settings(ex);
  const auto& rules = ex.dialect.compensation;
  const auto plane = ex.plane_axes();
  const int side = no_compensation_ ? 0 : side_;
  const std::int64_t number = side == 0 ? 0 : rules.by_d ? d_number : ex.modal.offset;
  double value = 0;
  int tip = 0;
  if (number > 0 && number < static_cast<std::int64_t>(ex.data.tools.size())) {
    const ToolOffset& tool = ex.data.tools[static_cast<std::size_t>(number)];
    value = settings_.one_value ? tool_offset::length_value(ex, number) : tool.radius + tool.radius_wear;
    tip = tool.tip;
  }
  auto& from = mode_from_;
  if (from.read && !ex.transform.active() && from.value == value && from.number == number && from.side == side &&
      from.again == again_ && from.tip == tip && from.plane == ex.plane && from.first == plane.first &&
      from.second == plane.second) {
    return mode_;
  }
  // What a mirrored plane reverses depends on more than this.
  from = {!ex.transform.active(), ex.plane, plane.first, plane.second, side, again_, number, value, tip};

  CompensationMode mode;
  mode.plane = ex.plane;
  mode.first = static_cast<std::uint8_t>(plane.first < 0 ? 0 : plane.first);
  mode.second = static_cast<std::uint8_t>(plane.second < 0 ? 0 : plane.second);
  mode.asked = side != 0;
  mode.again = mode.asked && again_;
  mode.wanted = number > 0;
  // In a plane that is mirrored the tool is on the other side, as arcs turn the other way.
  const int tool_side = ex.transform.reverses(mode.first, mode.second) ? -side : side;
  mode.radius = tool_side * (settings_.diameter ? value / 2 : value);
  if (ex.dialect.tools.lathe && tip > 0 && tip < 9 && (rules.tips_in_all_planes || ex.plane == Plane::zx)) {
    mode.tip = kTips[tip] * std::fabs(mode.radius);
  }
  mode_ = mode;
  return mode_;
}

void Pipeline::read_settings(const Executor& ex) {
  const auto& rules = ex.dialect.compensation;
  const auto& data = ex.data;
  Settings s;
  s.read = true;
  s.version = data.version;
  s.offset.start = data.bit(rules.type_b_parameter) ? comp::StartType::b : rules.start;
  s.offset.start_by_normal = rules.start_by_normal;
  s.offset.circular_outside = data.bit(rules.circular_parameter);
  s.diameter = data.bit(rules.diameter_parameter);
  s.type_c = data.bit(rules.type_c_parameter);
  s.checks_arcs = (rules.check_parameter.empty() || data.parameter(rules.check_parameter, 1) != 0) &&
                  !data.bit(rules.no_check_parameter);
  s.checks_lines = s.checks_arcs && !data.bit(rules.arcs_only_parameter);
  s.avoids = data.bit(rules.avoid_parameter);
  s.stops = data.bit(rules.stop_parameter);
  s.one_value = rules.by_d && tool_offset::one_value(ex);
  s.near_mm = std::max(data.parameter(rules.near_parameter, kNearVectors_mm), kNearVectors_mm);
  const double ahead = data.parameter(rules.read_ahead_parameter, kReadAhead);
  s.read_ahead = ahead >= 3 && ahead <= 8 ? static_cast<int>(ahead) : kReadAhead;
  settings_ = s;
  mode_from_.read = false;
}

void Pipeline::written(int side, bool same_as_before) {
  again_ = same_as_before && side != 0;
  written_here_ = true;
  side_ = side;
}

void Pipeline::corner_arc(bool has_direction, Point direction) {
  corner_arc_ = {true, has_direction, direction};
}

void Pipeline::displace(const Executor& ex, Motion& motion, const CompensationMode& mode, Point by) const {
  shift_end(ex, motion, mode, by + mode.tip);
}

// Motions of other axes and operations that are no motions, at the vector that the tool stands at.
void Pipeline::send_displaced(Executor& ex, EntryPtr&& entry) {
  if (entry->motion && on_) displace(ex, *motion_in(entry->op), kept_mode_, kept_);
  send_entry(ex, std::move(entry));
}

void Pipeline::compensate(Executor& ex, EntryPtr&& entry) {
  if (!entry->motion) {
    if (std::holds_alternative<End>(entry->op)) {
      settle_here(ex);
      on_ = false;
      side_ = 0;
    } else if (std::holds_alternative<Alarm>(entry->op)) {
      abandon(ex);
    }
    return follow(ex, std::move(entry));
  }
  if (settings_.type_c) {
    passed_machine_ = std::exchange(coming_machine_, motion_in(entry->op)->end_machine);
    passed_work_ = std::exchange(coming_work_, motion_in(entry->op)->end_work);
  }
  const auto& refused = ex.dialect.compensation;
  if (entry->mode.wanted && refused.threads_refused && std::holds_alternative<Thread>(entry->op)) {
    return raise(ex, AlarmReason::compensation_refused, motion_in(entry->op)->at, 0, {});
  }
  if (entry->lifted) {  // the vector is dropped; the next motion in the plane takes it again
    settle_here(ex);
    on_ = false;
    return send_entry(ex, std::move(entry));
  }
  if (!entry->plane_move) {
    const bool settles = entry->zero_move && on_;
    follow(ex, std::move(entry));
    if (settles) settle_here(ex);
    return;
  }
  quiet_blocks_ = 0;
  if (on_ && entry->mode.plane != (has_last_ ? last_->mode : kept_mode_).plane) {
    return raise(ex, AlarmReason::compensation_plane, motion_in(entry->op)->at, 0, {});
  }
  if (entry->mode.asked && !entry->mode.wanted && !on_ && refused.zero_number_is_alarm) {
    return raise(ex, AlarmReason::compensation_number, motion_in(entry->op)->at, 0, {});
  }
  if (!entry->mode.wanted) return on_ ? leave(ex, std::move(entry)) : send_entry(ex, std::move(entry));

  const double r = entry->mode.radius;
  if (!on_ && std::exchange(starts_in_place_, false)) step_onto_vector(ex, *entry);
  if (!on_) {
    if (is_arc(entry->op)) {
      return raise(ex, AlarmReason::compensation_start_arc, motion_in(entry->op)->at, 0, {});
    }
    on_ = true;
    entry->role = PipelineKnown::Role::start;
    corner_ = comp::single({});
    last_ = std::move(entry);
    has_last_ = true;
    return;
  }
  if (is_arc(entry->op)) {
    const comp::Segment& path = entry->path;
    const double left = std::min(path.start_radius(), path.end_radius()) - path.turn * r;
    if (left < kSameRadius_mm && path.turn * r > 0) {
      const bool same = left > -kSameRadius_mm;
      return raise(ex, same ? AlarmReason::compensation_arc_centre : AlarmReason::compensation_overcut,
                   motion_in(entry->op)->at, 0, {});
    }
  }
  if (entry->mode.again && ex.dialect.compensation.again_is_perpendicular && has_last_) settle_here(ex);
  if (!has_last_) {
    corner_ = comp::single(kept_);
    entry->free_start = true;
    last_ = std::move(entry);
    has_last_ = true;
    return;
  }

  comp::OffsetRules rules = settings_.offset;
  if (std::holds_alternative<Rapid>(entry->op)) rules.circular_outside = false;
  const double r_last = last_->mode.radius;
  const bool starts = last_->role == PipelineKnown::Role::start;
  const bool other_side = !last_->vector.given && !starts && !corner_arc_.asked && r * r_last < 0;
  if (other_side && ex.dialect.compensation.side_change_after_start_is_alarm && has_previous_ &&
      previous_->role == PipelineKnown::Role::start) {
    return raise(ex, AlarmReason::compensation_side, motion_in(entry->op)->at, 0, {});
  }
  const auto vectors = [&]() -> Vectors {
    if (last_->vector.given) return comp::single(comp::normal_of(last_->vector.direction, r_last));
    if (starts) return comp::start_up(last_->path, entry->path, r, rules);
    if (corner_arc_.asked) {
      return comp::corner_arc(
          last_->path, corner_arc_.has_direction ? corner_arc_.direction : entry->path.direction_at_start(),
          r_last);
    }
    if (other_side) return comp::change_side(last_->path, r_last, entry->path, r);
    return comp::corner(last_->path, last_->ahead_at_end, entry->path, entry->ahead_at_start, r_last, rules);
  };
  Vectors v = vectors();
  corner_arc_ = {};
  if (v.count == 0) {
    return raise(ex, AlarmReason::compensation_no_crossing, motion_in(entry->op)->at, 0, {});
  }
  if (!entry->path.arc || entry->path.sweep <= std::numbers::pi) {
    comp::merge_near(v, settings_.near_mm);
  }
  if (std::exchange(touched_, false)) {
    v.bare = static_cast<int>(v.count);
    v.add({});
    v.add(v.at[v.count - 2]);
  }
  switch (close_last(ex, v, entry.get())) {
    case Closed::stopped:
      return;
    case Closed::left_out:
      entry->after_gap = true;
      break;
    case Closed::good:
      break;
  }
  last_ = std::move(entry);
  has_last_ = true;
}

// Whatever is no motion in the plane keeps its place behind the motion before it.
void Pipeline::follow(Executor& ex, EntryPtr&& entry) {
  if (has_last_) {
    after_.push_back(std::move(entry));
  } else {
    send_displaced(ex, std::move(entry));
  }
}

// A block with G40 (or offset number 0) that moves in the plane.
void Pipeline::leave(Executor& ex, EntryPtr&& entry) {
  if (is_arc(entry->op)) {
    return raise(ex, AlarmReason::compensation_start_arc, motion_in(entry->op)->at, 0, {});
  }
  if (has_last_) {
    comp::OffsetRules rules = settings_.offset;
    if (std::holds_alternative<Rapid>(entry->op)) rules.circular_outside = false;
    const double r = last_->mode.radius;
    Vectors v;
    if (entry->vector.given && last_->role != PipelineKnown::Role::start) {
      v = comp::cancel_at_wall(last_->path, entry->vector.direction, r);
    } else if (last_->vector.given) {
      v = comp::single(comp::normal_of(last_->vector.direction, r));
    } else if (last_->role == PipelineKnown::Role::start) {
      v = comp::single(comp::normal_at_end(last_->path, r));
    } else {
      v = comp::cancel(last_->path, entry->path, r, rules);
    }
    if (close_last(ex, v, nullptr) == Closed::stopped) return;
    release_previous(ex, entry.get());
  }
  on_ = false;
  send_entry(ex, std::move(entry));
}

// The end of `last_` is known now: it is checked, the one before it goes out, and it becomes `previous_`.
Pipeline::Closed Pipeline::close_last(Executor& ex, Vectors& end, const Entry* next) {
  const Settings& set = settings_;
  const bool checked = last_->role == PipelineKnown::Role::body && !last_->free_start &&
                       (last_->path.arc ? set.checks_arcs : set.checks_lines);
  if (checked) {
    bool straight = false;
    const double r = last_->mode.radius;
    const auto beside = [&](const Entry* entry) {
      const bool same =
          entry != nullptr && entry->role == PipelineKnown::Role::body && entry->mode.radius == r;
      return same ? &entry->path : nullptr;
    };
    const comp::Neighbours neighbours{{beside(has_previous_ ? previous_.get() : nullptr), beside(next)}};
    if (comp::settle(last_->path, neighbours, corner_, end, r, straight) == comp::Between::reversed) {
      const SourcePosition& at = motion_in(last_->op)->at;
      if (last_->after_gap) {
        raise(ex, AlarmReason::compensation_again, at, 0, {});
      } else if (next != nullptr && set.avoids) {
        return leave_out(ex, *next);
      } else {
        const bool groove = has_previous_ && next != nullptr &&
                            comp::is_groove(previous_->path, last_->path, next->path, last_->mode.radius);
        raise(ex, groove ? AlarmReason::compensation_groove : AlarmReason::compensation_interference, at, 0,
              {});
      }
      return Closed::stopped;
    }
    if (straight) {
      last_->op = motion_along(ex, *motion_in(last_->op), last_->mode, last_->path.to,
                               comp::line(last_->path.from, last_->path.to), feed_of(last_->op));
      last_->path = comp::line(last_->path.from, last_->path.to);
      last_->aim();
    }
  }
  if (has_previous_) release_previous(ex, last_.get());
  last_->start_vector = corner_.last();
  previous_ = std::move(last_);
  has_previous_ = true;
  has_last_ = false;
  corner_ = end;
  if (!between_.empty() || !after_.empty()) between_.swap(after_);
  return Closed::good;
}

// `previous_` with the moves of its corner and what follows it. The corner belongs to the block after it: its
// feed (K2000TC L17626).
void Pipeline::release_previous(Executor& ex, const Entry* next) {
  if (!has_previous_) return;
  const CompensationMode& mode = previous_->mode;
  const comp::Segment& path = previous_->path;
  if (in_place()) passed_ = previous_->op;
  const bool around = corner_.count > 1;
  const MotionFeed speed = around ? feed_of(next != nullptr ? next->op : previous_->op) : MotionFeed{};

  const Point first = corner_.first();
  if (path.arc) {
    comp::Segment run = path;
    run.from = path.from + previous_->start_vector;
    run.to = path.to + first;
    run.sweep = comp::arc(run.from, run.to, run.center, run.turn).sweep;
    set_arc(ex, previous_->op, mode, run, mode.tip);
    slow_inner_arc(ex, previous_->op, path.start_radius());
  }
  // Moved on first, displaced there: what was only just written is slow to move.
  const bool to_caller = !ex.out_used;
  const std::size_t index = ex.queue.size();
  const auto sent = [&]() -> Operation& {
    return to_caller ? *ex.out : ex.queue[index];
  };  // the queue may grow
  send(ex, std::move(previous_->op));
  has_previous_ = false;
  displace(ex, *motion_in(sent()), mode, first);
  const bool stops = settings_.stops;
  std::uint32_t part = motion_in(sent())->at.part;

  const Point tip = mode.tip;
  for (std::size_t i = 1; i < corner_.count; ++i) {
    const bool bare = corner_.bare == static_cast<int>(i);
    const Point to = path.to + (bare ? Point{} : corner_.at[i] + tip);
    comp::Segment move = comp::line({}, to);
    if (corner_.circular && i == 1) {
      move = comp::arc(path.to + corner_.at[0], path.to + corner_.at[1], path.to, corner_.turn);
      move.center = move.center + tip;
      move.from = move.from + tip;
      move.to = move.to + tip;
    }
    Operation& made = place(ex);
    put_motion(ex, made, *motion_in(sent()), mode, to, move, speed);
    if (stops) motion_in(made)->at.part = ++part;
  }
  kept_ = corner_.last();
  kept_mode_ = mode;
  recycle(std::move(previous_));
  for (EntryPtr& entry : between_) send_displaced(ex, std::move(entry));
  between_.clear();
}

// No more is known of what follows: the vector normal to the last motion.
void Pipeline::settle_here(Executor& ex) {
  if (has_last_) {
    const double r = last_->mode.radius;
    Vectors normal = comp::single(last_->vector.given ? comp::normal_of(last_->vector.direction, r)
                                                      : comp::normal_at_end(last_->path, r));
    if (close_last(ex, normal, nullptr) == Closed::stopped) return;
  }
  release_previous(ex, nullptr);
  touched_ = false;
}

void Pipeline::quiet_block(Executor& ex) {
  const auto& rules = ex.dialect.compensation;
  if (std::exchange(touch_, false)) touched_ = has_last_;
  if (!on_) {
    if (written_here_) starts_in_place_ = side_ != 0 && in_place();
    return;
  }
  if (written_here_ && side_ == 0 && in_place()) return step_off_vector(ex);
  ++quiet_blocks_;
  if (rules.most_quiet_blocks > 0 && quiet_blocks_ >= rules.most_quiet_blocks) {
    return raise(ex, AlarmReason::compensation_quiet_blocks, ex.at, 0, {});
  }
  const bool cancelled = side_ == 0 || (again_ && rules.again_is_perpendicular);
  const int read_ahead = settings_.read_ahead;
  if (has_last_ && (cancelled || quiet_blocks_ > read_ahead - 2)) settle_here(ex);
}

// An alarm: what is settled has gone out or goes out now, the rest is not run.
void Pipeline::abandon(Executor& ex) {
  if (has_previous_) {
    corner_ = comp::single(corner_.first());
    between_.clear();
    release_previous(ex, nullptr);
  }
  has_last_ = false;
  after_.clear();
  between_.clear();
}

}  // namespace headstock::interp

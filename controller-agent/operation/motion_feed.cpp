#include "operation/motion_feed.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "operation/free_path.hpp"
#include "operation/macro_control.hpp"
#include "operation/path_length.hpp"

namespace headstock::operation {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

template <typename... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <typename... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

const interp::Motion kNoMotion{};

// A move whose tag nobody could see: shorter than any axis can resolve.
constexpr double kNoMove_mm = 1e-9;
// How far a positioning that is not interpolated cuts its corners.
constexpr double kRoundest_mm = 2;

constexpr std::int16_t kSurfaceSpeed = 960;  // G96

struct PlaneAxes {
  char first, second;
};
constexpr PlaneAxes plane_axes(interp::Plane plane) {
  switch (plane) {
    case interp::Plane::zx:
      return {'Z', 'X'};
    case interp::Plane::yz:
      return {'Y', 'Z'};
    case interp::Plane::xy:
      break;
  }
  return {'X', 'Y'};
}

}  // namespace

motion::Arc arc_geometry(const machine::Machine& machine, const interp::Arc& arc) {
  const PlaneAxes plane = plane_axes(arc.plane);
  const bool named = arc.axis_1 != interp::Arc::kByPlane;
  const std::size_t first = named ? arc.axis_1 : machine.axis_index(plane.first).value_or(0);
  const std::size_t second = named ? arc.axis_2 : machine.axis_index(plane.second).value_or(1);
  motion::Arc geometry;
  geometry.end = arc.end_machine;
  geometry.axis_1 = static_cast<std::uint8_t>(first);
  geometry.axis_2 = static_cast<std::uint8_t>(second);
  geometry.center_1 = arc.center_machine[first];
  geometry.center_2 = arc.center_machine[second];
  geometry.angle_rad = arc.turns * kTwoPi * (arc.turn == interp::Turn::ccw ? 1 : -1);
  return geometry;
}

bool is_motion(const interp::Operation& operation) {
  return std::holds_alternative<interp::Rapid>(operation) ||
         std::holds_alternative<interp::Feed>(operation) || std::holds_alternative<interp::Arc>(operation) ||
         std::holds_alternative<interp::Thread>(operation);
}

bool blocks_differ(const interp::SourcePosition& a, const interp::SourcePosition& b) {
  return a.program != b.program || a.line != b.line || a.byte_offset != b.byte_offset || a.part != b.part;
}

const interp::Motion& motion_of(const interp::Operation& operation) {
  return std::visit(
      [](const auto& op) -> const interp::Motion& {
        if constexpr (std::is_base_of_v<interp::Motion, std::decay_t<decltype(op)>>)
          return op;
        else
          return kNoMotion;
      },
      operation);
}

void MotionFeed::set_position(const AxisVector& position) {
  const AxisVector position_before = position_;
  position_ = position;
  held_back_.reset();
  inner_corners_.reset();
  after_thread_ = false;
  if (history_ != nullptr && position != position_before) history_->forget();
  last_tag_ = 0;
  tag_when_set_ = tags_.newest();
}

motion::Move MotionFeed::make(const interp::Operation& operation) const {
  motion::Move move;
  move.tolerance_mm = machine_.tolerance_mm;
  const interp::Motion& common = motion_of(operation);
  move.geometry = motion::Line{common.end_machine};
  move.exact_stop = common.exact_stop && !MacroControl(common.modal.macro_control).no_exact_stop;

  const auto set_feed = [&](double feed, interp::FeedUnit unit) {
    if (rules_.dry_run) {
      move.feed = motion::PathFeed{rules_.dry_run_mm_min / 60};
      return;
    }
    switch (unit) {
      case interp::FeedUnit::mm_per_minute:
        move.feed = motion::PathFeed{feed / 60};
        break;
      case interp::FeedUnit::mm_per_revolution:
        // Under constant surface speed the speed ahead is not known: planned for the highest.
        move.feed = motion::RevolutionFeed{feed, 0};
        break;
      case interp::FeedUnit::inverse_time:
        move.feed = motion::PathFeed{feed / 60 * path_length(position_, move)};
        break;
    }
  };
  std::visit(
      Overloaded{
          [&](const interp::Rapid&) {
            move.feed = motion::RapidFeed{};
            move.exact_stop = true;  // in-position check of positioning (0i-D 4.1)
          },
          [&](const interp::Feed& m) {
            set_feed(m.feed, m.unit);
            move.skip = m.skip_signals != 0;
            if (move.skip) move.exact_stop = true;
          },
          [&](const interp::Arc& m) {
            move.geometry = arc_geometry(machine_, m);
            double feed = m.feed;
            if (m.feed_on_arc &&
                m.unit != interp::FeedUnit::inverse_time) {  // helix: the path is longer than its arc
              const double on_arc = m.radius_mm * m.turns * kTwoPi;
              const double path = path_length(position_, move);
              if (on_arc > 0 && path > on_arc) feed *= path / on_arc;
            }
            set_feed(feed, m.unit);
          },
          [&](const interp::Thread& m) {
            move.feed = motion::ThreadFeed{m.lead_mm, m.lead_change_mm, m.start_angle_deg / 360 * kTwoPi};
          },
          [](const auto&) {}},
      operation);
  return move;
}

std::vector<motion::Move> MotionFeed::moves(const interp::Operation& operation) const {
  const motion::Move whole = make(operation);
  const auto* rapid = std::get_if<interp::Rapid>(&operation);
  if (rapid == nullptr || rapid->linear) return {whole};
  const AxisVector& end = std::get<motion::Line>(whole.geometry).end;
  std::array<AxisCourse, machine::kMaxAxes> courses;
  for (std::size_t i = 0; i < machine_.axes.size(); ++i) {
    const machine::Axis& axis = machine_.axes[i];
    const double rate_mm_s = axis.rapid_mm_min / 60;
    const double gentler = rules_.accelerations.of_hand(i, MotionKind::rapid, rate_mm_s).acceleration_mm_s2;
    courses[i] = {end[i] - position_[i], rate_mm_s,
                  gentler > 0 ? std::min(gentler, axis.max_acceleration_mm_s2) : axis.max_acceleration_mm_s2};
  }
  const std::vector<AxisVector> corners = free_path(position_, {courses.data(), machine_.axes.size()});
  if (corners.size() < 2) return {whole};
  std::vector<motion::Move> legs(corners.size(), whole);
  std::vector<double> length;
  AxisVector from = position_;
  for (std::size_t k = 0; k < legs.size(); ++k) {
    legs[k].free_path = true;
    if (k + 1 < legs.size()) legs[k].geometry = motion::Line{corners[k]};  // the last one ends where it is to
    length.push_back(path_length(from, legs[k]));
    from = end_of(legs[k]);
  }
  // The axes do not wait for each other: a corner is as round as the way to it allows.
  for (std::size_t k = 0; k + 1 < legs.size(); ++k) {
    legs[k].exact_stop = false;
    legs[k].block_end = false;
    legs[k].tolerance_mm =
        std::max(machine_.tolerance_mm, std::min(kRoundest_mm, std::min(length[k], length[k + 1]) / 8));
  }
  return legs;
}

std::optional<axes::Overtravel> MotionFeed::add(const interp::Operation& operation,
                                                std::uint64_t main_offset) {
  std::vector<motion::Move> parts = moves(operation);
  const auto* positioning = std::get_if<interp::Rapid>(&operation);
  const bool rapid = positioning != nullptr;
  const double away = rapid && after_thread_ ? positioning->retreat_ratio : 0;
  const double fastest_away = after_thread_ ? rules_.speeds.retreat_mm_s : 0;
  const interp::Motion& common = motion_of(operation);
  std::optional<axes::Overtravel> overtravel;
  std::uint64_t tag = 0;
  for (std::size_t k = 0; k < parts.size() && !overtravel; ++k) {
    motion::Move& move = parts[k];
    overtravel = axes::find_overtravel(machine_, position_, move.geometry);
    if (overtravel) {
      move.geometry = overtravel->allowed;
      move.exact_stop = true;
    } else if (axes::near_limit(machine_, position_, move.geometry, move.tolerance_mm) && !move.free_path) {
      move.exact_stop = true;  // a rounded corner must not bulge past the limit
    }
    if (path_length(position_, move) <= kNoMove_mm) continue;
    limit_speed(move, !rapid);
    if (fastest_away > 0)
      move.highest_mm_s = move.highest_mm_s > 0 ? std::min(move.highest_mm_s, fastest_away) : fastest_away;
    limit_acceleration(move, common.modal, away);
    keep_clear(move);
    if (tag == 0) {
      if (held_back_) {
        if (rapid) held_back_->exact_stop = true;
        held_back_->block_end = blocks_differ(held_block_, common.at);
      }
      pass_on();
      SegmentState& entry = tags_.append();
      entry.at = common.at;
      entry.modal = common.modal;
      entry.main_offset = main_offset;
      entry.cycle = common.cycle;
      entry.cutting = !rapid;
      entry.end = end_of(parts.back());
      entry.has_end = true;
      const MacroControl control(common.modal.macro_control);
      const bool tapping = common.cutting_mode == interp::CuttingMode::tapping && !rapid;
      entry.not_held = tapping || control.no_hold;
      entry.fixed_feed = tapping || control.no_override;
      entry.no_single_block = control.no_single_block;
      if (const auto* probe = std::get_if<interp::Feed>(&operation); probe && probe->skip_signals != 0) {
        entry.skip_signals = probe->skip_signals;
        entry.skip_low = !probe->skip_level;
        entry.fixed_feed = !probe->skip_overridable;
      }
      tag = entry.tag;
    } else {
      pass_on();
    }
    held_block_ = common.at;
    held_side_ = side_of(common);
    move.tag = last_tag_ = tag;
    held_start_ = position_;
    position_ = end_of(move);
    held_back_ = move;
    after_thread_ = std::holds_alternative<motion::ThreadFeed>(move.feed);
  }
  return overtravel;
}

void MotionFeed::limit_acceleration(motion::Move& move, const interp::ModalSnapshot& modal,
                                    double away) const {
  MotionKind kind = look_ahead_ ? MotionKind::cutting_ahead : MotionKind::cutting;
  if (std::holds_alternative<motion::RapidFeed>(move.feed))
    kind = away > 0 ? MotionKind::retreat : MotionKind::rapid;
  if (std::holds_alternative<motion::ThreadFeed>(move.feed)) kind = MotionKind::thread;
  // Under constant surface speed the speed is not known: the highest is the least limit.
  const bool surface = std::find(modal.g.begin(), modal.g.end(), kSurfaceSpeed) != modal.g.end();
  const double rpm = surface || !(modal.spindle_speed > 0) ? machine_.spindle.max_rpm : modal.spindle_speed;
  const auto curve = motion::Curve::from(position_, move, machine_.axes.size());
  rules_.accelerations.apply(curve, move, kind, rpm, kind == MotionKind::retreat ? away : 1);
  if (clearance_.forbids_filter(position_, move, rules_.accelerations.shapes()[move.shape]))
    rules_.accelerations.without_filter(curve, move, rpm);
}

void MotionFeed::keep_clear(motion::Move& move) {
  const auto too_near = [&] {
    const double before_mm = held_back_ ? held_back_->tolerance_mm : machine_.tolerance_mm;
    return clearance_.forbids_rounding(position_, move, std::max(move.tolerance_mm, before_mm));
  };
  if (!too_near()) return;
  motion::Move* const before = held_back_ ? &*held_back_ : nullptr;
  // The bend of a positioning that is not interpolated need not be rounder than any other corner.
  for (motion::Move* each : {before, &move})
    if (each != nullptr && each->free_path) each->tolerance_mm = std::min(each->tolerance_mm, machine_.tolerance_mm);
  if (!too_near()) return;
  const auto exact = [](motion::Move& each, bool stop) {
    each.tolerance_mm = std::min(each.tolerance_mm, ZoneClearance::kAlmostExact_mm);
    const bool inside_bend = each.free_path && !each.block_end;
    each.exact_stop = each.exact_stop || (stop && !inside_bend);
  };
  // In a chain of threads there is no stop.
  const bool thread = std::holds_alternative<motion::ThreadFeed>(move.feed);
  exact(move, !thread);
  if (before != nullptr)
    exact(*before, !thread || !std::holds_alternative<motion::ThreadFeed>(before->feed));
  else
    kernel_.finish();  // what is before has been handed over without knowing of this
}

void MotionFeed::limit_speed(motion::Move& move, bool cutting) {
  if (!cutting) return;
  const auto curve = motion::Curve::from(position_, move, machine_.axes.size());
  move.highest_mm_s = rules_.speeds.along(curve, move, look_ahead_);
  if (!look_ahead_ || !held_back_ || std::holds_alternative<motion::RapidFeed>(held_back_->feed)) return;
  const auto before = motion::Curve::from(held_start_, *held_back_, machine_.axes.size());
  held_back_->corner_mm_s = rules_.speeds.between(before, curve);
  // The speed of a block is the smaller one of its two ends (0i-D L21827).
  const double segment = rules_.speeds.segments(before, curve);
  if (segment <= 0) return;
  for (motion::Move* each : {&*held_back_, &move})
    each->highest_mm_s = each->highest_mm_s > 0 ? std::min(each->highest_mm_s, segment) : segment;
}

std::uint64_t MotionFeed::add_tag(const interp::Motion& motion, std::uint64_t main_offset) {
  SegmentState& entry = tags_.append();
  entry.at = motion.at;
  entry.modal = motion.modal;
  entry.main_offset = main_offset;
  entry.cycle = motion.cycle;
  entry.cutting = true;
  return entry.tag;
}

CuttingSide MotionFeed::side_of(const interp::Motion& motion) const {
  return look_ahead_ ? CuttingSide{} : CuttingSide::of(motion, machine_);
}

std::optional<MachineAlarm> MotionFeed::corner_override_refusal(const interp::Operation& operation) const {
  return corner_override_alarm(side_of(motion_of(operation)), rules_.inner_corners);
}

void MotionFeed::pass_on() {
  if (!held_back_) return;
  const motion::Move move = *held_back_;
  held_back_.reset();
  inner_corners_.add(held_start_, move, held_side_);
}

void MotionFeed::flush() {
  pass_on();
  inner_corners_.release();
}

void MotionFeed::finish() {
  if (held_back_) held_back_->exact_stop = true;
  flush();
  kernel_.finish();
}

}  // namespace headstock::operation

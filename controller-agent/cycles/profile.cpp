#include "cycles/profile.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <variant>

#include "cycles/tool_radius.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::cycles {
namespace {

using interp::Executor;
using interp::Operation;

constexpr std::size_t kMostBlocks = 20'000;  // ours: a loop in a profile ends here

// What carrying out a profile for reading changes and must not.
struct Modal {
  explicit Modal(const Executor& ex)
      : axes(ex.axes),
        machine_now(ex.machine_now),
        work_now(ex.work_now),
        modal(ex.modal),
        motion_code(ex.motion_code),
        incremental(ex.incremental),
        exact_stop_mode(ex.exact_stop_mode),
        constant_surface_speed(ex.constant_surface_speed),
        spindle_changed(ex.spindle_changed),
        feed_unit(ex.feed_unit),
        feed_mm(ex.feed_mm),
        lead_mm(ex.lead_mm),
        rpm(ex.rpm),
        surface_speed(ex.surface_speed),
        clamp_rpm(ex.clamp_rpm),
        spindle_direction(ex.spindle_direction),
        at(ex.at),
        block(ex.block),
        action(ex.action),
        code(ex.code),
        code_column(ex.code_column),
        jumps(ex.jumps) {}

  void restore(Executor& ex) const {
    ex.axes = axes;
    ex.machine_now = machine_now;
    ex.work_now = work_now;
    ex.modal = modal;
    ex.motion_code = motion_code;
    ex.incremental = incremental;
    ex.exact_stop_mode = exact_stop_mode;
    ex.constant_surface_speed = constant_surface_speed;
    ex.spindle_changed = spindle_changed;
    ex.feed_unit = feed_unit;
    ex.feed_mm = feed_mm;
    ex.lead_mm = lead_mm;
    ex.rpm = rpm;
    ex.surface_speed = surface_speed;
    ex.clamp_rpm = clamp_rpm;
    ex.spindle_direction = spindle_direction;
    ex.at = at;
    ex.block = block;
    ex.action = action;
    ex.code = code;
    ex.code_column = code_column;
    ex.jumps = jumps;
  }

  std::vector<interp::ProgramAxis> axes;
  interp::AxisVector machine_now, work_now;
  interp::ModalSnapshot modal;
  const dialects::GCode* motion_code;
  bool incremental, exact_stop_mode, constant_surface_speed, spindle_changed;
  interp::FeedUnit feed_unit;
  double feed_mm, lead_mm, rpm, surface_speed, clamp_rpm;
  interp::SpindleDirection spindle_direction;
  interp::SourcePosition at;
  program::Block block;
  const dialects::GCode* action;
  const dialects::GCode* code;
  std::uint32_t code_column;
  std::uint64_t jumps;
};

// A place in the text of the program that is running.
struct Place {
  std::uint64_t offset = 0;
  std::uint32_t line = 1;
};

Place behind_block(Executor& ex) {
  if (!ex.settle_reader()) return {};
  const interp::Frame& frame = ex.frames.back();
  if (frame.rest == nullptr) return {frame.reader->byte_offset(), frame.reader->line_number()};
  return {frame.line.byte_offset + static_cast<std::uint64_t>(frame.rest - frame.line.text.data()),
          frame.line.number};
}

bool go_to(Executor& ex, Place place) {
  interp::Frame& frame = ex.frames.back();
  frame.rest = nullptr;
  ex.leave_chain();
  if (ex.reader_of(frame) == nullptr) return false;
  return frame.reader->seek(place.offset, place.line);
}

// Looks for a block by its N from a place on, as a jump does: nothing else of a block is read, its variables may have
// no value yet. @return nothing when the text ends before.
std::optional<Place> find_sequence(Executor& ex, Place from, std::uint32_t sequence) {
  if (!go_to(ex, from)) return std::nullopt;
  interp::Frame& frame = ex.frames.back();
  program::Line line;
  while (frame.reader->next(line) == program::LineStatus::line) {
    const char* at = line.text.data();
    const char* end = at + line.text.size();
    while (at != nullptr) {
      const program::BlockHead head = program::read_head(line.text, at, ex.lex_rules);
      const Place here{line.byte_offset + static_cast<std::uint64_t>(at - line.text.data()), line.number};
      if (head.record_end && here.offset > from.offset) return std::nullopt;
      if (head.has_number && head.number != frame.number && here.offset > 0 && from.offset > 0) return std::nullopt;
      if (head.has_sequence && head.sequence == sequence) return here;
      at = head.rest == end ? nullptr : head.rest;
    }
  }
  return std::nullopt;
}

// Where the profile begins, its end having been seen too.
std::optional<Place> find_profile(Executor& ex, BlockRange range, Place behind) {
  const auto whole = [&](Place from) -> std::optional<Place> {
    const auto first = find_sequence(ex, from, range.first);
    if (!first || !find_sequence(ex, *first, range.last)) return std::nullopt;
    return first;
  };
  if (const auto ahead = whole(behind)) return ahead;
  return whole({0, 1});
}

bool is_g(const program::Block& b, std::initializer_list<std::int32_t> codes) {
  for (std::size_t i = 0; i < b.g_count; ++i) {
    for (const std::int32_t code : codes) {
      if (b.g[i].tenths == code) return true;
    }
  }
  return false;
}

// What may stand in a profile.
bool admit_block(Executor& ex, const Rules& rules, bool first, std::size_t count) {
  const program::Block& b = ex.block;
  const std::size_t most = rules.most_blocks != 0 ? rules.most_blocks : kMostBlocks;
  if (count > most) return fail(ex, rules, Fault::too_long, 'N');
  if (first && !is_g(b, {0, 10})) return fail(ex, rules, Fault::first_block, 'N');
  for (std::size_t i = 0; i < b.m_count; ++i) {
    using dialects::MAction;
    switch (ex.dialect.m_action(b.m[i].tenths / 10)) {
      case MAction::call:
      case MAction::return_:
      case MAction::end_m02:
      case MAction::end_m30:
      case MAction::restart:
        return ex.alarm_code(rules.code(Fault::forbidden_call), b.m[i].column,
                             "M" + std::to_string(b.m[i].tenths / 10));
      default:
        break;
    }
  }
  for (std::size_t i = 0; i < b.g_count; ++i) {
    const dialects::GCode* row = ex.table->find(b.g[i].tenths);
    if (row == nullptr) continue;  // the interpreter's own alarm
    const bool dwell = row->tenths == 40;
    const bool motion = row->phase == dialects::Phase::motion;
    bool allowed = row->phase != dialects::Phase::unavailable;
    if (row->phase == dialects::Phase::action || row->group == 0)
      allowed = dwell || row->phase == dialects::Phase::modifier;
    if (motion) allowed = row->tenths <= 30;
    if (row->cycle) allowed = false;
    for (const char* unit : {"inch", "metric"}) {
      if (row->handler != nullptr && row->handler == interp::handlers::find(unit)->handler) allowed = false;
    }
    if (rules.one_shot_in_profile && !motion && !dwell) {
      const std::int32_t g = row->tenths / 10;
      allowed = allowed && ((g >= 96 && g <= 99) || (g >= 40 && g <= 42));
    }
    if (!allowed) {
      return ex.alarm_code(rules.code(Fault::forbidden), b.g[i].column, std::string(row->name));
    }
  }
  return true;
}

// Watches a profile while it is read: its blocks may hold only what the control allows.
class Reading final : public interp::BlockWatch {
 public:
  Reading(const Rules& rules, BlockRange range, std::size_t depth)
      : rules_(rules), range_(range), depth_(depth) {}
  bool admit(Executor& ex) override {
    const bool first = count_ == 0;
    if (first) first_words_ = ex.block.words;
    return admit_block(ex, rules_, first, ++count_);
  }
  bool done(Executor& ex, bool has_sequence, std::uint32_t sequence) override {
    if (has_sequence && sequence == range_.last && ex.frames.size() == depth_) over_ = true;
    return true;
  }
  bool over() const { return over_; }
  std::size_t count() const { return count_; }
  std::uint32_t first_words() const { return first_words_; }

 private:
  const Rules& rules_;
  BlockRange range_;
  std::size_t depth_;
  std::size_t count_ = 0;
  std::uint32_t first_words_ = 0;
  bool over_ = false;
};

// Watches a profile while G70 cuts it; at its end the tool goes back and the program on.
class Finishing final : public interp::BlockWatch {
 public:
  Finishing(const Rules& rules, BlockRange range, const Executor& ex, Place behind)
      : rules_(rules),
        range_(range),
        depth_(ex.frames.size()),
        behind_(behind),
        start_(ex.machine_now),
        at_(ex.at) {}
  bool admit(Executor& ex) override {
    const bool first = count_ == 0;
    return admit_block(ex, rules_, first, ++count_);
  }
  bool done(Executor& ex, bool has_sequence, std::uint32_t sequence) override {
    if (!has_sequence || sequence != range_.last || ex.frames.size() != depth_) return true;
    PlaneAxes axes;
    ex.at = at_;
    if (!plane_axes(ex, rules_, axes)) return false;
    // Back to the start point: an offset changed by the profile moves with it, the slides go where they
    // stood.
    for (const std::size_t i : {axes.u, axes.v}) ex.set_axis_machine(i, start_[i]);
    auto& move = ex.emit<interp::Rapid>();
    ex.fill_motion(move, 1u << axes.u | 1u << axes.v);
    move.linear = ex.linear_rapid;
    if (!go_to(ex, behind_)) return fail(ex, rules_, Fault::not_stored, 'P');
    ex.cycle.name = nullptr;
    auto self = std::move(ex.cycle.watch);  // the watch is over; lives until this returns
    return ex.run_deferred();
  }

 private:
  const Rules& rules_;
  BlockRange range_;
  std::size_t depth_;
  std::size_t count_ = 0;
  Place behind_;
  interp::AxisVector start_;
  interp::SourcePosition at_;
};

}  // namespace

bool fail(Executor& ex, const Rules& rules, Fault fault, char letter, std::string detail) {
  const bool has = letter >= 'A' && letter <= 'Z' && ex.block.has(letter);
  const std::uint32_t column = has ? ex.block[letter].column : ex.code_column;
  if (detail.empty()) detail = std::string(1, letter);
  return ex.alarm_code(rules.code(fault), column, std::move(detail));
}

bool plane_axes(Executor& ex, const Rules& rules, PlaneAxes& axes) {
  constexpr PlaneAxes kNames[] = {
      {0, 0, 'X', 'Y', 'U', 'V'}, {0, 0, 'Z', 'X', 'W', 'U'}, {0, 0, 'Y', 'Z', 'V', 'W'}};
  axes = kNames[static_cast<std::size_t>(ex.plane)];
  const auto u = ex.axis_named(axes.u_name);
  const auto v = ex.axis_named(axes.v_name);
  if (!u || !v) return fail(ex, rules, Fault::wrong_plane, axes.u_name);
  axes.u = *u;
  axes.v = *v;
  return true;
}

bool take_range(Executor& ex, const Rules& rules, BlockRange& range) {
  const program::Block& b = ex.block;
  if (rules.refused_in_mdi && ex.switches.origin == interp::ProgramOrigin::mdi)
    return ex.alarm(interp::AlarmReason::mdi_cycle, ex.code_column, std::string(ex.code->name));
  for (const char letter : {'P', 'Q'}) {
    if (!b.has(letter)) return fail(ex, rules, Fault::no_range, letter);
    const program::Word& word = b[letter];
    const std::int64_t number = word.integer();
    if (number < 0 || number > rules.most_sequence || word.digits % program::kPowerOfTen[word.decimals] != 0) {
      return fail(ex, rules, Fault::range_number, letter);
    }
    (letter == 'P' ? range.first : range.last) = static_cast<std::uint32_t>(number);
  }
  if (rules.code(Fault::range_order) == "158" && range.first >= range.last)
    return fail(ex, rules, Fault::range_order, 'Q');
  return true;
}

bool read_profile(Executor& ex, const Rules& rules, BlockRange range, Profile& profile) {
  PlaneAxes axes;
  if (!plane_axes(ex, rules, axes)) return false;
  if (ex.cycle.hole.code != nullptr)
    return fail(ex, rules, Fault::modal_state, 'P', std::string(ex.cycle.hole.code->name));
  profile.start = {ex.slide_mm(axes.u), ex.slide_mm(axes.v)};

  const Modal before(ex);
  const Place behind = behind_block(ex);
  const std::size_t depth = ex.frames.size();
  if (!go_to(ex, behind)) return fail(ex, rules, Fault::not_stored, 'P');
  const auto place = find_profile(ex, range, behind);
  if (!place) return fail(ex, rules, Fault::not_found, 'P', "N" + std::to_string(range.first));
  if (rules.must_follow && place->offset < behind.offset) return fail(ex, rules, Fault::not_following, 'P');
  go_to(ex, *place);

  // Carried out into a list of its own.
  Operation* const out = ex.out;
  const bool out_used = ex.out_used;
  auto queue = std::exchange(ex.queue, {});
  const std::size_t queue_head = std::exchange(ex.queue_head, 0);
  Operation made;
  ex.out = &made;
  interp::Pipeline pipeline = std::exchange(ex.pipeline, {});
  ex.pipeline.corners_only();  // the profile is roughed as it is written, with its chamfers and rounds
  auto watch = std::make_unique<Reading>(rules, range, depth);
  Reading& reading = *watch;
  ex.cycle.watch = std::move(watch);

  Point here = profile.start;
  bool wrong_axis = false;
  std::optional<interp::Alarm> raised;
  const auto point = [&](const interp::AxisVector& work) {
    return Point{work[axes.u] * ex.axes[axes.u].mm_per_unit, work[axes.v] * ex.axes[axes.v].mm_per_unit};
  };
  const auto take = [&](const Operation& operation) {
    if (const auto* alarm = std::get_if<interp::Alarm>(&operation)) raised = *alarm;
    if (const auto* dwell = std::get_if<interp::Dwell>(&operation);
        dwell != nullptr && !profile.segments.empty()) {
      profile.segments.back().dwell_s += dwell->seconds;
    }
    const auto add = [&](const interp::Motion& motion, Segment s) {
      if ((motion.axes & ~(1u << axes.u | 1u << axes.v)) != 0) wrong_axis = true;
      s.from = here;
      s.to = point(motion.end_work);
      if (s.arc || std::hypot(s.to.u - s.from.u, s.to.v - s.from.v) > kTiny) profile.segments.push_back(s);
      here = s.to;
    };
    if (const auto* rapid = std::get_if<interp::Rapid>(&operation)) add(*rapid, {.rapid = true});
    if (const auto* feed = std::get_if<interp::Feed>(&operation)) add(*feed, {});
    if (const auto* arc = std::get_if<interp::Arc>(&operation)) {
      const double sweep = arc->turns * 2 * std::numbers::pi * (arc->turn == interp::Turn::ccw ? 1 : -1);
      add(*arc, {.arc = true, .center = point(arc->center_work), .sweep = sweep});
    }
  };
  bool stuck = false;
  bool approach_held = false;  // a corner at the end of A → A': where the contour begins would be unknown
  ex.modal_memory.hold(true);
  while (!reading.over() && !ex.finished && !stuck) {
    ex.out_used = false;
    stuck = ex.step() != Executor::Step::done;  // a signal cannot be waited for in the middle of a profile
    if (ex.pipeline.active()) ex.pipeline.take(ex);
    if (reading.count() == 1) {
      if (ex.out_used) profile.first_rapid = !std::holds_alternative<interp::Feed>(made);
    }
    if (ex.out_used) take(made);
    for (const Operation& operation : ex.queue) take(operation);
    ex.queue.clear();
    if (reading.count() <= 1) {
      profile.approach = profile.segments.size();
      approach_held = ex.pipeline.holds_corner();
    }
  }

  ex.modal_memory.hold(false);
  const bool corner_open = ex.pipeline.holds_corner();
  const bool line_open = ex.pipeline.line_is_open();
  ex.pipeline = std::move(pipeline);
  const interp::CompensationMode tool = ex.pipeline.mode_of(ex);
  const auto words = reading.first_words();
  const auto named = [&](char a, char b) {
    return (words & (program::letter_bit(a) | program::letter_bit(b))) != 0;
  };
  profile.first_moves_u = named(axes.u_name, axes.u_step);
  profile.first_moves_v = named(axes.v_name, axes.v_step);

  ex.out = out;
  ex.out_used = out_used;
  ex.queue = std::move(queue);
  ex.queue_head = queue_head;
  const auto ended = std::move(ex.cycle.watch);  // `reading` is asked once more below
  if (raised) {
    ex.finished = false;
    auto& alarm = ex.emit<interp::Alarm>();
    alarm = *raised;
    ex.finished = true;
    return false;
  }
  ex.finished = false;
  before.restore(ex);
  if (stuck || !reading.over())
    return fail(ex, rules, Fault::not_found, 'Q', "N" + std::to_string(range.last));
  if (line_open) return fail(ex, rules, Fault::last_open, 'Q');
  if (corner_open) return ex.alarm(interp::AlarmReason::corner_profile_end, 0, "Q");
  if (approach_held) return fail(ex, rules, Fault::first_block, 'P', "corner in the first block");
  if (wrong_axis) return fail(ex, rules, Fault::wrong_plane, 'P');
  if (profile.segments.empty()) return fail(ex, rules, Fault::not_found, 'P', "no motion");
  if (rules.radius_in_roughing && tool.wanted && !offset_profile(ex, rules, tool, profile)) return false;

  auto& known = ex.cycle.profile;
  known = {ex.at.program, range.first, range.last, place->offset, place->line, true};
  if (place->offset < behind.offset && !go_to(ex, behind)) return fail(ex, rules, Fault::not_stored, 'P');
  return true;
}

bool start_finishing(Executor& ex, const Rules& rules, BlockRange range) {
  const Place behind = behind_block(ex);
  if (!go_to(ex, behind)) return fail(ex, rules, Fault::not_stored, 'P');
  const auto& known = ex.cycle.profile;
  std::optional<Place> place;
  if (known.valid && known.program == ex.at.program && known.first == range.first &&
      known.last == range.last) {
    place = Place{known.offset, known.line};
  } else {
    place = find_profile(ex, range, behind);
  }
  if (!place) return fail(ex, rules, Fault::not_found, 'P', "N" + std::to_string(range.first));
  if (!go_to(ex, *place)) return fail(ex, rules, Fault::not_stored, 'P');
  ex.cycle.watch = std::make_unique<Finishing>(rules, range, ex, behind);
  ex.cycle.starts_cycle = true;
  ex.cycle.name = "G70";
  return true;
}

}  // namespace headstock::cycles

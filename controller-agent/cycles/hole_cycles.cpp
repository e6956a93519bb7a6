// Hole cycles: their words, modal until G80 or a code of group 01.
#include <algorithm>
#include <bit>
#include <cmath>
#include <string_view>

#include "cycles/handlers.hpp"
#include "cycles/hole_codes.hpp"
#include "cycles/hole_run.hpp"
#include "cycles/thread_words.hpp"
#include "cycles/turning_run.hpp"

namespace headstock::cycles {
namespace {

using enum HoleBottom;
using interp::Executor;
using interp::SpindleDirection;

// The axis that G54.9 made the first, second or third of the space; 0: none.
char axis_in_role(const Executor& ex, int role) {
  for (std::size_t i = 0; i < ex.axes.size(); ++i)
    if (ex.role_of(i) == role) return ex.axes[i].name;
  return 0;
}

char drilling_axis(Executor& ex, const Rules& rules, const HoleCode& code) {
  if (code.axis != 0) return code.axis;
  if (rules.holes == HoleFamily::k2000) {
    if (!ex.block.has('J')) {
      if (ex.cycle.hole.entered) return ex.axes[ex.cycle.hole.axis].name;
      return ex.roles_given && ex.data.bit("P3300.6") ? axis_in_role(ex, 3) : 'Z';
    }
    const double j = ex.block['J'].value();
    const int role = j == 1 ? 1 : j == 2 ? 2 : 3;
    if (ex.roles_given && ex.data.bit("P3300.6")) return axis_in_role(ex, role);  // DRG954
    return "XYZ"[role - 1];
  }
  if (!ex.data.bit("5101#0")) return 'Z';  // FXY
  constexpr char kNormal[] = {'Z', 'Y', 'X'};
  return kNormal[static_cast<std::size_t>(ex.plane)];
}

// Level words: bottom and R of this block, kept for the next positions.
bool take_levels(Executor& ex, const Rules& rules, char name) {
  interp::HoleWords& words = ex.cycle.hole;
  const program::Block& b = ex.block;
  const std::size_t axis = words.axis;
  constexpr std::string_view kSteps = "XUYVZWCH";
  const std::size_t place = kSteps.find(name);
  const char step =
      rules.holes == HoleFamily::mill || place == kSteps.npos || place % 2 != 0 ? '\0' : kSteps[place + 1];
  const bool by_letter =
      step != 0 && b.has(step) && (ex.incremental_letters & program::letter_bit(step)) != 0;
  if (b.has('R')) {
    const bool from_initial = rules.r_from_initial || ex.incremental;
    const double r = rules.r_as_axis ? slide_word(ex, b['R'], axis) : ex.length_mm(b['R']);
    words.reference = from_initial ? words.initial + r : r;
    words.has_reference = true;
  }
  if (!words.has_reference) words.reference = words.initial;
  if (by_letter || b.has(name)) {
    const double value = slide_word(ex, by_letter ? b[step] : b[name], axis);
    const bool from_r = by_letter || ex.incremental;
    const double base = rules.holes == HoleFamily::lathe_200t ? words.initial : words.reference;
    words.bottom = from_r ? base + value : value;
    words.has_bottom = true;
  }
  return true;
}

bool take_counts(Executor& ex, const Rules& rules) {
  interp::HoleWords& words = ex.cycle.hole;
  const program::Block& b = ex.block;
  if (b.has('Q'))
    words.peck = std::fabs(count_length(ex, b['Q'], rules.holes == HoleFamily::turning ? 0.001 : 0));
  if (b.has('P')) words.dwell_s = b['P'].value() / 1000;
  if (words.dwell_s < 0) return fail(ex, rules, Fault::value, 'P');
  if (rules.holes == HoleFamily::lathe_200t && b.has('K')) words.retract = std::fabs(ex.length_mm(b['K']));
  return true;
}

// How often this block drills. @return -1 after an alarm; 0: only the words are kept.
std::int64_t repeats(Executor& ex, const Rules& rules) {
  const program::Block& b = ex.block;
  if (rules.holes == HoleFamily::lathe_200t) return 1;
  const char letter = rules.holes == HoleFamily::k2000 ? 'L' : 'K';
  if (rules.holes == HoleFamily::k2000 && b.has('K')) {
    if (b['K'].value() != 0) return fail(ex, rules, Fault::hole_k, 'K'), -1;
    if (ex.data.bit("P3300.7")) return 0;
  }
  const char used = b.has(letter) ? letter : rules.holes == HoleFamily::mill && b.has('L') ? 'L' : 0;
  if (used == 0) return 1;
  const double value = b[used].value();
  if (value < 0 || value > 9'999 || value != std::floor(value))
    return fail(ex, rules, Fault::hole_k, used), -1;
  if (value == 0 && rules.holes != HoleFamily::k2000 && ex.data.bit("5105#4")) return 1;  // K0D
  return static_cast<std::int64_t>(value);
}

bool returns_to_r(const Executor& ex) {
  const dialects::GCode* row = ex.table->find(990);  // where G99 is a return level at all
  return row != nullptr && row->handler == nullptr && row->group != 0 && ex.modal.g[row->group] == 990;
}

// The way out of the hole's wall for G76, G86.5, G87.
void shift_of(const Executor& ex, const Rules& rules, double amount, Hole& hole) {
  if (rules.holes == HoleFamily::k2000) {
    const int which = (ex.data.bit("P3300.4") ? 1 : 0) + (ex.data.bit("P3300.5") ? 2 : 0);
    (which >= 2 ? hole.shift_v : hole.shift_u) = which % 2 != 0 ? -amount : amount;
    return;
  }
  const double direction = ex.data.parameter("5148/Z", ex.data.parameter("5148", 1));
  (std::fabs(direction) == 2 ? hole.shift_v : hole.shift_u) = direction < 0 ? -amount : amount;
}

bool prepare_tap(Executor& ex, const Rules& rules, const HoleCode& code, Hole& hole) {
  interp::HoleWords& words = ex.cycle.hole;
  const bool k2000 = rules.holes == HoleFamily::k2000;
  if (ex.cycle.rigid_next) words.rigid = true;
  ex.cycle.rigid_next = false;
  hole.synchronous =
      code.rigid || words.rigid ||
      (k2000 ? ex.data.parameter("P2730") != 0 || ex.data.bit("P2700.3") : ex.data.bit("5200#0"));
  hole.stop_before_reversal = k2000 || !ex.data.bit("5105#3");
  if (!hole.synchronous) return true;
  const program::Block& b = ex.block;
  if (!(ex.rpm > 0) || ex.constant_surface_speed) return fail(ex, rules, Fault::rigid_speed, 'S');
  constexpr std::string_view kMostOfGear[] = {"5241", "5242", "5243", "5244"};
  const std::size_t gear = std::clamp<std::size_t>(ex.gear_of(ex.rpm), 1, std::size(kMostOfGear)) - 1;
  const double most = ex.data.parameter(kMostOfGear[gear]);
  if (!k2000 && most > 0 && ex.rpm > most) return fail(ex, rules, Fault::rigid_speed, 'S');
  if (k2000) {
    const double spindle = ex.data.parameter("P2730");  // an axis that taps as the spindle
    const auto its = static_cast<std::size_t>(spindle);
    if (spindle >= 1 && (its > ex.axes.size() || !ex.axes[its - 1].rotary))
      return ex.alarm_code("PS0277", ex.code_column, "P2730");
  }
  if (k2000) {  // F is the lead, or I threads per inch
    if (b.has('F')) words.lead_mm = b['F'].value() * ex.unit_mm;
    if (b.has('I') && b['I'].value() > 0) words.lead_mm = 25.4 / b['I'].value();
    hole.pitch_mm = words.lead_mm;
    if (std::fabs(hole.bottom - hole.reference) > 1491 * hole.pitch_mm && hole.pitch_mm > 0)
      return fail(ex, rules, Fault::rigid_distance, 'Z');
    hole.tap_pecks_out = !ex.data.bit("P2700.7");
    hole.clearance = ex.data.parameter("P3410");
  } else {
    hole.pitch_mm = ex.feed_unit == interp::FeedUnit::mm_per_revolution ? ex.feed_mm : ex.feed_mm / ex.rpm;
    hole.tap_pecks_out = ex.data.bit("5200#5");  // PCP
    hole.clearance = ex.data.parameter("5213");
  }
  if (!(hole.pitch_mm > 0)) return fail(ex, rules, Fault::rigid_feed, 'F');
  return true;
}

}  // namespace

bool hole_cycle(Executor& ex) {
  const Rules& rules = rules_of(ex.dialect);
  const program::Block& b = ex.block;
  const bool modal = ex.code->phase == dialects::Phase::hole;
  interp::HoleWords& words = ex.cycle.hole;
  const HoleCode* code = hole_code(rules.holes, ex.code->tenths);
  if (code == nullptr)
    return ex.alarm(dialects::AlarmReason::g_unavailable, ex.code_column, std::string(ex.code->name));

  const char name = drilling_axis(ex, rules, *code);
  const auto axis = ex.axis_named(name);
  if (!axis) return fail(ex, rules, Fault::hole_axis, name);
  if (modal && words.entered && words.axis != *axis) {  // another drilling axis: its words begin anew
    const dialects::GCode* kept = words.code;
    words = {};
    words.code = kept;
  }
  if (!words.entered || !modal) {
    words.axis = *axis;
    words.initial = ex.slide_mm(*axis);
    words.entered = true;
  }
  if ((b.words & (ex.axis_letters | program::letter_bit('R'))) == 0) return true;  // nothing to drill

  if (!take_levels(ex, rules, name) || !take_counts(ex, rules)) return false;
  Target target;
  for (std::uint32_t mask = b.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    const auto i = static_cast<std::size_t>(ex.axis_of[letter]);
    if (i == *axis) continue;
    // DRPNCA: axes that are none of the space's may not be where a hole is.
    if (rules.holes == HoleFamily::k2000 && ex.role_of(i) == 0 && ex.data.parameter("P3300.3", 1) == 0)
      return fail(ex, rules, Fault::hole_axis, static_cast<char>('A' + letter));
    const bool by = ex.incremental || (ex.incremental_letters >> letter & 1u) != 0;
    target.axes |= 1u << i;
    if (by) target.incremental |= 1u << i;
    target.step[i] =
        static_cast<double>(ex.round_to(ex.nano(b.word[letter], ex.axes[i].increment), ex.axes[i].increment));
  }
  const bool small = ex.cycle.small_holes && code->tenths == 830;
  for (const char letter : {'I', 'J'}) {  // I: the travel feed of small-hole pecking
    if (rules.holes == HoleFamily::mill && b.has(letter) && !(small && letter == 'I'))
      return fail(ex, rules, Fault::value, letter);
  }
  const std::int64_t times = repeats(ex, rules);
  if (times < 0) return false;
  if (times == 0) {  // the words are kept; K2000 goes to the position
    if (rules.holes != HoleFamily::k2000 || target.axes == 0) return true;
    std::uint32_t moved = 0;
    const auto words_kept = ex.block.words;
    ex.block.words &= ~(program::letter_bit(name));
    const bool ok = ex.take_targets(moved);
    ex.block.words = words_kept;
    if (!ok) return false;
    auto& motion = ex.emit<interp::Rapid>();
    ex.fill_motion(motion, moved);
    return true;
  }
  if (!words.has_bottom) return fail(ex, rules, Fault::hole_axis, name);

  Hole hole;
  hole.kind = code->kind;
  hole.initial = words.initial;
  hole.reference = words.reference;
  hole.bottom = words.bottom;
  hole.to_reference = returns_to_r(ex) && hole.kind.in != HoleIn::up;
  hole.peck = words.peck;
  hole.dwell_s = words.dwell_s;
  if (rules.holes == HoleFamily::turning && hole.kind.out == HoleOut::feed && hole.kind.tap == HoleTap::none)
    hole.out_ratio = ex.data.parameter("5149", 100) / 100;  // G85, G89
  if (!(hole.out_ratio >= 0.01 && hole.out_ratio <= 20)) return fail(ex, rules, Fault::value, 0, "No.5149");
  hole.main_turns = ex.spindle_direction != SpindleDirection::stop;
  hole.dwell_at_reference = rules.holes != HoleFamily::k2000;
  if (rules.driven_m != 0 && ex.cycle.driven_m != 0) hole.driven_m = rules.driven_m;
  hole.turning = ex.cycle.driven_m == rules.driven_m + 1 && hole.driven_m != 0 ? SpindleDirection::ccw
                 : ex.spindle_direction == SpindleDirection::stop              ? SpindleDirection::cw
                                                                               : ex.spindle_direction;
  const bool pecking = hole.kind.in == HoleIn::pecks_back || hole.kind.in == HoleIn::pecks_out ||
                       hole.kind.in == HoleIn::pecks_out_feed;
  if (pecking && hole.peck <= 0 && rules.holes != HoleFamily::turning)
    return fail(ex, rules, Fault::hole_peck, 'Q');
  if (rules.holes == HoleFamily::turning && code->tenths != 831 && pecking && !ex.data.bit("5101#2")) {
    hole.kind.in = HoleIn::pecks_back;  // RTR = 0: high-speed pecking
  }
  const bool back = hole.kind.in == HoleIn::pecks_back;
  hole.clearance =
      rules.holes == HoleFamily::lathe_200t
          ? words.retract
          : ex.data.parameter(back ? rules.parameters.peck_back : rules.parameters.peck_clearance);
  if (hole.kind.bottom == HoleBottom::orient_shift) {
    if (hole.kind.in != HoleIn::up && rules.holes == HoleFamily::k2000 && words.peck <= 0)
      return fail(ex, rules, Fault::hole_peck, 'Q');
    shift_of(ex, rules, words.peck, hole);
  }
  // R lies between the initial level and the bottom; back boring turns the last two round.
  const double depth = hole.bottom - hole.reference;
  if (std::fabs(depth) < kTiny) return fail(ex, rules, Fault::hole_depth, name);
  const double approach = hole.reference - hole.initial;
  const bool same_way = std::fabs(approach) < kTiny || (approach < 0) == (depth < 0);
  if (hole.kind.in == HoleIn::up ? same_way : false) return fail(ex, rules, Fault::hole_depth, name);
  if (hole.kind.tap != HoleTap::none && !prepare_tap(ex, rules, *code, hole)) return false;
  if (!(hole.synchronous && rules.holes == HoleFamily::k2000) && !check_feed(ex)) return false;
  HoleJob job;
  job.axis = *axis;
  job.target = target;
  job.times = times;
  job.clamp_m = words.clamp ? ex.cycle.clamp_m : 0;
  job.stops = rules.holes != HoleFamily::lathe_200t;
  std::array<std::size_t, 2>& plane = job.plane;
  std::size_t count = 0;
  for (std::size_t i = 0; i < ex.axes.size() && count < 2; ++i) {
    if (i != *axis && !ex.axes[i].rotary) plane[count++] = i;
  }
  if (count == 1) plane[1] = *axis;
  if (count == 0) plane = {*axis, *axis};
  job.hole = hole;
  if (small) {
    job.small = small_hole_job(ex, hole);
    if (!job.small) return false;
  }
  start_holes(ex, code->name, job);
  return true;
}

// G80.
bool hole_cancel(Executor& ex) {
  ex.cycle.hole = {};
  ex.cycle.rigid_next = ex.cycle.small_holes = false;
  ex.cycle.rigid_tap_axis = -1;
  return true;
}

}  // namespace headstock::cycles

// G90, G92, G94 (G77…G79, G20…G24 in the other systems) and G74, G75: words and alarms.
#include <algorithm>
#include <bit>
#include <cmath>

#include "cycles/handlers.hpp"
#include "cycles/single.hpp"
#include "cycles/thread_words.hpp"
#include "cycles/tool_radius.hpp"
#include "cycles/turning_run.hpp"

namespace headstock::cycles {
namespace {

using interp::Executor;

// Takes X Z R of the block into the modal words of the cycle. Words stay until another cycle or code ends
// them.
bool take_box_words(Executor& ex, const Rules& rules, const PlaneAxes& axes) {
  interp::BoxWords& words = ex.cycle.box;
  const program::Block& b = ex.block;
  const bool repeats = words.owner == ex.code->handler;
  if (!repeats) {
    words = {};
    words.owner = ex.code->handler;
  }
  const bool same_code_written = b.g_count != 0;
  for (std::uint32_t mask = b.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    const auto axis = static_cast<std::size_t>(ex.axis_of[letter]);
    const char name = static_cast<char>('A' + letter);
    if (axis != axes.u && axis != axes.v) {
      return fail(ex, rules, Fault::box_axis, name);
    }
    const bool step = (ex.incremental_letters >> letter & 1u) != 0 || ex.incremental;
    const double word = slide_word(ex, b.word[letter], axis);
    // 200T: a repetition without the code counts its increments from the last cut's end (E24).
    const bool from_last =
        rules.steps_from_last_end && repeats && !same_code_written && (words.given >> axis & 1u) != 0;
    words.end[axis] = step ? word + (from_last ? words.end[axis] : ex.slide_mm(axis)) : word;
    words.given |= 1u << axis;
  }
  if (b.has('R')) words.taper = ex.length_mm(b['R']);
  return true;
}

Point box_end(const Executor& ex, const PlaneAxes& axes) {
  const interp::BoxWords& words = ex.cycle.box;
  const auto value = [&](std::size_t axis) {
    return (words.given >> axis & 1u) != 0 ? words.end[axis] : ex.slide_mm(axis);
  };
  return {value(axes.u), value(axes.v)};
}

// The start of the cut must not lie beyond the tool: |R| ≤ the infeed when their signs differ.
bool check_taper(Executor& ex, const Rules& rules, double infeed, double taper) {
  if (taper == 0 || infeed == 0 || (taper < 0) == (infeed < 0) ||
      std::fabs(taper) <= std::fabs(infeed) + kTiny)
    return true;
  return fail(ex, rules, Fault::taper, 'R');
}

bool box(Executor& ex, bool facing, const char* name) {
  const Rules& rules = rules_of(ex.dialect);
  PlaneAxes axes;
  if (!plane_axes(ex, rules, axes) || !take_box_words(ex, rules, axes)) return false;
  Box job;
  job.facing = facing;
  job.start = here(ex, axes);
  job.end = box_end(ex, axes);
  job.taper = ex.cycle.box.taper;
  const double infeed = facing ? job.end.u - job.start.u : job.end.v - job.start.v;
  if (!check_taper(ex, rules, infeed, job.taper)) return false;
  if (!check_feed(ex)) return false;
  if (job.end.u == job.start.u && job.end.v == job.start.v && job.taper == 0) return true;
  const interp::CompensationMode tool = ex.pipeline.mode_of(ex);
  // G41/G42 in the block of the cycle itself: without it (218T L7910).
  const bool written_here =
      std::any_of(ex.settings.begin(), ex.settings.begin() + ex.setting_count,
                  [](const dialects::GCode* set) { return set->tenths == 410 || set->tenths == 420; });
  if (rules.radius_in_boxes && tool.wanted && tool.radius != 0 && !written_here) {
    BesideBox beside{std::fabs(tool.radius), {}};
    if (rules.tip_in_boxes) beside.tip = {tool.tip.u, tool.tip.v};
    start(ex, name, axes, box_cut_beside(job, beside));
    return true;
  }
  start(ex, name, axes, box_cut(job));
  return true;
}

}  // namespace

bool turning_box(Executor& ex) {
  return box(ex, false, "G90");
}

bool facing_box(Executor& ex) {
  return box(ex, true, "G94");
}

bool thread_box(Executor& ex) {
  const Rules& rules = rules_of(ex.dialect);
  PlaneAxes axes;
  if (!plane_axes(ex, rules, axes) || !take_box_words(ex, rules, axes)) return false;
  interp::BoxWords& words = ex.cycle.box;
  ThreadPass job;
  job.start = here(ex, axes);
  job.end = box_end(ex, axes);
  job.taper = words.taper;
  if (!check_taper(ex, rules, job.end.v - job.start.v, job.taper)) return false;
  if (std::fabs(job.end.u - job.start.u) < kTiny) {
    if (std::fabs(job.end.v - job.start.v) < kTiny && job.taper == 0) return true;
    return fail(ex, rules, Fault::value, axes.u_name);  // no face threads
  }
  if (job.end.v == job.start.v && job.taper == 0) return fail(ex, rules, Fault::thread_in_vain, axes.v_name);
  if (!take_thread_words(ex, rules, axes, ThreadUse::single, job)) return false;
  remember_thread(ex, axes, job);
  start(ex, "G92", axes, thread_pass(job));
  return true;
}

namespace {

// P and Q of G74, G75: a step without a sign. @return false after an alarm.
bool step_word(Executor& ex, const Rules& rules, char letter, double factor, double& step) {
  const program::Block& b = ex.block;
  if (!b.has(letter)) return true;
  const program::Word& word = b[letter];
  const double value = count_length(ex, word, rules.peck_unit_mm);
  if (value < 0) return fail(ex, rules, Fault::peck, letter);
  step = value * factor;
  return true;
}

bool peck_cycle(Executor& ex, bool across_first, const char* name) {
  const Rules& rules = rules_of(ex.dialect);
  const program::Block& b = ex.block;
  PlaneAxes axes;
  if (!plane_axes(ex, rules, axes)) return false;
  const auto u = target_word(ex, axes.u, axes.u_name, axes.u_step);
  const auto v = target_word(ex, axes.v, axes.v_name, axes.v_step);
  if (!u && !v) {  // the first block: only e
    if (b.has('P') || b.has('Q'))
      return fail(ex, rules, Fault::value, across_first ? axes.v_name : axes.u_name);
    if (!b.has('R')) return fail(ex, rules, Fault::value, 'R');
    const double back = ex.length_mm(b['R']);
    if (back < 0) return fail(ex, rules, Fault::value, 'R');
    keep(ex, rules.parameters.peck_retract, back);
    return true;
  }
  Pecking job;
  job.across_first = across_first;
  job.start = here(ex, axes);
  job.end = {u.value_or(job.start.u), v.value_or(job.start.v)};
  job.back = ex.data.parameter(rules.parameters.peck_retract);
  job.full_retract = ex.data.bit(rules.parameters.peck_full_retract);
  const double diameter = rules.peck_across_diameter ? std::fabs(ex.axes[axes.v].diameter) : 1;
  double across = 0, along = 0;
  if (!step_word(ex, rules, 'P', diameter, across) || !step_word(ex, rules, 'Q', 1, along)) return false;
  job.peck = across_first ? across : along;
  job.step = across_first ? along : across;
  if (b.has('R')) {
    const double relief = ex.length_mm(b['R']);
    job.relief = std::fabs(relief);
    job.relief_sign = relief;
  }
  const double depth = across_first ? job.end.v - job.start.v : job.end.u - job.start.u;
  const double width = across_first ? job.end.u - job.start.u : job.end.v - job.start.v;
  if (std::fabs(depth) < kTiny) return fail(ex, rules, Fault::peck, across_first ? axes.v_name : axes.u_name);
  if (job.peck <= 0 && rules.peck_needed) return fail(ex, rules, Fault::peck, across_first ? 'P' : 'Q');
  if (std::fabs(width) > kTiny && job.step <= 0)
    return fail(ex, rules, Fault::peck_step, across_first ? 'Q' : 'P');
  // Away from the side the steps go to; a sign is for the holes that step nowhere.
  if (std::fabs(width) > kTiny && job.relief_sign < 0) return fail(ex, rules, Fault::peck_relief, 'R');
  if (!check_feed(ex)) return false;
  start(ex, name, axes, pecking(job), rules.stops);
  return true;
}

}  // namespace

bool face_pecking(Executor& ex) {
  return peck_cycle(ex, false, "G74");
}

bool side_pecking(Executor& ex) {
  return peck_cycle(ex, true, "G75");
}

}  // namespace headstock::cycles

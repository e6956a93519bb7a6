// G70-G73: their blocks' words and alarms; the cuts are planned in roughing.cpp and pockets.cpp.
#include <algorithm>
#include <bit>
#include <cmath>

#include "cycles/handlers.hpp"
#include "cycles/profile.hpp"
#include "cycles/roughing.hpp"
#include "cycles/turning_run.hpp"

namespace headstock::cycles {
namespace {

using interp::Executor;

constexpr double kMostLevels = 100'000;  // ours: less per cut than any tool takes

bool second_block(const program::Block& b) {
  return b.has('P') || b.has('Q');
}

// A letter that the cycle does not know is an alarm: U, V, W of another plane above all.
bool only_letters(Executor& ex, const Rules& rules, const PlaneAxes& axes, const char* others) {
  const std::uint32_t known =
      program::letters(others) | program::letter_bit(axes.u_step) | program::letter_bit(axes.v_step);
  const std::uint32_t wrong = ex.block.words & ~known;
  if (wrong == 0) return true;
  const char letter = static_cast<char>('A' + std::countr_zero(wrong));
  return fail(ex, rules,
              program::letter_bit(letter) & program::letters("UVW") ? Fault::wrong_plane : Fault::value,
              letter);
}

// Δd and e of the first block: kept in parameters until changed.
bool keep_depth(Executor& ex, const Rules& rules, char depth_letter) {
  const program::Block& b = ex.block;
  if (b.has(depth_letter)) {
    const double depth = ex.length_mm(b[depth_letter]);
    if (depth <= 0) return fail(ex, rules, Fault::depth, depth_letter);
    keep(ex, rules.parameters.depth, depth);
  }
  if (b.has('R')) {
    const double retract = ex.length_mm(b['R']);
    if (retract < 0) return fail(ex, rules, Fault::value, 'R');
    keep(ex, rules.parameters.retract, retract);
  }
  return true;
}

// The allowances Δw along the first axis and Δu across, signed, as slide mm.
Point allowance(const Executor& ex, const PlaneAxes& axes) {
  const program::Block& b = ex.block;
  return {b.has(axes.u_step) ? slide_word(ex, b[axes.u_step], axes.u) : 0,
          b.has(axes.v_step) ? slide_word(ex, b[axes.v_step], axes.v) : 0};
}

bool check_monotonic(Executor& ex, const Rules& rules, const Roughing& job, bool pockets) {
  bool checked = rules.check == Check::always;
  if (rules.check == Check::by_k_word) checked = ex.block.has('K') && ex.block['K'].value() == 1;
  if (rules.check == Check::unless_parameter) checked = !ex.data.bit(rules.check_off_parameter);
  if (!checked) return true;
  const Backward back = backward(job);
  // Tolerances are per axis of the plane, not per direction of cutting.
  const double first = ex.data.parameter(rules.parameters.tolerance_along);
  const double second = ex.data.parameter(rules.parameters.tolerance_across);
  const double along = job.facing ? second : first;
  const double across = job.facing ? first : second;
  if (back.along > along + kTiny) {
    return fail(ex, rules, job.facing ? Fault::not_monotonic_across : Fault::not_monotonic_along, 'P');
  }
  if (!pockets && back.across > across + kTiny) {
    return fail(ex, rules, job.facing ? Fault::not_monotonic_along : Fault::not_monotonic_across, 'P');
  }
  return true;
}

// The approach A → A' apart from the contour A' → B.
bool split(Executor& ex, const Rules& rules, Profile& read, bool& approach_rapid, Path& contour) {
  if (read.segments.size() <= read.approach)
    return fail(ex, rules, Fault::not_found, 'P', "no contour behind the first block");
  approach_rapid = read.first_rapid;
  contour.assign(read.segments.begin() + static_cast<std::ptrdiff_t>(read.approach), read.segments.end());
  return true;
}

bool stock_removal(Executor& ex, bool facing) {
  const Rules& rules = rules_of(ex.dialect);
  const program::Block& b = ex.block;
  PlaneAxes axes;
  if (!plane_axes(ex, rules, axes) || !only_letters(ex, rules, axes, "PQRDKFST")) return false;
  const char depth_letter = facing ? axes.u_step : axes.v_step;
  const bool one_block = rules.one_block_form && (ex.data.bit(rules.one_block_parameter) || b.has('D'));
  if (!second_block(b)) return keep_depth(ex, rules, depth_letter);

  Roughing job;
  job.facing = facing;
  if (one_block) {
    if (!b.has('D')) return fail(ex, rules, Fault::depth, 'D');
    job.depth = ex.length_mm(b['D']);
  } else {
    job.depth = ex.data.parameter(rules.parameters.depth);
  }
  job.retract = ex.data.parameter(rules.parameters.retract);
  BlockRange range;
  if (!take_range(ex, rules, range)) return false;
  if (!(job.depth > 0)) return fail(ex, rules, Fault::depth, one_block ? 'D' : depth_letter);
  if (!check_feed(ex)) return false;
  job.allowance = allowance(ex, axes);

  Profile read;
  if (!read_profile(ex, rules, range, read)) return false;
  const bool both = read.first_moves_u && read.first_moves_v;
  const bool along_only =
      facing ? read.first_moves_v && !read.first_moves_u : read.first_moves_u && !read.first_moves_v;
  if (along_only || (both && rules.shapes == Shapes::parallel)) {
    return fail(ex, rules, Fault::first_block_axis, 'P');
  }
  if (!split(ex, rules, read, job.approach_rapid, job.profile)) return false;
  job.start = read.start;
  job.level_cut_at_start = rules.level_cut_at_start;
  job.return_by_allowance = rules.return_by_allowance;
  const bool pockets = rules.shapes == Shapes::pockets || (both && rules.shapes == Shapes::by_first_block);
  job.contour_pass = rules.contour_pass &&
                     !ex.data.bit(pockets ? rules.parameters.no_contour_2 : rules.parameters.no_contour_1);
  job.contour_out = rules.contour_out_parameter.empty() || ex.data.bit(rules.contour_out_parameter);
  if (levels(job) > kMostLevels)
    return fail(ex, rules, Fault::depth, one_block ? 'D' : depth_letter, "too many cuts");
  if (!check_monotonic(ex, rules, job, pockets)) return false;
  if (above_start(job) > kTiny) return fail(ex, rules, Fault::above_start, 'P');
  if (pockets &&
      backward(job).along > kTiny) {  // within the control's tolerance, or unchecked: cuts stay above it
    start(ex, facing ? "G72" : "G71", axes, parallel_cuts(std::move(job)), rules.stops);
    return true;
  }
  start(ex, facing ? "G72" : "G71", axes,
        pockets ? pocket_cuts(std::move(job)) : parallel_cuts(std::move(job)), rules.stops);
  return true;
}

}  // namespace

bool stock_removal_turning(Executor& ex) {
  return stock_removal(ex, false);
}

bool stock_removal_facing(Executor& ex) {
  return stock_removal(ex, true);
}

bool pattern_repeating(Executor& ex) {
  const Rules& rules = rules_of(ex.dialect);
  const program::Block& b = ex.block;
  PlaneAxes axes;
  if (!plane_axes(ex, rules, axes) || !only_letters(ex, rules, axes, "PQRDIKFST")) return false;
  const bool one_block = rules.one_block_form && (ex.data.bit(rules.one_block_parameter) || b.has('D'));
  Pattern job;
  if (!second_block(b)) {  // relief as radius, both signed; passes
    if (b.has(axes.v_step)) keep(ex, rules.parameters.relief_across, ex.length_mm(b[axes.v_step]));
    if (b.has(axes.u_step)) keep(ex, rules.parameters.relief_along, ex.length_mm(b[axes.u_step]));
    if (b.has('R')) {
      const double passes = std::trunc(b['R'].value());
      if (passes < 1 || passes > 9'999'999) return fail(ex, rules, Fault::passes, 'R');
      keep(ex, rules.parameters.passes, passes);
    }
    return true;
  }
  if (one_block) {
    job.relief = {b.has('K') ? ex.length_mm(b['K']) : 0, b.has('I') ? ex.length_mm(b['I']) : 0};
    job.passes = b.has('D') ? b['D'].integer() : 1;
  } else {
    job.relief = {ex.data.parameter(rules.parameters.relief_along),
                  ex.data.parameter(rules.parameters.relief_across)};
    job.passes = static_cast<std::int64_t>(ex.data.parameter(rules.parameters.passes, 1));
  }
  if (job.passes < 1) return fail(ex, rules, Fault::passes, one_block ? 'D' : 'R');
  job.passes = std::max(job.passes, rules.least_passes);
  BlockRange range;
  if (!take_range(ex, rules, range) || !check_feed(ex)) return false;
  job.allowance = allowance(ex, axes);
  Profile read;
  if (!read_profile(ex, rules, range, read)) return false;
  if (!split(ex, rules, read, job.approach_rapid, job.profile)) return false;
  job.start = read.start;
  start(ex, "G73", axes, repeated_pattern(std::move(job)), rules.stops);
  return true;
}

bool finishing(Executor& ex) {
  const Rules& rules = rules_of(ex.dialect);
  BlockRange range;
  return take_range(ex, rules, range) && start_finishing(ex, rules, range);
}

}  // namespace headstock::cycles

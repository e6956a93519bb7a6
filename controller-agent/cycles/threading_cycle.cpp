// G76 and 200T's G192: words and alarms.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "cycles/handlers.hpp"
#include "cycles/thread_words.hpp"
#include "cycles/threading.hpp"

namespace headstock::cycles {
namespace {

using interp::Executor;

struct ArcWord {
  char letter;  // behind N
  const char* name;
  std::string_view Parameters::*factor;
  double Threading::*radius;
};
constexpr ArcWord kArcWords[] = {{'B', "NB", &Parameters::thread_arc_in, &Threading::arc_in},
                                 {'E', "NE", &Parameters::thread_arc_out, &Threading::arc_out}};
constexpr double kLeastArcFactor = 1.2;  // K2000TC L14348

bool allowed_tip(const Rules& rules, double& angle) {
  if (angle < 0 || angle > 99) return false;
  if (rules.tip_angles == nullptr) return true;
  for (const std::int64_t* tip = rules.tip_angles; *tip >= 0; ++tip) {
    if (angle == static_cast<double>(*tip)) return true;
  }
  if (rules.infer_angle_60) angle = 60;
  return rules.infer_angle_60;
}

// P m r a: two digits each; fewer digits leave the first ones as they were.
bool keep_pattern(Executor& ex, const Rules& rules) {
  const program::Word& word = ex.block['P'];
  const std::int64_t value = word.integer();
  if (value < 0 || value > 999'999 || word.decimals != 0) return fail(ex, rules, Fault::value, 'P');
  double angle = static_cast<double>(value % 100);
  if (!allowed_tip(rules, angle)) return fail(ex, rules, Fault::thread_angle, 'P');
  keep(ex, rules.parameters.tip_angle, angle);
  if (word.digit_count > 2) {
    const double runout = static_cast<double>(value / 100 % 100);
    ex.cycle.runout_tenths = runout;
    keep(ex, rules.parameters.runout, runout);
  }
  if (word.digit_count > 4) keep(ex, rules.parameters.finish_passes, static_cast<double>(value / 10'000));
  return true;
}

bool keep_setup(Executor& ex, const Rules& rules) {
  const program::Block& b = ex.block;
  if (b.has('P') && !keep_pattern(ex, rules)) return false;
  if (b.has('Q')) {
    const double least = count_length(ex, b['Q'], rules.depth_unit_mm);
    if (least < 0) return fail(ex, rules, Fault::value, 'Q');
    keep(ex, rules.parameters.least_depth, least);
  }
  if (b.has('R')) {
    const double finish = ex.length_mm(b['R']);
    if (finish < 0) return fail(ex, rules, Fault::thread_finish, 'R');
    keep(ex, rules.parameters.finish_allowance, finish);
  }
  if (b.has('E')) {  // K2000TC: s n
    if (rules.parameters.thread_method.empty()) return fail(ex, rules, Fault::value, 'E');
    const std::int64_t value = b['E'].integer();
    if (value < 0 || value / 10 > 1 || value % 10 > 3) return fail(ex, rules, Fault::value, 'E');
    keep(ex, rules.parameters.thread_start, static_cast<double>(value / 10));
    keep(ex, rules.parameters.thread_method, static_cast<double>(value % 10));
  }
  for (const ArcWord& arc : kArcWords) {
    if (!b.has_marked(arc.letter) || (rules.parameters.*arc.factor).empty()) continue;
    const program::Word& word = b.marked_at(arc.letter);
    const double factor = static_cast<double>(ex.nano(word, program::kNano / 1'000)) / 1e9;
    if (factor < kLeastArcFactor) return ex.alarm_code(rules.code(Fault::value), word.column, arc.name);
    keep(ex, rules.parameters.*arc.factor, factor);
  }
  return true;
}

// NB, NE of the thread's block: quarter circles of NB·kb and NE·ke (the figure is lost; as in G78.1, L4360).
bool take_arcs(Executor& ex, const Rules& rules, Threading& job) {
  for (const ArcWord& arc : kArcWords) {
    if (!ex.block.has_marked(arc.letter) || (rules.parameters.*arc.factor).empty()) continue;
    const program::Word& word = ex.block.marked_at(arc.letter);
    const auto wrong = [&] { return ex.alarm_code(rules.code(Fault::value), word.column, arc.name); };
    const double factor = ex.data.parameter(rules.parameters.*arc.factor, kLeastArcFactor);
    const double radius = ex.length_mm(word) * factor;
    // It must begin outside of the thread, or the tool would come down into the work.
    if (factor < kLeastArcFactor || radius <= job.height) return wrong();
    job.*arc.radius = radius;
  }
  return true;
}

// Between the tool's start and every pass there must be room for the arcs.
bool arcs_have_room(const Threading& job) {
  const double length = std::fabs(job.end.u - job.start.u), out = job.start.v < job.end.v ? -1 : 1;
  const double flank = std::tan(job.tip_angle_deg / 2 * std::numbers::pi / 180);
  // No pass begins further back or further along than these, and none lies further out than one of no depth.
  for (const double shift : {-job.height * flank, 2 * job.height * flank}) {
    if (job.arc_in + job.arc_out > length - shift) return false;
    const ThreadPass pass = pass_at(job, 0, shift);
    if (job.arc_in > 0 && out * (job.start.v - arc_height(pass, true)) < 0) return false;
    if (job.arc_out > 0 && out * (job.start.v - arc_height(pass, false)) < 0) return false;
  }
  return true;
}

// The tool must stand clear of the crest at both ends, or it would go in and out the same way.
bool stands_clear(const Threading& job) {
  const double out = job.start.v < job.end.v ? -1 : 1;
  for (const double root : {job.end.v, job.end.v + job.taper}) {
    if (out * (job.start.v - root) < job.height - kTiny) return false;
  }
  return true;
}

}  // namespace

bool multiple_threading(Executor& ex) {
  const Rules& rules = rules_of(ex.dialect);
  const program::Block& b = ex.block;
  PlaneAxes axes;
  if (!plane_axes(ex, rules, axes)) return false;
  interp::BoxWords& words = ex.cycle.box;
  if (words.owner != ex.code->handler) words.starts = 1;  // L lasts from G76 to G76, over G04 too
  words.owner = ex.code->handler;
  const auto u = target_word(ex, axes.u, axes.u_name, axes.u_step);
  const auto v = target_word(ex, axes.v, axes.v_name, axes.v_step);
  if (!u && !v) return keep_setup(ex, rules);

  Threading job;
  const bool one_block = rules.one_block_form && (ex.data.bit(rules.one_block_parameter) || b.has('D'));
  job.start = here(ex, axes);
  job.end = {u.value_or(job.start.u), v.value_or(job.start.v)};
  const auto value = [&](std::string_view parameter) {
    return parameter.empty() ? 0 : ex.data.parameter(parameter);
  };
  job.least = value(rules.parameters.least_depth);
  job.finish = value(rules.parameters.finish_allowance);
  job.finish_passes =
      std::max<std::int64_t>(1, static_cast<std::int64_t>(value(rules.parameters.finish_passes)));
  job.tip_angle_deg = value(rules.parameters.tip_angle);
  job.least_from = rules.least_from_root ? LeastFrom::root : LeastFrom::last_pass;
  std::int64_t method = static_cast<std::int64_t>(value(rules.parameters.thread_method));
  const char height_letter = one_block ? 'K' : 'P';
  const char depth_letter = one_block ? 'D' : 'Q';
  if (one_block) {  // Series 10/11: I taper, K height, D first depth, A angle, P method 1…4
    if (b.has('I')) job.taper = ex.length_mm(b['I']);
    if (b.has('K')) job.height = ex.length_mm(b['K']);
    if (b.has('D')) job.first_depth = count_length(ex, b['D'], rules.depth_unit_mm);
    if (b.has('A')) job.tip_angle_deg = b['A'].value();
    if (!allowed_tip(rules, job.tip_angle_deg)) return fail(ex, rules, Fault::thread_angle, 'A');
    if (b.has('P')) {
      constexpr std::int64_t kMethods[] = {0, 1, 2, 3};  // area, zigzag; depth, zigzag
      if (b['P'].integer() < 1 || b['P'].integer() > 4) return fail(ex, rules, Fault::value, 'P');
      method = kMethods[b['P'].integer() - 1];
    }
  } else {
    if (b.has('R')) job.taper = ex.length_mm(b['R']);
    if (b.has('P')) job.height = count_length(ex, b['P'], rules.depth_unit_mm);
    if (b.has('Q')) job.first_depth = count_length(ex, b['Q'], rules.depth_unit_mm);
  }
  job.law = method >= 2 ? DepthLaw::constant_depth : DepthLaw::constant_area;
  job.infeed = method % 2 != 0 ? Infeed::zigzag : Infeed::one_flank;
  if (!rules.parameters.thread_start.empty()) {
    job.finish_at_start = value(rules.parameters.thread_start) == 1;
    job.finish_straight = !job.finish_at_start;
  }
  if (!(job.height > 0)) return fail(ex, rules, Fault::thread_height, height_letter);
  if (!(job.first_depth > 0)) return fail(ex, rules, Fault::thread_first_depth, depth_letter);
  if (job.finish >= job.height || job.least > job.height || job.first_depth > job.height) {
    return fail(ex, rules, Fault::thread_depths, height_letter);
  }
  if (std::fabs(job.end.u - job.start.u) < kTiny) return fail(ex, rules, Fault::value, axes.u_name);
  if (std::fabs(job.end.v - job.start.v) < kTiny) return fail(ex, rules, Fault::thread_in_vain, axes.v_name);
  if (!stands_clear(job))
    return fail(ex, rules, Fault::thread_clear, axes.v_name, "start point inside the thread");
  if (!take_arcs(ex, rules, job)) return false;
  constexpr double kMostPasses = 9'999;  // ours: less per cut than any tool takes
  if (most_passes(job) > kMostPasses) return fail(ex, rules, Fault::thread_depths, depth_letter);

  ThreadPass pass;
  pass.start = job.start;
  pass.end = job.end;
  pass.taper = job.taper;
  if (!take_thread_words(ex, rules, axes, ThreadUse::multiple, pass)) return false;
  job.lead_mm = pass.lead_mm;
  job.starts = pass.starts;
  job.runout = pass.runout;
  if ((job.arc_in > 0 || job.arc_out > 0) && !arcs_have_room(job))
    return fail(ex, rules, Fault::value, axes.u_name, "NB NE");
  remember_thread(ex, axes, pass);
  start(ex, "G76", axes, threading(std::move(job)), Stops::passes);
  return true;
}

bool thread_again(Executor& ex) {
  const Rules& rules = rules_of(ex.dialect);
  PlaneAxes axes;
  if (!plane_axes(ex, rules, axes)) return false;
  const auto& last = ex.cycle.last_thread;
  if (!last.valid) return fail(ex, rules, Fault::thread_lead, 'X', "no thread to repeat");
  const auto v = target_word(ex, axes.v, axes.v_name, axes.v_step);
  if (!v) return fail(ex, rules, Fault::value, 'X');
  ThreadPass job;
  job.start = here(ex, axes);
  job.end = {last.end_first, *v};
  job.taper = last.taper;
  job.lead_mm = last.lead_mm;
  job.runout = {last.runout_at, last.runout_short};
  job.run_in = last.run_in;
  job.starts = last.starts;
  if (std::fabs(job.end.u - job.start.u) < kTiny) return fail(ex, rules, Fault::value, axes.u_name);
  start(ex, "G192", axes, thread_pass(job));
  return true;
}

}  // namespace headstock::cycles

// Tapping as a block of its own, the axis tied to the spindle.
#include <bit>
#include <cmath>

#include "cycles/handlers.hpp"
#include "cycles/hole_run.hpp"
#include "cycles/thread_words.hpp"
#include "cycles/turning_run.hpp"

namespace headstock::cycles {

using interp::Executor;
using interp::SpindleDirection;

// Tapping with the feed axis tied to the spindle: GSK G84/G88 and G33, K2000TC and 200T G93.
bool tapping(Executor& ex) {
  const Rules& rules = rules_of(ex.dialect);
  const program::Block& b = ex.block;
  const char name = ex.code->tenths == 880 ? 'X' : 'Z';
  const char step = name == 'X' ? 'U' : 'W';
  const auto axis = ex.axis_named(name);
  if (!axis) return fail(ex, rules, Fault::hole_axis, name);
  for (std::uint32_t mask = b.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    if (static_cast<std::size_t>(ex.axis_of[letter]) != *axis) {
      return fail(ex, rules, Fault::tap_block, static_cast<char>('A' + letter));
    }
  }
  const auto bottom = target_word(ex, *axis, name, step);
  if (rules.taps_down_only && (!bottom || *bottom > ex.slide_mm(*axis)))
    return fail(ex, rules, Fault::tap_block, name);
  if (!bottom || std::fabs(*bottom - ex.slide_mm(*axis)) < kTiny) return true;  // no move: no tapping
  if (b.has('F') && b.has('I')) return ex.alarm(dialects::AlarmReason::thread_f_and_i, b['I'].column, "I");
  if (b.has('F')) ex.lead_mm = b['F'].value() * ex.unit_mm;
  if (b.has('I')) ex.lead_mm = b['I'].value() > 0 ? 25.4 / b['I'].value() : 0;
  if (!(ex.lead_mm > 0)) return fail(ex, rules, Fault::tap_lead, 'F');
  // No words of a tap (2000TC L4286, 218T L1265 without starts): a tap cuts all its starts at once.
  for (const char letter : {'L', 'Q', 'P'}) {
    if (b.has(letter) && b[letter].value() != 0 && !(letter == 'L' && b['L'].value() == 1))
      return fail(ex, rules, Fault::tap_word, letter);
  }
  Hole hole;
  hole.kind = {HoleIn::once, HoleBottom::nothing, HoleOut::feed, HoleTap::right};
  hole.initial = hole.reference = ex.slide_mm(*axis);
  hole.bottom = *bottom;
  hole.pitch_mm = ex.lead_mm;
  hole.synchronous = true;
  const bool rigid = ex.cycle.rigid_next || ex.data.bit(rules.rigid_tap_parameter);
  hole.follows = !rigid;
  hole.stands_after = !rigid && !rules.rigid_tap_parameter.empty();
  int& tapping_axis = ex.cycle.rigid_tap_axis;  // G84 → G88 needs G80 between them (2000TC L4391)
  if (rigid && tapping_axis >= 0 && tapping_axis != static_cast<int>(*axis))
    return ex.alarm(dialects::AlarmReason::rigid_tap_axis, ex.code_column, std::string(ex.code->name));
  tapping_axis = rigid && ex.code == ex.motion_code ? static_cast<int>(*axis) : -1;
  if (rigid && !(ex.rpm > 0)) return fail(ex, rules, Fault::rigid_speed, 'S');
  if (!rigid && ex.spindle_direction == SpindleDirection::stop)
    return fail(ex, rules, Fault::rigid_program, 'S', "spindle not turning");
  if (ex.spindle_direction == SpindleDirection::ccw) hole.kind.tap = HoleTap::left;
  hole.pecks_from_retract = true;
  if (b.has('D')) hole.peck = std::fabs(ex.length_mm(b['D']));
  if (b.has('R')) hole.clearance = std::fabs(ex.length_mm(b['R']));
  if (hole.clearance == 0 || hole.peck >= std::fabs(hole.bottom - hole.reference))
    hole.peck = 0;  // in one go
  if (hole.peck > 0 && hole.clearance >= hole.peck) return fail(ex, rules, Fault::value, 'D');
  const char* cycle = ex.code->tenths == 330   ? "G33"
                      : ex.code->tenths == 930 ? "G93"
                      : name == 'X'            ? "G88"
                                               : "G84";
  start_holes(ex, cycle, {.hole = hole, .small = {}, .axis = *axis, .plane = {*axis, *axis}, .target = {}});
  return true;
}

}  // namespace headstock::cycles

#include "dialects/k2000tc/spindle_thread_cycle.hpp"

#include <bit>
#include <cmath>
#include <memory>
#include <numbers>

#include "dialects/k2000tc/language.hpp"

namespace headstock::dialects::k2000tc {
namespace {

constexpr double kTurn_deg = 360;

double nearest(double angle_deg, double to_deg) {
  return angle_deg + kTurn_deg * std::round((to_deg - angle_deg) / kTurn_deg);
}

}  // namespace

double SpindleThreadRun::radius_at(double z_mm) const {
  const double part = (z_mm - z_from) / (z_to - z_from);
  return x_to + words.taper_mm * (1 - part);
}

// A quarter circle between a radial and a longitudinal move.
void SpindleThreadRun::arc(double x_0, double z_0, double x_1, double z_1, bool onto) {
  const double radius = std::max(std::fabs(x_1 - x_0), std::fabs(z_1 - z_0));
  if (radius <= kChordTolerance_mm) return;
  const double widest = 2 * std::acos(1 - kChordTolerance_mm / radius);
  const int chords = static_cast<int>(std::ceil(std::numbers::pi / 2 / widest));
  for (int k = 1; k <= chords; ++k) {
    const double angle = std::numbers::pi / 2 * k / chords;
    // Onto the thread: radial first. Off it: radial last.
    const double radial = onto ? std::sin(angle) : 1 - std::cos(angle);
    const double along = onto ? 1 - std::cos(angle) : std::sin(angle);
    const double z_here = z_0 + (z_1 - z_0) * along;
    steps_.push_back({x_0 + (x_1 - x_0) * radial, z_here, angle_at(z_here), false});
  }
}

// The moves of one start, then the way to where the next begins.
void SpindleThreadRun::plan(double spindle_now) {
  steps_.clear();
  done_ = 0;
  const bool back = words.both_ways && words.starts > 1 && start_ % 2 == 1;
  const double begin = back ? z_to : z_from, end = back ? z_from : z_to;
  const double sense = end > begin ? 1 : -1;
  const double enter = back ? words.leave_mm : words.enter_mm, leave = back ? words.enter_mm : words.leave_mm;
  const double share = kTurn_deg * static_cast<double>(start_) / static_cast<double>(words.starts);
  start_angle_ = words.start_deg + share;
  start_angle_ += nearest(angle_at(begin), spindle_now) - angle_at(begin);

  if (at_end_ != back) steps_.push_back({x_from, begin, angle_at(begin), true});  // 6: back to the beginning
  if (steps_.empty()) steps_.push_back({x_from, begin, angle_at(begin), true});   // the spindle's next angle
  at_end_ = back;
  const double z_on = begin + sense * enter, z_off = end - sense * leave;
  const double x_on = radius_at(z_on), x_off = radius_at(z_off);
  const double outward = x_from > x_to ? 1 : -1;
  steps_.push_back({x_on + outward * enter, begin, angle_at(begin), false});  // 1
  arc(x_on + outward * enter, begin, x_on, z_on, true);                       // 2
  steps_.push_back({x_off, z_off, angle_at(z_off), false});                   // 3
  arc(x_off, z_off, x_off + outward * leave, end, false);                     // 4
  steps_.push_back({x_from, end, angle_at(end), false});                      // 5
  at_end_ = !back;
  if (++start_ < words.starts) return;
  steps_.push_back({x_from, z_from, nearest(0, angle_at(end)), true});  // 6, the spindle to zero
}

bool SpindleThreadRun::next(interp::Executor& ex) {
  if (done_ == steps_.size()) {
    if (start_ == words.starts) return false;
    plan(ex.machine_now[spindle]);
  }
  const Step& step = steps_[done_++];
  const interp::AxisVector before = ex.machine_now;
  ex.set_axis_machine(x, step.x);
  ex.set_axis_machine(z, step.z);
  ex.set_axis_machine(spindle, step.spindle);
  const std::uint32_t moved = 1u << x | 1u << z | 1u << spindle;
  if (step.rapid) {
    ex.fill_motion(ex.emit<interp::Rapid>(), moved);
    return true;
  }
  auto& motion = ex.emit<interp::Feed>();
  ex.fill_motion(motion, moved);
  // F is the speed along the linear axes; on the machine's path a degree counts as a millimetre (L1869).
  const double length = std::hypot(step.x - before[x], step.z - before[z]);
  const double turned = step.spindle - before[spindle];
  motion.feed = length > 0 ? feed * std::hypot(length, turned) / length : feed;
  motion.unit = unit;
  return true;
}

bool take_spindle_thread_words(interp::Executor& ex) {
  SpindleThreadWords& words = language(ex).thread_words;
  const program::Block& b = ex.block;
  if (b.has('R')) words.taper_mm = ex.length_mm(b['R']);
  if (b.has('Q')) words.start_deg = static_cast<double>(ex.nano(b['Q'], program::kNano / 1'000)) / 1e9;
  if (b.has_marked('B')) words.enter_mm = ex.length_mm(b.marked_at('B'));
  if (b.has_marked('E')) words.leave_mm = ex.length_mm(b.marked_at('E'));
  if (b.has_marked('P')) words.both_ways = b.marked_at('P').digits != 0;
  if (b.has('L')) {
    const std::int64_t starts = ex.whole('L', AlarmReason::value_range);
    if (starts < 0) return false;
    if (starts < 1 || starts > 99)
      return ex.alarm(AlarmReason::value_range, b['L'].column, "L" + std::to_string(starts));
    words.starts = starts;
  }
  for (const char letter : {'B', 'E'}) {
    if (b.has_marked(letter) && b.marked_at(letter).digits < 0)
      return ex.alarm(AlarmReason::value_range, b.marked_at(letter).column, std::string("N") + letter);
  }
  return true;
}

// G78.1 X(U) Z(W) R Q NB NE NP L F
bool spindle_thread_cycle(interp::Executor& ex) {
  Language& own = language(ex);
  const std::uint32_t column = ex.code_column;
  if (!own.thread.on) return own.raise(ex, "PS0287", column, "G78.1");
  if (ex.transform.active() || ex.polar.on) return own.raise(ex, "PS0288", column, "G78.1");
  if (!take_spindle_thread_words(ex)) return false;
  const auto x = ex.axis_named('X'), z = ex.axis_named('Z');
  const interp::AxisVector start = ex.machine_now;
  std::uint32_t moved = 0;
  if (!ex.take_targets(moved)) return false;
  if (moved == 0) return true;
  if (!x || !z || (moved & ~(1u << *x | 1u << *z)) != 0) return own.raise(ex, "PS0290", column, "G78.1");
  if (std::popcount(moved) != 2) return own.raise(ex, "PS0292", column, "G78.1");
  if (!(own.thread.lead_mm > 0)) return ex.alarm(AlarmReason::thread_lead, column, "NF");

  auto run = std::make_unique<SpindleThreadRun>();
  run->words = own.thread_words;
  run->x = *x;
  run->z = *z;
  run->spindle = own.thread.spindle;
  run->x_from = start[*x];
  run->z_from = start[*z];
  run->x_to = ex.to_machine(*x, ex.axes[*x].position);
  run->z_to = ex.to_machine(*z, ex.axes[*z].position);
  run->degrees_a_mm = (own.thread.reversed ? -1 : 1) * kTurn_deg / own.thread.lead_mm;
  for (const std::size_t i : {*x, *z}) ex.set_axis_machine(i, start[i]);
  const double length = std::fabs(run->z_to - run->z_from);
  if (length <= 0 || run->words.enter_mm + run->words.leave_mm > length)
    return ex.alarm(AlarmReason::value_range, column, "NB NE");
  if (!ex.cutting_feed(length, run->feed, run->unit)) return false;
  ex.cycle.name = "G78.1";
  ex.cycle.running = std::move(run);
  ex.cycle.starts_cycle = true;
  return true;
}

}  // namespace headstock::dialects::k2000tc

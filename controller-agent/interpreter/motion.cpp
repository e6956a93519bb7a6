// Axes: units, zero points, targets, straight motion.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "interpreter/executor.hpp"

namespace headstock::interp {

using program::kNano;

constexpr double kFastest_mm_min = 999'000;

std::optional<std::size_t> Executor::axis_named(char name) const {
  return machine.axis_index(name);
}

std::int64_t Executor::round_to(std::int64_t value, std::int64_t increment) const {
  if (dialect.numbers.rounding == dialects::Rounding::truncate) return value - value % increment;
  // Half goes toward +∞ (0i-D 8.3): -0.0005 → 0, 0.0005 → 0.001.
  const std::int64_t shifted = value + increment / 2;
  std::int64_t below = shifted % increment;
  if (below < 0) below += increment;
  return shifted - below;
}

void Executor::set_units(bool inch_now) {
  modal.inch = inch_now;
  unit_mm = inch_now ? 25.4 : 1;
  std::int64_t increment = kNano / 1'000;
  if (data.bit(dialect.numbers.coarse_increment_parameter)) increment = kNano / 100;
  if (data.bit(dialect.numbers.fine_increment_parameter)) increment = kNano / 10'000;
  const auto of_decimals = [this](std::string_view parameter, std::int64_t otherwise) {
    const auto set = data.parameters.find(parameter);
    if (parameter.empty() || set == data.parameters.end()) return otherwise;
    const double decimals = std::clamp(set->second, 1.0, 4.0);
    return kNano / program::kPowerOfTen[static_cast<std::size_t>(decimals)];
  };
  const std::int64_t rotary_increment = of_decimals(dialect.numbers.rotary_decimals_parameter, increment);
  increment = of_decimals(dialect.numbers.linear_decimals_parameter, increment);
  linear_increment = inch_now ? increment / 10 : increment;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    ProgramAxis& axis = axes[i];
    axis.mm_per_unit = axis.diameter * (axis.rotary ? 1 : unit_mm);
    const auto own_bit = [&](std::string_view bit) {  // one for each axis, or one for all
      return !bit.empty() && data.bit(std::string(bit) + '/' + axis.name);
    };
    axis.increment = axis.rotary ? rotary_increment : linear_increment;
    if (own_bit(dialect.numbers.coarse_increment_parameter))
      axis.increment = kNano / (inch_now && !axis.rotary ? 1000 : 100);
    if (own_bit(dialect.numbers.fine_increment_parameter))
      axis.increment = kNano / (inch_now && !axis.rotary ? 100'000 : 10'000);
    axis.word_unit = axis.increment;
    if (data.bit(dialect.modes.tenfold_unit_parameter)) axis.word_unit *= 10;
    if (own_bit(dialect.modes.axis_decimal_parameter)) axis.word_unit = kNano;
    set_axis_machine(i, machine_now[i]);
  }
}

double Executor::shown(std::size_t axis) const {
  return static_cast<double>(round_to(axes[axis].position, axes[axis].increment)) / 1e9;
}

double Executor::to_machine(std::size_t axis, std::int64_t position) const {
  const double work = static_cast<double>(round_to(position, axes[axis].increment)) / 1e9;
  return work * axes[axis].mm_per_unit + modal.work_zero[axis];
}

void Executor::set_axis_machine(std::size_t axis, double machine_position) {
  machine_now[axis] = machine_position;
  const double work = (machine_position - modal.work_zero[axis]) / axes[axis].mm_per_unit;
  // What moved the axis here was exact in least increments of this or of another unit: keep 1e-6 of them, no
  // dust.
  axes[axis].position = std::llround(work * 1e7) * 100;
  work_now[axis] = static_cast<double>(axes[axis].position) / 1e9;
  if (transform.active()) follow_transform();
}

void Executor::follow_transform() {
  AxisVector place{};
  for (std::size_t i = 0; i < axes.size(); ++i) place[i] = slide_mm(i);
  place = transform.undo(place);
  for (std::size_t i = 0; i < axes.size(); ++i)
    axes[i].position = std::llround(place[i] / axes[i].mm_per_unit * 1e7) * 100;
}

AxisVector Executor::targets_mm() const {
  AxisVector place{};
  const bool exact = transform.active();  // an axis that is only turned along must not be rounded
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::int64_t position = exact ? axes[i].position : round_to(axes[i].position, axes[i].increment);
    place[i] = static_cast<double>(position) / 1e9 * axes[i].mm_per_unit;
  }
  return exact ? transform.apply(place) : place;
}

double Executor::path_to_targets(const AxisVector& from_machine, std::uint32_t moved) const {
  const AxisVector to = targets_mm();
  moved = transform.also_moved(moved);
  double path = 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double d = (moved >> i & 1u) != 0 ? to[i] + modal.work_zero[i] - from_machine[i] : 0;
    path += d * d;
  }
  return std::sqrt(path);
}

void Executor::update_zero(std::size_t i) {
  ProgramAxis& axis = axes[i];
  axis.zero_external = page_to_slide(i, data.work_external[i] + data.work_shift[i]);
  const AxisVector& work = work_is_extra ? data.work_extra[work_index] : data.work[work_index];
  axis.zero_work = page_to_slide(i, work[i]);
  modal.work_zero[i] =
      axis.zero_external + axis.zero_work + axis.zero_shift + axis.zero_local + axis.zero_tool;
  keep_mirror_place(i);
  set_axis_machine(i, machine_now[i]);
}

void Executor::update_zeros() {
  for (std::size_t i = 0; i < axes.size(); ++i) update_zero(i);
}

// X together with U, Z together with W: which one counts is the dialect's affair.
bool Executor::settle_both_forms(std::uint32_t mask) {
  for (std::uint32_t left = mask & incremental_letters; left != 0; left &= left - 1) {
    const auto inc = static_cast<unsigned>(std::countr_zero(left));
    const unsigned abs = program::letter_index(axes[static_cast<std::size_t>(axis_of[inc])].name);
    if ((mask >> abs & 1u) == 0) continue;
    switch (dialect.both_forms) {
      case dialects::BothForms::alarm:
        return alarm(AlarmReason::absolute_and_incremental, block.word[inc].column,
                     std::string(1, static_cast<char>('A' + inc)));
      case dialects::BothForms::absolute_wins:
        block.words &= ~(1u << inc);
        break;
      case dialects::BothForms::later_wins:
        block.words &= ~(1u << (block.word[inc].column < block.word[abs].column ? inc : abs));
        break;
    }
  }
  return true;
}

namespace {

// G90 and G91 in one block: each counts for the words behind it (0i-D L29783). @return whether the word at
// `column` is incremental; `otherwise` where the block has not both.
bool incremental_at(const program::Block& block, std::uint32_t column, bool otherwise) {
  constexpr std::int16_t kAbsolute = 900, kIncremental = 910;
  const program::Code* last = nullptr;
  bool both[2] = {};
  for (std::size_t i = 0; i < block.g_count; ++i) {
    const program::Code& one = block.g[i];
    if (one.tenths != kAbsolute && one.tenths != kIncremental) continue;
    both[one.tenths == kIncremental ? 1 : 0] = true;
    if (last == nullptr || one.column < column) last = &one;
  }
  return both[0] && both[1] ? last->tenths == kIncremental : otherwise;
}

}  // namespace

bool Executor::take_targets(std::uint32_t& moved) {
  moved = pending_axes;
  std::uint32_t mask = block.words & axis_letters;
  if ((mask & incremental_letters) != 0 && (mask & absolute_letters) != 0) {
    if (!settle_both_forms(mask)) return false;
    mask = block.words & axis_letters;
  }
  if (polar.on && mask != 0 && !take_polar(mask, moved)) return false;
  const bool both_modes =
      block.g_count > 1 && table->find(910) != nullptr;  // a control without G91 has cycles there
  for (; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    const program::Word& word = block.word[letter];
    const auto index = static_cast<std::size_t>(axis_of[letter]);
    ProgramAxis& axis = axes[index];
    if (normal_direction.holds(index)) {
      return alarm(AlarmReason::normal_direction_axis, word.column,
                   std::string(1, static_cast<char>('A' + letter)));
    }
    std::int64_t value = axis_value(word, axis);
    if (dialect.numbers.rounding == dialects::Rounding::truncate) value -= value % axis.increment;
    if (transform.active())
      value = round_to(value, axis.increment);  // the position itself is not rounded then
    const std::int64_t most = dialect.numbers.most_increments * axis.increment;
    if (value > most || value < -most) {
      return alarm(AlarmReason::value_range, word.column, std::string(1, static_cast<char>('A' + letter)));
    }
    const bool written_by = both_modes ? incremental_at(block, word.column, incremental) : incremental;
    const bool by = written_by || (incremental_letters >> letter & 1u) != 0;
    if (by && increment_limit[index] > 0 &&
        std::fabs(static_cast<double>(value)) / 1e9 > increment_limit[index]) {
      return alarm(AlarmReason::increment_limit, word.column,
                   std::string(1, static_cast<char>('A' + letter)));
    }
    axis.position = by ? axis.position + value : axis.rolls_over ? rolled(axis, value) : value;
    if (axis.position > most || axis.position < -most)
      return alarm(pipeline.side() != 0 ? AlarmReason::compensated_overflow : AlarmReason::position_overflow, word.column,
                   std::string(1, static_cast<char>('A' + letter)));
    moved |= 1u << index;
  }
  return !transform.active() || transformed_in_range(moved);
}

// Scaling and rotation may lead where no word could.
bool Executor::transformed_in_range(std::uint32_t moved) {
  const AxisVector target = targets_mm();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double most = static_cast<double>(dialect.numbers.most_increments) *
                        static_cast<double>(axes[i].increment) / 1e9 * axes[i].mm_per_unit;
    if ((moved >> i & 1u) != 0 && std::fabs(target[i]) > most)
      return alarm(AlarmReason::transform_overflow, code_column, std::string(1, axes[i].name));
  }
  return true;
}

// Where an absolute command of a roll-over axis leads on the axis' endless scale.
std::int64_t Executor::rolled(const ProgramAxis& axis, std::int64_t wanted) {
  if (axis.turn <= 0) return wanted;
  const auto within = [&axis](std::int64_t value) { return ((value % axis.turn) + axis.turn) % axis.turn; };
  const std::int64_t now = within(axis.position);
  if (axis.as_written) return axis.position + wanted - now;
  if (axis.by_sign) {  // |value| is the place, its sign the direction
    const std::int64_t ahead = within((wanted < 0 ? -wanted : wanted) - now);
    return axis.position + (wanted < 0 && ahead != 0 ? ahead - axis.turn : ahead);
  }
  const std::int64_t ahead = within(wanted - now);
  return axis.position + (ahead * 2 > axis.turn ? ahead - axis.turn : ahead);
}

// What the position page shows of an axis that rolls over: 0 … less than one turn.
double Executor::within_turn(std::size_t axis, double work) const {
  if (!axes[axis].rolls_over || axes[axis].turn <= 0) return work;
  const double turn = static_cast<double>(axes[axis].turn) / 1e9;
  const double left = std::fmod(work, turn);
  const double positive = left < 0 ? left + turn : left;
  if (!axes[axis].centered) return positive;
  return positive > turn / 2 ? positive - turn : positive;
}

void Executor::fill_motion(Motion& motion, std::uint32_t moved) {
  if (transform.active()) {
    moved = transform.also_moved(moved);
    const AxisVector to = targets_mm();
    for (std::uint32_t left = moved; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      work_now[i] = to[i] / axes[i].mm_per_unit;
      machine_now[i] = to[i] + modal.work_zero[i];
    }
  } else {
    for (std::uint32_t left = moved; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      work_now[i] = shown(i);
      machine_now[i] = work_now[i] * axes[i].mm_per_unit + modal.work_zero[i];
    }
  }
  motion.at = at;
  motion.modal = modal;
  motion.end_work = work_now;
  motion.end_machine = machine_now;
  motion.axes = moved;
  motion.cycle = cycle.name;
  motion.exact_stop = exact_stop_once || exact_stop_mode;
  motion.cutting_mode = cutting_mode;
  motion.in_plane = surface.now.kind != SurfaceKind::none;
  if (any_rolls_over) {
    for (std::size_t i = 0; i < axes.size(); ++i) motion.end_work[i] = within_turn(i, work_now[i]);
  }
  if (own) own->moved(*this, motion);
}

bool Executor::emit_rapid_to_machine(const AxisVector& target, std::uint32_t moved, bool machine_coordinates,
                                     bool overlap) {
  for (std::uint32_t left = moved; left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    set_axis_machine(i, target[i]);
  }
  auto& motion = emit<Rapid>();
  motion.at = at;
  motion.modal = modal;
  motion.end_work = work_now;
  motion.end_machine = machine_now;
  for (std::size_t i = 0; any_rolls_over && i < axes.size(); ++i)
    motion.end_work[i] = within_turn(i, work_now[i]);
  motion.axes = moved;
  motion.machine_coordinates = machine_coordinates;
  motion.overlap = overlap;
  motion.exact_stop = !overlap;
  return true;
}

// More axes in a block than the control interpolates at once (PS0015).
bool Executor::axes_at_once(std::uint32_t moved) {
  const int most = dialect.modes.most_axes_at_once;
  return most == 0 || std::popcount(moved) <= most || alarm(AlarmReason::too_many_axes, code_column, {});
}

double Executor::imaginary_circle(const AxisVector& from, const AxisVector& to, std::uint32_t moved) const {
  double plain = 0, circle = 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if ((moved >> i & 1u) == 0) continue;
    const double way = to[i] - from[i];
    plain += way * way;
    if (axes[i].on_circle) {
      const double arc_mm = way * axes[i].circle_mm * std::numbers::pi / 180;
      circle += arc_mm * arc_mm;
    } else {
      circle += way * way;
    }
  }
  return circle > 0 ? std::sqrt(plain / circle) : 0;
}

bool Executor::rapid() {
  std::uint32_t moved = 0;
  if (!take_targets(moved) || !axes_at_once(moved)) return false;
  if (moved == 0) return true;
  auto& motion = emit<Rapid>();
  fill_motion(motion, moved);
  motion.linear = linear_rapid;
  return true;
}

// The feed of a cutting block; under inverse time it depends on the path.
bool Executor::cutting_feed(double path_mm, double& value, FeedUnit& unit) {
  if (feed_unit == FeedUnit::inverse_time) {  // F in every block (0i-D 5.3)
    if (!block.has('F') || feed_mm <= 0) return alarm(AlarmReason::feed_missing, code_column, "F");
    value = feed_mm * path_mm;
    unit = FeedUnit::mm_per_minute;
    return true;
  }
  if (feed_mm <= 0) return alarm(AlarmReason::feed_missing, block.has('F') ? block['F'].column : 0, "F");
  value = feed_mm;
  unit = feed_unit;
  return true;
}

bool Executor::feed() {
  const AxisVector from = machine_now;
  std::uint32_t moved = 0;
  if (!take_targets(moved)) return false;
  if (block.marked != 0 && !take_angle(moved)) return false;
  if (!axes_at_once(moved)) return false;
  if (moved == 0) return true;
  if (one_digit_rapid) {
    auto& motion = emit<Rapid>();
    fill_motion(motion, moved);
    motion.linear = true;
    return true;
  }
  if (feed_mm <= 0 || feed_unit == FeedUnit::inverse_time) {
    if (path_to_targets(from, moved) == 0) return true;  // nothing moves: F is not missed (0i-D L3845, N02)
    double value = 0;
    FeedUnit unit{};
    if (!cutting_feed(path_to_targets(from, moved), value, unit)) return false;
    auto& motion = emit<Feed>();
    fill_motion(motion, moved);
    motion.feed = value;
    motion.unit = unit;
    return true;
  }
  auto& motion = emit<Feed>();
  fill_motion(motion, moved);
  motion.feed = feed_mm;
  motion.unit = feed_unit;
  // Per minute, outside polar and cylindrical interpolation.
  if (any_on_circle && feed_unit == FeedUnit::mm_per_minute && !motion.in_plane) {
    const double factor = imaginary_circle(from, machine_now, moved);
    // Only axes that do not count: as fast as cutting may be; the axes' own limits hold.
    motion.feed = factor > 0 ? feed_mm * factor : kFastest_mm_min;
  }
  return true;
}

}  // namespace headstock::interp

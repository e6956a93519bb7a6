// What S means to the machine: clamp, gears, the axis of constant surface speed, digits allowed.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp {

// The lower of the program's clamp (G50/G92 S) and the parameter's; 0: none.
double Executor::highest_rpm() const {
  const double fixed = data.parameter(dialect.modes.highest_speed_parameter);
  if (fixed <= 0) return clamp_rpm;
  return clamp_rpm > 0 ? std::min(clamp_rpm, fixed) : fixed;
}

// M-type gear shift: the control itself chooses the lowest gear that reaches the speed (0i-D No.3741…3743).
std::uint8_t Executor::gear_of(double speed) const {
  const auto& rules = dialect.modes;
  if (rules.gear_speeds[0].empty() || data.bit(rules.gears_by_machine_parameter) || constant_surface_speed)
    return 0;
  std::uint8_t highest = 0;
  for (std::size_t i = 0; i < rules.gear_speeds.size(); ++i) {
    const double most = data.parameter(rules.gear_speeds[i]);
    if (most <= 0) break;
    highest = static_cast<std::uint8_t>(i + 1);
    if (speed <= most) return highest;
  }
  return highest;
}

// No.3030…3033: digits that M, S, T and B may have; 0: eight (S: five).
bool Executor::digits_fit(const program::Word& word, std::string_view parameter, std::string detail) {
  const double most = data.parameter(parameter);
  if (most <= 0 || most > 8) return true;
  std::int64_t value = word.digits < 0 ? -word.digits : word.digits;
  value /= program::kPowerOfTen[word.decimals];
  return value < program::kPowerOfTen[static_cast<std::size_t>(most)] ||
         alarm(AlarmReason::too_many_digits, word.column, std::move(detail));
}

// The second auxiliary function: B, or the address that a parameter names; not where an axis has that name
// (0i-D 8.3).
char Executor::second_auxiliary() const {
  const auto& rules = dialect.modes;
  if (rules.auxiliary_enable_parameter.empty() || !data.bit(rules.auxiliary_enable_parameter)) return 0;
  return auxiliary_address();
}

char Executor::auxiliary_address() const {
  const auto& rules = dialect.modes;
  const auto code_of = static_cast<int>(data.parameter(rules.auxiliary_address_parameter));
  const char letter = std::string_view("ABCUVW").find(static_cast<char>(code_of)) != std::string_view::npos
                          ? static_cast<char>(code_of)
                          : 'B';
  return (axis_letters & program::letter_bit(letter)) != 0 ? '\0' : letter;
}

bool Executor::spindle_by_p() const {
  const auto& rules = dialect.modes;
  return data.bit(rules.several_spindles_parameter) && data.bit(rules.spindle_by_p_parameter);
}

// S… P…: this machine has one spindle, so any other P means one that would stand still while this one turns (0i-D
// No.3781, PS5305).
bool Executor::spindle_fits(bool needs_p) {
  if (!spindle_by_p()) return true;
  const auto& rules = dialect.modes;
  if (!block.has('P')) {
    if (!needs_p || data.bit(rules.one_spindle_parameter)) return true;
    return alarm(AlarmReason::spindle_number, block['S'].column, "P");
  }
  const std::int64_t p = whole('P', AlarmReason::spindle_number);
  if (p < 0) return false;
  if (p != 0 && static_cast<double>(p) == data.parameter(rules.spindle_p_parameter) &&
      !data.bit(rules.one_spindle_parameter))
    return true;
  return alarm(AlarmReason::spindle_number, block['P'].column, "P" + std::to_string(p));
}

bool Executor::take_second_auxiliary(char letter) {
  const auto& rules = dialect.modes;
  const program::Word& word = block[letter];
  const std::string name(1, letter);
  double value = word.value();
  if (!data.bit(rules.auxiliary_decimal_parameter)) {  // AUP = 0
    if (word.point) return alarm(AlarmReason::decimal_point, word.column, name);
    if (word.digits < 0) return alarm(AlarmReason::minus_sign, word.column, name);
  } else if (word.point || pocket) {
    value *= dwell_units_a_second();  // 100, 1000, 10000 by increment system
    if (modal.inch && data.bit(rules.auxiliary_inch_parameter)) value *= 10;
  }
  const auto whole_value = static_cast<std::int64_t>(value + (value < 0 ? -1e-9 : 1e-9));  // cut, not rounded
  const double most = data.parameter(rules.auxiliary_digits_parameter);
  const std::int64_t limit = program::kPowerOfTen[static_cast<std::size_t>(most > 0 && most < 9 ? most : 8)];
  if (whole_value >= limit || whole_value <= -limit)
    return alarm(AlarmReason::too_many_digits, word.column, name);
  auto& sent = emit<SecondAuxiliary>();
  sent.at = at;
  sent.modal = modal;
  sent.code = whole_value;
  block.words &= ~program::letter_bit(letter);
  return true;
}

namespace handlers {

// G96 S [P]: P names the axis whose coordinate is the radius (0i-D 6.3).
bool surface_speed_on(Executor& ex) {
  if (!ex.constant_surface_speed) ex.spindle_changed = true;
  const auto& rules = ex.dialect.modes;
  if (!rules.surface_axis_parameter.empty()) {
    std::int64_t p = 0;
    std::uint32_t column = ex.code_column;
    if (ex.block.has('P') && ex.action == nullptr && ex.block.m_count == 0 && !ex.spindle_by_p()) {  // L8027
      column = ex.block['P'].column;
      p = ex.whole('P', AlarmReason::surface_axis);
      if (p < 0) return false;
    }
    if (p == 0) p = static_cast<std::int64_t>(ex.data.parameter(rules.surface_axis_parameter));
    if (p < 0 || p > static_cast<std::int64_t>(ex.axes.size()))
      return ex.alarm(AlarmReason::surface_axis, column, "P" + std::to_string(p));
    ex.surface_axis = static_cast<int>(p) - 1;  // -1: X
  }
  if (!rules.surface_letter_parameter.empty()) {
    constexpr std::string_view kLetters = "XZY";
    const auto which = static_cast<std::size_t>(std::max(0.0, ex.data.parameter(rules.surface_letter_parameter)));
    const auto named = which < kLetters.size() ? ex.axis_named(kLetters[which]) : std::nullopt;
    if (!named) return ex.alarm(AlarmReason::surface_axis, ex.code_column, std::string(rules.surface_letter_parameter));
    ex.surface_axis = which == 0 ? -1 : static_cast<int>(*named);
  }
  ex.constant_surface_speed = true;
  ex.modal.spindle_speed = ex.surface_speed / (ex.modal.inch ? 0.3048 : 1);
  return true;
}

// G97 [S]: without S the speed that the surface speed makes here becomes the spindle speed.
bool surface_speed_off(Executor& ex) {
  if (ex.constant_surface_speed) {
    ex.spindle_changed = true;
    const auto x = ex.axis_named('X');
    const int axis = ex.surface_axis >= 0 ? ex.surface_axis : x ? static_cast<int>(*x) : -1;
    if (!ex.dialect.modes.surface_axis_parameter.empty() && !ex.block.has('S') && axis >= 0 &&
        ex.surface_speed > 0) {
      const double diameter = 2 * std::fabs(ex.slide_mm(static_cast<std::size_t>(axis)));
      const double highest = ex.highest_rpm();
      ex.rpm = diameter > 0 ? ex.surface_speed * 1000 / (std::numbers::pi * diameter) : highest;
      if (highest > 0) ex.rpm = std::min(ex.rpm, highest);
    }
  }
  ex.constant_surface_speed = false;
  ex.modal.spindle_speed = ex.rpm;
  return true;
}

}  // namespace handlers
}  // namespace headstock::interp

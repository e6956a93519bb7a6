// F, S and T words.
#include <algorithm>
#include <cmath>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp {

std::int64_t Executor::whole(char letter, AlarmReason otherwise) {
  const program::Word& word = block[letter];
  if (word.digits < 0 || word.digits % program::kPowerOfTen[word.decimals] != 0) {
    alarm(otherwise, word.column, std::string(1, letter));
    return -1;
  }
  return word.integer();
}

double Executor::feed_value(const program::Word& word) const {
  const auto& numbers = dialect.numbers;
  double unit = 1;
  if (!word.point && !pocket) {
    if (feed_unit == FeedUnit::mm_per_minute) {
      unit = modal.inch ? numbers.feed_per_minute_unit_inch : numbers.feed_per_minute_unit_mm;
      if (data.bit(dialect.modes.fine_feed_per_minute_parameter)) unit = modal.inch ? 0.00001 : 0.001;
    } else if (feed_unit == FeedUnit::mm_per_revolution) {
      unit = modal.inch ? numbers.feed_per_revolution_unit_inch : numbers.feed_per_revolution_unit_mm;
      if (data.bit(dialect.modes.fine_feed_per_revolution_parameter)) unit = modal.inch ? 0.00001 : 0.001;
    } else {
      unit = 0.001;
    }
  }
  // Division by a whole number stays exact where multiplication by 0.01 would not.
  return unit < 1 ? word.value() / std::round(1 / unit) : word.value() * unit;
}

bool Executor::take_feed() {
  const program::Word& word = block['F'];
  if (action != nullptr && action->handler == handlers::contour_by_q) return true;  // its reference feed
  if (motion_code->handler == handlers::thread || motion_code->handler == handlers::thread_variable ||
      motion_code->lead || (action != nullptr && action->lead)) {
    if (!dialect.threads.f_is_feed_too) return true;  // a lead: see thread()
  }
  if (one_digit_feed) {
    one_digit_rapid = false;
    if (feed_unit == FeedUnit::mm_per_minute && !word.point && word.digits >= 0 && word.digits <= 9)
      return take_one_digit_feed(static_cast<int>(word.digits));
  }
  const double value = feed_value(word);
  modal.feed = value;
  feed_mm = feed_unit == FeedUnit::inverse_time ? value : value * unit_mm;
  return true;
}

// F1…F9: feeds of the parameters; F0: rapid (0i-D 5.3, M series).
bool Executor::take_one_digit_feed(int digit) {
  modal.feed = digit;
  if (digit == 0) {
    one_digit_rapid = true;
    return true;
  }
  const auto& rules = dialect.modes.one_digit_feed;
  const double most = data.parameter(digit <= 4 ? rules.most_1_to_4 : rules.most_5_to_9);
  feed_mm = data.parameter(std::to_string(rules.first - 1 + digit));
  if (most > 0) feed_mm = std::min(feed_mm, most);
  return true;
}

bool Executor::take_spindle() {
  if (own && own->take_spindle(*this) == OwnLanguage::Taken::done) return !finished;
  const program::Word& word = block['S'];
  const double value = word.value();
  if (!digits_fit(word, dialect.modes.spindle_digits_parameter, "S")) return false;
  const bool is_clamp = action != nullptr && action->handler == handlers::set_coordinates;
  if (!spindle_fits(!is_clamp)) return false;
  if (is_clamp) {  // G50 S, G92 S
    clamp_rpm = value;
    spindle_changed = true;
    return true;
  }
  // m/min, or feet/min under G20.
  if (constant_surface_speed) {
    if (value <= 0 && dialect.modes.surface_speed_zero_refused)
      return alarm(AlarmReason::surface_speed_zero, word.column, "S0");
    surface_speed = value * (modal.inch ? 0.3048 : 1);
  } else {
    rpm = value;
  }
  modal.spindle_speed = value;
  spindle_changed = true;
  return true;
}

void Executor::emit_spindle() {
  auto& state = emit<Spindle>();
  state.at = at;
  state.direction = spindle_direction;
  state.constant_surface_speed = constant_surface_speed;
  state.speed = constant_surface_speed ? surface_speed : rpm;
  state.clamp_rpm = highest_rpm();
  if (surface_axis >= 0) state.surface_axis = static_cast<std::uint8_t>(surface_axis);
  state.gear = gear_of(rpm);
  spindle_changed = false;
}

int Executor::offset_digits() const {
  const int digits =
      static_cast<int>(data.parameter(dialect.tools.offset_digits_parameter, dialect.tools.offset_digits));
  return digits < 1 || digits > 3 ? dialect.tools.offset_digits : digits;
}

std::int64_t Executor::offset_split() const {
  return program::kPowerOfTen[static_cast<std::size_t>(offset_digits())];
}

bool Executor::take_tool() {
  const program::Word& word = block['T'];
  std::int64_t value = whole('T', AlarmReason::offset_number);
  if (value < 0 || !digits_fit(word, dialect.modes.tool_digits_parameter, "T")) return false;
  if (!tool_life::take_t(*this, value, word.column)) return false;
  if (!dialect.tools.lathe) {
    auto& tool = emit<Tool>();
    tool.at = at;
    tool.tool = static_cast<std::int32_t>(value);
    modal.tool = tool.tool;
    return true;
  }
  const std::int64_t split = offset_split();
  const bool both = dialect.tools.short_form && word.digit_count <= offset_digits();
  const std::int64_t number = both ? value : value / split;
  const std::int64_t wear = value % split;
  const bool by_tool = data.bit(dialect.tools.geometry_by_tool_parameter);
  if (!tool_offset::take(*this, by_tool && wear != 0 ? number : wear, wear, word.column)) return false;
  modal.tool = static_cast<std::int32_t>(number);
  modal.offset = static_cast<std::int32_t>(wear);
  auto& tool = emit<Tool>();
  tool.at = at;
  tool.tool = modal.tool;
  tool.offset = modal.offset;
  if (dialect.tool_offsets.moves_first && pending_axes != 0) {
    fill_motion(emit<Rapid>(), pending_axes);
    pending_axes = 0;
  }
  return true;
}

}  // namespace headstock::interp

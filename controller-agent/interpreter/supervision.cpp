// G22/G23 stored stroke check 2, G25/G26 spindle speed supervision, G08 and G05.1 look-ahead control:
// requests that the machine's side carries out.
#include <utility>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp::handlers {
namespace {

void store(Executor& ex, const std::string& parameter, double value) {
  const double before = ex.data.parameter(parameter);
  ex.data.parameters[parameter] = value;
  if (before != value) ex.report_change("parameter/" + parameter, before, value);
}

std::string axis_parameter(std::string_view number, char axis) {
  return std::string(number) + '/' + axis;
}

}  // namespace

// G22 X Y Z I J K: X Y Z is the corner on the positive side, I J K the one on the negative side, in machine
// coordinates; both are written over the parameters (0i-D III-6.3, L32308, L32480). Without words the
// parameters hold.
bool stroke_check_on(Executor& ex) {
  const auto& rules = ex.dialect.modes;
  constexpr std::string_view kMost = "XYZ", kLeast = "IJK";
  AxisVector most{}, least{};
  std::uint32_t limited = 0;
  constexpr double kEverywhere = 1e9;
  const bool outside = ex.data.bit(rules.stroke_2_outside_parameter);
  for (std::size_t basic = 0; basic < kMost.size(); ++basic) {
    const auto axis = ex.axis_named(kMost[basic]);
    const bool plus = ex.block.has(kMost[basic]), minus = ex.block.has(kLeast[basic]);
    if (!axis) {
      if (plus || minus)
        return ex.alarm(AlarmReason::illegal_address, ex.block[plus ? kMost[basic] : kLeast[basic]].column,
                        std::string(1, plus ? kMost[basic] : kLeast[basic]));
      continue;
    }
    const ProgramAxis& a = ex.axes[*axis];
    const auto page = [&](const program::Word& word) {
      return static_cast<double>(ex.round_to(ex.nano(word, a.increment), a.increment)) / 1e9 *
             (a.rotary ? 1 : ex.unit_mm);
    };
    const std::string above = axis_parameter(rules.stroke_2_most, a.name);
    const std::string below = axis_parameter(rules.stroke_2_least, a.name);
    if (plus) store(ex, above, page(ex.block[kMost[basic]]));
    if (minus) store(ex, below, page(ex.block[kLeast[basic]]));
    if (!ex.data.parameters.contains(above) && !ex.data.parameters.contains(below)) continue;
    double& high = most[*axis] = ex.page_to_slide(*axis, ex.data.parameter(above));
    double& low = least[*axis] = ex.page_to_slide(*axis, ex.data.parameter(below));
    if (high < low) std::swap(high, low);  // any two opposite corners make the box
    if (high == low && !outside) {         // two equal points forbid the whole range
      high = kEverywhere;
      low = -kEverywhere;
    }
    limited |= 1u << *axis;
  }
  auto& check = ex.emit<StrokeCheck>();
  check.at = ex.at;
  check.on = true;
  check.outside_forbidden = outside;
  check.axes = limited;
  check.most = most;
  check.least = least;
  return true;
}

bool stroke_check_off(Executor& ex) {
  ex.emit<StrokeCheck>().at = ex.at;
  return true;
}

// G26 P ms Q % R % I min⁻¹: words rewrite the parameters, words left out are the parameters (0i-D 6.5).
bool spindle_watch_on(Executor& ex) {
  const auto& rules = ex.dialect.modes;
  struct Word {
    char letter;
    std::string_view parameter;
    double otherwise;
  };
  const Word words[] = {{'P', rules.watch_delay_parameter, 0},
                        {'Q', rules.watch_reached_parameter, 15},
                        {'R', rules.watch_ratio_parameter, 10},
                        {'I', rules.watch_width_parameter, 0}};
  double values[4] = {};
  for (std::size_t i = 0; i < 4; ++i) {
    if (ex.block.has(words[i].letter)) {
      const program::Word& word = ex.block[words[i].letter];
      const double value = word.value();
      if (value < 0) return ex.alarm(AlarmReason::minus_sign, word.column, std::string(1, words[i].letter));
      if (value > (i == 1 || i == 2 ? 1'000 : 99'999))
        return ex.alarm(AlarmReason::value_range, word.column, std::string(1, words[i].letter));
      store(ex, std::string(words[i].parameter), value);
    }
    values[i] = ex.data.parameter(words[i].parameter, words[i].otherwise);
  }
  const double percent = ex.data.bit(rules.watch_fine_parameter) ? 1000 : 100;
  auto& watch = ex.emit<SpindleWatch>();
  watch.at = ex.at;
  watch.on = true;
  watch.delay_s = values[0] / 1000;
  watch.reached_ratio = values[1] / percent;
  watch.ratio = values[2] / percent;
  watch.width_rpm = values[3];
  return true;
}

bool spindle_watch_off(Executor& ex) {
  ex.emit<SpindleWatch>().at = ex.at;
  return true;
}

namespace {

bool contour(Executor& ex, char letter, AlarmReason wrong) {
  const program::Block& b = ex.block;
  if (!b.has(letter)) return ex.alarm(wrong, ex.code_column, std::string(1, letter));
  const std::int64_t value = ex.whole(letter, wrong);
  if (value < 0) return false;
  if (value > 1) return ex.alarm(wrong, b[letter].column, letter + std::to_string(value));
  // Alone in its block, with R and F only (0i-D 5.7).
  const std::uint32_t other =
      b.words & ~(program::letter_bit(letter) | program::letters("RF")) & ex.axis_letters;
  if (other != 0 || b.m_count != 0)
    return ex.alarm(AlarmReason::stand_alone, ex.code_column, std::string(ex.code->name));
  std::int64_t level = 0;
  if (b.has('R')) {
    level = ex.whole('R', wrong);
    if (level < 0) return false;
    if (level < 1 || level > 10) return ex.alarm(wrong, b['R'].column, "R" + std::to_string(level));
  }
  auto& mode = ex.emit<ContourMode>();
  mode.at = ex.at;
  mode.on = value == 1;
  mode.level = static_cast<std::int32_t>(level);
  if (b.has('F')) mode.reference_feed = ex.feed_value(b['F']) * ex.unit_mm;
  return true;
}

}  // namespace

// G05.1 Q1/Q0.
bool contour_by_q(Executor& ex) {
  return contour(ex, 'Q', AlarmReason::illegal_g);
}

// G08 P1/P0.
bool contour_by_p(Executor& ex) {
  return contour(ex, 'P', AlarmReason::look_ahead_format);
}

namespace {

bool polygon_alone(Executor& ex) {
  const std::uint32_t other = ex.block.words & ~program::letters("PQR");
  if (other == 0 && ex.block.g_count == 1 && ex.block.m_count == 0) return true;
  return ex.alarm(AlarmReason::polygon_alone, ex.code_column, std::string(ex.code->name));
}

}  // namespace

// G51.2 P Q: tool axis and spindle turn in the ratio Q : P (0i-D d1 4.12).
bool polygon_on(Executor& ex) {
  if (!polygon_alone(ex)) return false;
  if (ex.polygon) return ex.alarm(AlarmReason::polygon_again, ex.code_column, std::string(ex.code->name));
  if (ex.data.parameter(ex.dialect.modes.polygon_axis_parameter) <= 0)
    return ex.alarm(AlarmReason::polygon_axis, ex.code_column,
                    "No." + std::string(ex.dialect.modes.polygon_axis_parameter));
  constexpr std::int64_t kMost = 999;
  std::int64_t ratio[2] = {};
  for (std::size_t i = 0; i < 2; ++i) {
    const char letter = "PQ"[i];
    if (!ex.block.has(letter))
      return ex.alarm(AlarmReason::polygon_words, ex.code_column, std::string(1, letter));
    const program::Word& word = ex.block[letter];
    ratio[i] = word.integer();
    const std::int64_t size = ratio[i] < 0 ? -ratio[i] : ratio[i];
    if (size < 1 || size > kMost || (letter == 'P' && ratio[i] < 0))
      return ex.alarm(AlarmReason::polygon_words, word.column, std::string(1, letter));
  }
  ex.polygon = true;
  auto& mode = ex.emit<PolygonTurning>();
  mode.at = ex.at;
  mode.on = true;
  mode.spindle_ratio = static_cast<std::int32_t>(ratio[0]);
  mode.tool_ratio = static_cast<std::int32_t>(ratio[1]);
  return true;
}

bool polygon_off(Executor& ex) {
  if (!polygon_alone(ex)) return false;
  ex.polygon = false;
  ex.emit<PolygonTurning>().at = ex.at;
  return true;
}

// G05.4 Q1/Q0: current loop of the maker's amplifier; nothing that Headstock's drives have. Accepted when
// well formed.
bool servo_mode(Executor& ex) {
  if (!ex.block.has('Q')) return ex.alarm(AlarmReason::illegal_g, ex.code_column, std::string(ex.code->name));
  const std::int64_t q = ex.whole('Q', AlarmReason::illegal_g);
  return q >= 0 &&
         (q <= 1 || ex.alarm(AlarmReason::illegal_g, ex.block['Q'].column, "Q" + std::to_string(q)));
}

// G91.1 IP: the largest increment an axis may be given; 0 lifts the limit.
bool increment_limit(Executor& ex) {
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    const ProgramAxis& axis = ex.axes[i];
    if (!ex.block.has(axis.name)) continue;
    const program::Word& word = ex.block[axis.name];
    if (word.digits < 0) return ex.alarm(AlarmReason::minus_sign, word.column, std::string(1, axis.name));
    ex.increment_limit[i] =
        static_cast<double>(ex.round_to(ex.nano(word, axis.increment), axis.increment)) / 1e9;
  }
  return true;
}

}  // namespace headstock::interp::handlers

// A 200T block as text: label, comments, port M codes; what is left goes to the common lexer.
#include "dialects/lathe-200t/language.hpp"
#include "program/characters.hpp"

namespace headstock::dialects::lathe_200t {
namespace {

using program::is_digit;
using program::upper;

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

// M codes that mean something (mcodes.tsv); everything else is a mistake in the program.
constexpr struct {
  std::int32_t first, last;
} kKnown[] = {{0, 5}, {8, 11}, {20, 35}, {96, 96}, {98, 99}, {120, 135}, {220, 235}, {901, 901}};

bool is_known(std::int64_t code) {
  for (const auto& range : kKnown) {
    if (code >= range.first && code <= range.last) return true;
  }
  return false;
}

// Port XX of an output code XX, 1XX, 2XX; false when there is no such port.
bool is_port_code(std::int64_t code) {
  const std::int64_t port = code % 100;
  return code >= 0 && code < 300 && port >= 20 && port <= 35;
}

std::string_view word_at(std::string_view text, std::size_t at) {
  std::size_t end = at;
  while (end < text.size() && !is_blank(text[end])) ++end;
  return text.substr(at, end - at);
}

// `(…)` becomes blanks, `;` ends the block (2.2: comments are only for the reader).
void blank_comments(std::string& text) {
  bool inside = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '(') inside = true;
    if (!inside && text[i] == ';') {
      text.resize(i);
      return;
    }
    const bool closes = text[i] == ')';
    if (inside || closes) text[i] = ' ';
    if (closes) inside = false;
  }
}

// The code number of a `Gnnn` word at `at`, -1 when it is none; `at` goes behind it.
std::int64_t code_at(std::string_view text, std::size_t& at) {
  if (at >= text.size() || upper(text[at]) != 'G') return -1;
  std::size_t i = at + 1;
  std::int64_t number = -1;
  for (; i < text.size() && is_digit(text[i]) && number < 100'000; ++i)
    number = (number < 0 ? 0 : number * 10) + (text[i] - '0');
  if (i < text.size() && text[i] == '.') return -1;
  at = i;
  return number;
}

// #1…#99 and ##…: input ports may be among them.
bool looks_at_inputs(const Frame& frame) {
  const char* end = frame.line.text.data() + frame.line.text.size();
  for (const char* at = frame.rest; at + 1 < end; ++at) {
    if (*at != '#') continue;
    int digits = 0;
    while (at + 1 + digits < end && is_digit(at[1 + digits])) ++digits;
    if (digits != 3) return true;
  }
  return false;
}

// G10 G59 G60 write the offset page: only once everything before is done, so that a RESET never leaves an offset
// changed by a block that did not run.
bool writes_offsets(const Frame& frame) {
  const char* end = frame.line.text.data() + frame.line.text.size();
  for (const char* at = frame.rest; at < end; ++at) {
    if (upper(*at) != 'G') continue;
    std::size_t behind = 0;
    const std::int64_t code = code_at({at, static_cast<std::size_t>(end - at)}, behind);
    if (code == 10 || code == 59 || code == 60) return true;
  }
  return false;
}

}  // namespace

Language& language(Executor& ex) {
  return static_cast<Language&>(*ex.own);
}

Language::Level& Language::level(Executor& ex) {
  while (levels_.size() < ex.frames.size()) levels_.emplace_back();
  return levels_[ex.frames.size() - 1];
}

void Language::power_on(Executor& ex) {
  for (std::uint32_t n = kLastRetained + 1; n <= kLastUser; ++n) ex.data.common_variables.erase(n);
  reference_shift.assign(ex.axes.size(), 0);
  start_points.assign(ex.axes.size(), {});
}

void Language::start(Executor& ex) {
  ex.lex_rules.expressions = &variables;
  ex.axis_like &= ~program::letter_bit('H');  // a component's number, no axis
  loops_.clear();
  levels_.clear();
  // No. AX2.7: X by radius (L8160).
  const auto given = ex.data.parameters.find("AX2.7");
  const auto x = ex.axis_named('X');
  if (x && given != ex.data.parameters.end()) {
    ex.axes[*x].diameter = given->second != 0 ? 1 : 0.5;
    ex.set_units(false);
  }
}

void Language::reset(Executor&) {
  loops_.clear();
  levels_.clear();
}

bool Language::take_label(Executor& ex, Frame& frame, std::string& text, std::size_t& at) {
  while (at < text.size() && is_blank(text[at])) ++at;
  std::int64_t key = -1;
  if (at < text.size() && upper(text[at]) == 'N') {
    std::string_view label = word_at(text, at).substr(1);
    if (ex.switches.lenient) {  // N10G00: what editors of other controls write
      std::size_t digits = 0;
      while (digits < label.size() && is_digit(label[digits])) ++digits;
      label = label.substr(0, digits);
    }
    key = label_key(label);
    if (key < 0 && frame.wanted_sequence < 0)
      return ex.alarm(AlarmReason::program_number, static_cast<std::uint32_t>(at) + 1,
                      "N" + std::string(label));
    std::uint32_t number = 0;
    for (const char c : label) number = number * 10 + static_cast<std::uint32_t>(c - '0') % 10;
    if (frame.wanted_sequence < 0 || key == frame.wanted_sequence) ex.at.sequence = number;
    for (std::size_t i = 0; i <= label.size(); ++i) text[at++] = ' ';
  }
  if (frame.wanted_sequence >= 0 && key == frame.wanted_sequence) {
    frame.wanted_sequence = -1;
    frame.wanted_name.clear();
  }
  level(ex).last_label = key;
  return true;
}

// M26.150, M1026.150, M-2127.200, M2127.-200 (L4650).
bool Language::port_code(Executor& ex, std::string_view word, std::uint32_t column) {
  const auto refuse = [&] { return ex.alarm(AlarmReason::illegal_m, column, std::string(word)); };
  std::size_t i = 1;
  bool minus = i < word.size() && word[i] == '-';
  if (minus) ++i;
  std::int64_t code = 0;
  for (; i < word.size() && is_digit(word[i]) && code < 100'000; ++i) code = code * 10 + (word[i] - '0');
  bool given = i < word.size() && word[i] == '.';
  if (given) ++i;
  if (given && i < word.size() && word[i] == '-') {
    if (minus) return refuse();
    minus = true;
    ++i;
  }
  std::int64_t value = 0;
  const std::size_t from = i;
  for (; i < word.size() && is_digit(word[i]) && value < 1'000'000; ++i) value = value * 10 + (word[i] - '0');
  if (i != word.size() || !given || from == i) return refuse();

  interp::MCode sent;
  if (code >= 1'000) {
    static constexpr char kAxis[] = {'X', 'Y', 'Z'};
    const std::int64_t which = code / 1'000;
    if (which > 3) return refuse();
    const auto axis = ex.axis_named(kAxis[which - 1]);
    if (!axis) return refuse();
    sent.at_axis = static_cast<std::int8_t>(*axis);
    sent.at_position = static_cast<double>(minus ? -value : value);
    code %= 1'000;
  } else {
    if (minus) return refuse();
    sent.delay_s = static_cast<double>(value) / 100;  // in 10 ms
  }
  if (!is_port_code(code)) return refuse();
  sent.code = static_cast<std::int32_t>(code);
  sent.at = ex.at;
  sent.modal = ex.modal;
  ex.emit<interp::MCode>() = sent;
  return true;
}

// Takes out what the common lexer does not know: M codes with values, the name behind M98.
bool Language::take_m_codes(Executor& ex, std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (upper(text[i]) != 'M' || i + 1 == text.size()) continue;
    const auto column = static_cast<std::uint32_t>(i) + 1;
    std::size_t end = i + 1;
    while (end < text.size() && (is_digit(text[end]) || text[end] == '.' || text[end] == '-')) ++end;
    const std::string_view word = std::string_view(text).substr(i, end - i);
    if (word.size() == 1) continue;
    const bool has_value = word.find_first_of(".-") != word.npos;
    std::int64_t code = 0;
    for (std::size_t d = 1; !has_value && d < word.size() && code < 100'000; ++d)
      code = code * 10 + (word[d] - '0');
    if (has_value) {
      if (!port_code(ex, word, column)) return false;
      for (; i < end; ++i) text[i] = ' ';
      --i;
      continue;
    }
    if (!is_known(code)) return ex.alarm(AlarmReason::illegal_m, column, std::string(word));
    if (code == 99) {  // what stands behind it is not read (L4615)
      for (i = end; i < text.size(); ++i) text[i] = ' ';
      return true;
    }
    if (code != 98) continue;
    std::size_t at = end;
    while (at < text.size() && is_blank(text[at])) ++at;
    if (at == text.size() || upper(text[at]) != 'N')
      return ex.alarm(AlarmReason::call_without_p, column, "M98");
    const std::string_view named = word_at(text, at);
    call_column_ = static_cast<std::uint32_t>(at) + 1;
    call_name_ = named.substr(1);
    if (call_name_.empty() || call_name_.size() > 4)
      return ex.alarm(AlarmReason::program_not_found, call_column_, call_name_);
    for (std::size_t k = 0; k < named.size(); ++k) text[at + k] = ' ';
    i = at;
  }
  return true;
}

interp::OwnLanguage::Taken Language::take_text(Executor& ex, Frame& frame) {
  if (ex.environment->takes_time() && !ex.at_standstill && frame.wanted_sequence < 0 &&
      (looks_at_inputs(frame) || writes_offsets(frame))) {  // read when they are true
    ex.hold_look_ahead();
    return Taken::done;
  }
  Level& here = level(ex);
  here.text.assign(frame.rest,
                   static_cast<std::size_t>(frame.line.text.data() + frame.line.text.size() - frame.rest));
  std::string& text = here.text;
  blank_comments(text);
  frame.line.text = text;
  frame.rest = text.data();

  std::size_t at = 0;
  if (!take_label(ex, frame, text, at)) return Taken::done;
  if (frame.wanted_sequence >= 0) {  // searching
    frame.rest = nullptr;
    return Taken::done;
  }
  while (at < text.size() && is_blank(text[at])) ++at;
  if (at < text.size() && text[at] == '/') {
    ex.alarm(AlarmReason::slash_position, static_cast<std::uint32_t>(at) + 1, "/");
    return Taken::done;
  }
  std::size_t behind = at;
  switch (code_at(text, behind)) {
    case 65:
      frame.rest = nullptr;
      frame.at_start = false;
      macro(ex, text, text.data() + behind);
      return Taken::done;
    case 170:
    case 171:
      frame.rest = nullptr;
      frame.at_start = false;
      loop(ex, frame, text.data() + behind, text[behind - 1] == '1');
      return Taken::done;
    default:
      break;
  }
  call_name_.clear();
  if (!take_m_codes(ex, text)) return Taken::done;
  return Taken::plain;
}

// S1…S4 switch the gear outputs 28…31, which is what M128…M131 do; above they are revolutions (L4501, L4310).
interp::OwnLanguage::Taken Language::take_spindle(Executor& ex) {
  const double value = ex.block['S'].value();
  if (ex.action != nullptr && ex.action->handler == set_start) {  // G50 S: the clamp
    ex.clamp_rpm = value;
    ex.spindle_changed = true;
    return Taken::done;
  }
  if (ex.constant_surface_speed || ex.action != nullptr || value < 1 || value > 4) return Taken::plain;
  if (value != static_cast<int>(value)) {
    ex.alarm(AlarmReason::value_range, ex.block['S'].column, "S");
    return Taken::done;
  }
  auto& sent = ex.emit<interp::MCode>();
  sent.at = ex.at;
  sent.modal = ex.modal;
  sent.code = 127 + static_cast<std::int32_t>(value);
  return Taken::done;
}

bool Language::m_code(Executor& ex, const program::Code& code) {
  if (code.tenths == 980) {
    std::int64_t times = 1;
    if (ex.block.has('P')) {
      times = ex.whole('P', AlarmReason::call_count);
      if (times < 0) return false;
    }
    return call_name(ex, call_name_, times, call_column_);
  }
  if (code.tenths == 9'010) {  // M901 clears the part count (L4689)
    auto& cleared = ex.emit<interp::MCode>();
    cleared.at = ex.at;
    cleared.modal = ex.modal;
    cleared.code = 901;
    cleared.after_motion = cleared.clears_parts = true;
    return true;
  }
  // M01 Lx: stays here until the input is active (L4385).
  if (!ex.block.has('L')) return ex.alarm(AlarmReason::no_data, code.column, "M01 L");
  const std::int64_t port = ex.whole('L', AlarmReason::value_range);
  if (port < 0) return false;
  if (!is_input(port))
    return ex.alarm(AlarmReason::value_range, ex.block['L'].column, "L" + std::to_string(port));
  auto& sent = ex.emit<interp::MCode>();
  sent.at = ex.at;
  sent.modal = ex.modal;
  sent.code = 1;
  sent.after_motion = true;
  sent.input = static_cast<std::int16_t>(port);
  return true;
}

}  // namespace headstock::dialects::lathe_200t

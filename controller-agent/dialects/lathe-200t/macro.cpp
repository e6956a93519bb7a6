// #-variables, G65 H codes and the user instructions G160…G169 (L8996-L9411).
#include <cmath>
#include <string>

#include "dialects/lathe-200t/language.hpp"
#include "program/characters.hpp"

namespace headstock::dialects::lathe_200t {
namespace {

using program::is_digit;

// The inputs that exist: 36 ports and 27 functions, 63 in all (L9602-L9645).
constexpr struct { std::int64_t first, last; } kInputs[] = {{1, 16}, {20, 24}, {31, 38}, {41, 47}, {51, 77}};

// One operand of G65 as text.
struct Operand {
  std::string_view text;
  std::uint32_t column = 0;
};

bool number_of(std::string_view text, double& value) {
  if (text.empty()) return false;
  std::size_t i = text[0] == '-' || text[0] == '+' ? 1 : 0;
  bool digits = false, point = false;
  double whole = 0, scale = 1;
  for (; i < text.size(); ++i) {
    if (is_digit(text[i])) {
      whole = whole * 10 + (text[i] - '0');
      if (point) scale *= 10;
      digits = true;
    } else if (text[i] == '.' && !point) {
      point = true;
    } else {
      return false;
    }
  }
  value = whole / scale * (text[0] == '-' ? -1 : 1);
  return digits && whole < 1e15;
}

enum class Kind : std::uint8_t { assign, jump };
struct Function {
  int h;
  Kind kind;
  int operands;  // Q, or Q and R
};
constexpr Function kFunctions[] = {
    {1, Kind::assign, 1},  {2, Kind::assign, 2}, {3, Kind::assign, 2},  {4, Kind::assign, 2},
    {5, Kind::assign, 2},  {6, Kind::assign, 2}, {11, Kind::assign, 2}, {12, Kind::assign, 2},
    {13, Kind::assign, 2}, {80, Kind::jump, 0},  {81, Kind::jump, 2},   {82, Kind::jump, 2},
    {83, Kind::jump, 2},   {84, Kind::jump, 2},  {85, Kind::jump, 2},   {86, Kind::jump, 2}};

const Function* function(std::int64_t h) {
  for (const Function& f : kFunctions) {
    if (f.h == h) return &f;
  }
  return nullptr;
}

double calculate(int h, double q, double r) {
  switch (h) {
    case 1:
      return q;
    case 2:
      return q + r;
    case 3:
      return q - r;
    case 4:
      return q * r;
    case 5:
      return q / r;
    case 6:
      return std::trunc(q / r);
    case 11:  // logic is about the whole number, not its bits (L9200)
      return q != 0 || r != 0 ? 1 : 0;
    case 12:
      return q != 0 && r != 0 ? 1 : 0;
    default:
      return (q != 0) != (r != 0) ? 1 : 0;
  }
}

bool holds(int h, double q, double r) {
  // Sums of decimals must not miss a label by the last bit: the control counts in thousandths at best.
  const bool equal = std::fabs(q - r) < 1e-6;
  switch (h) {
    case 80:
      return true;
    case 81:
      return equal;
    case 82:
      return !equal;
    case 83:
      return q > r && !equal;
    case 84:
      return q < r && !equal;
    case 85:
      return q > r || equal;
    default:
      return q < r || equal;
  }
}

}  // namespace

bool is_input(std::int64_t port) {
  for (const auto& range : kInputs) {
    if (port >= range.first && port <= range.last) return true;
  }
  return false;
}

bool Variables::get(std::int64_t number, double& value) const {
  if (number >= kFirstUser && number <= kLastUser) {
    const auto found = ex_.data.common_variables.find(static_cast<std::uint32_t>(number));
    value = found == ex_.data.common_variables.end() ? 0 : found->second;
    return true;
  }
  if (!is_input(number)) return false;
  if (!ex_.environment->has_signals()) return false;  // a port nobody connected must not be read as 0
  if (ex_.environment->takes_time()) ex_.jumps = ex_.idle_jumps = 0;  // a loop that waits for it is not endless
  value = ex_.environment->input(static_cast<unsigned>(number)) ? 1 : 0;
  return true;
}

bool Variables::set(std::int64_t number, double value) {
  if (number < kFirstUser || number > kLastUser) return false;
  double& cell = ex_.data.common_variables[static_cast<std::uint32_t>(number)];
  const double before = cell;
  cell = value;
  ex_.idle_jumps = 0;  // the program goes on
  if (before != value) ex_.report_change("variable/" + std::to_string(number), before, value);
  return true;
}

std::int64_t Variables::number_at(const char*& at, const char* end) const {
  int levels = 0;
  while (at < end && *at == '#') {
    ++at;
    ++levels;
  }
  if (levels == 0 || at == end || !is_digit(*at)) return -1;
  std::int64_t number = 0;
  for (; at < end && is_digit(*at); ++at) {
    if (number < 1'000'000) number = number * 10 + (*at - '0');
  }
  for (; levels > 1; --levels) {  // ##200: the number stands in #200
    double value = 0;
    if (!get(number, value) || value != std::floor(value) || std::fabs(value) > 1e6) return -1;
    number = static_cast<std::int64_t>(value);
  }
  return number;
}

program::LexError Variables::read(const char*& at, const char* end, double& value, bool& is_null) {
  is_null = false;
  bool minus = false;
  if (at < end && *at == '-') {
    minus = true;
    ++at;
  }
  const std::int64_t number = number_at(at, end);
  if (number < 0 || !get(number, value)) return program::LexError::expression;
  if (minus) value = -value;
  return program::LexError::none;
}

bool Language::macro(Executor& ex, std::string_view line, const char* at) {
  const char* const end = line.data() + line.size();
  const auto column = [&](const char* p) { return static_cast<std::uint32_t>(p - line.data()) + 1; };
  Operand h, p, q, r;
  while (at < end) {
    if (*at == ' ' || *at == '\t') {
      ++at;
      continue;
    }
    const char letter = static_cast<char>(*at & ~0x20);
    Operand* into = letter == 'H'   ? &h
                    : letter == 'P' ? &p
                    : letter == 'Q' ? &q
                    : letter == 'R' ? &r
                                    : nullptr;
    if (into == nullptr || into->column != 0)
      return ex.alarm(AlarmReason::illegal_address, column(at), std::string(1, *at));
    into->column = column(at++);
    const char* from = at;
    while (at < end && *at != ' ' && *at != '\t') ++at;  // a label ends at a space, nowhere else (L9227)
    into->text = {from, static_cast<std::size_t>(at - from)};
  }
  double code = 0;
  const Function* what = number_of(h.text, code) ? function(static_cast<std::int64_t>(code)) : nullptr;
  if (what == nullptr || code != std::floor(code))
    return ex.alarm(AlarmReason::data_value, h.column, "G65 H" + std::string(h.text));

  const auto value_of = [&](const Operand& operand, char name, double& value) {
    if (operand.column == 0) return ex.alarm(AlarmReason::no_data, 0, std::string("G65 ") + name);
    const char* from = operand.text.data();
    const char* to = from + operand.text.size();
    if (operand.text.find('#') == operand.text.npos) {
      if (number_of(operand.text, value)) return true;
    } else {
      bool null = false;
      if (variables.read(from, to, value, null) == program::LexError::none && from == to) return true;
    }
    return ex.alarm(AlarmReason::expression, operand.column,
                    std::string(1, name) + std::string(operand.text));
  };
  double left = 0, right = 0;
  if (what->operands >= 1 && !value_of(q, 'Q', left)) return false;
  if (what->operands >= 2 && !value_of(r, 'R', right)) return false;
  if (p.text.empty()) return ex.alarm(AlarmReason::no_data, p.column, "G65 P");

  if (what->kind == Kind::jump) return !holds(what->h, left, right) || jump(ex, p.text, p.column);

  if ((what->h == 5 || what->h == 6) && right == 0) return ex.alarm(AlarmReason::expression, r.column, "R0");
  const char* from = p.text.data();
  const char* to = from + p.text.size();
  const std::int64_t number = variables.number_at(from, to);
  if (number < 0 || from != to || !variables.set(number, calculate(what->h, left, right)))
    return ex.alarm(AlarmReason::expression, p.column, "P" + std::string(p.text));
  return true;
}

// G160…G169 U W L F D: #200…#204, then the program M-00…M-09 (L9391). What is not given is 0.
bool user_macro(Executor& ex) {
  Language& own = language(ex);
  constexpr char kArguments[] = {'U', 'W', 'L', 'F', 'D'};
  std::int64_t variable = kFirstUser;
  for (const char letter : kArguments) {
    own.variables.set(variable++, ex.block.has(letter) ? ex.block[letter].value() : 0);
    ex.block.words &= ~program::letter_bit(letter);  // arguments, neither moves nor a feed
  }
  const char name[] = {'M', '-', '0', static_cast<char>('0' + ex.code->tenths / 10 % 10)};
  return own.call_name(ex, {name, sizeof name}, 1, ex.code_column);
}

}  // namespace headstock::dialects::lathe_200t

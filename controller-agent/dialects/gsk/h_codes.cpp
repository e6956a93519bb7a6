#include "dialects/gsk/h_codes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "interpreter/executor.hpp"

namespace headstock::dialects::gsk {
namespace {

using interp::Executor;
using macro::Result;
using R = AlarmReason;

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kMostBits = 4'294'967'295.0;

// What Q and R may be: any number, or whole numbers for the operations on bits and digits.
enum class Takes : std::uint8_t { any, bits };
enum class Kind : std::uint8_t { assign, go, go_if, alarm };

struct HCode {
  std::int64_t number;
  Kind kind;
  Takes takes;
  bool only_2000tc;
  /// assign: the result; go_if: not 0 when the condition holds. Not a number: Q or R is wrong.
  double (*value)(double target, double q, double r);
};

std::uint32_t bits(double value) {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
}

// Digits of the decimal number read as hexadecimal ones, and back (H24, H25).
double to_binary(double q) {
  double value = 0, place = 1;
  for (std::uint32_t left = bits(q); left != 0; left >>= 4, place *= 10) {
    if ((left & 15u) > 9) return macro::kNull;
    value += place * (left & 15u);
  }
  return value;
}
double to_digits(double q) {
  if (q < 0 || q > 99'999'999) return macro::kNull;
  std::uint32_t value = 0, shift = 0;
  for (auto left = static_cast<std::uint32_t>(q); left != 0; left /= 10, shift += 4) value |= left % 10 << shift;
  return value;
}

constexpr HCode kCodes[] = {
    {1, Kind::assign, Takes::any, false, [](double, double q, double) { return q; }},
    {2, Kind::assign, Takes::any, false, [](double, double q, double r) { return q + r; }},
    {3, Kind::assign, Takes::any, false, [](double, double q, double r) { return q - r; }},
    {4, Kind::assign, Takes::any, false, [](double, double q, double r) { return q * r; }},
    {5, Kind::assign, Takes::any, false, [](double, double q, double r) { return q / r; }},
    {11, Kind::assign, Takes::bits, false, [](double, double q, double r) -> double { return bits(q) | bits(r); }},
    {12, Kind::assign, Takes::bits, false, [](double, double q, double r) -> double { return bits(q) & bits(r); }},
    {13, Kind::assign, Takes::bits, false, [](double, double q, double r) -> double { return bits(q) ^ bits(r); }},
    {21, Kind::assign, Takes::any, true, [](double, double q, double) { return q < 0 ? macro::kNull : std::sqrt(q); }},
    {22, Kind::assign, Takes::any, false, [](double, double q, double) { return std::fabs(q); }},
    {23, Kind::assign, Takes::any, false, [](double, double q, double r) { return q - std::trunc(q / r) * r; }},
    {24, Kind::assign, Takes::bits, false, [](double, double q, double) { return to_binary(q); }},
    {25, Kind::assign, Takes::bits, false, [](double, double q, double) { return to_digits(q); }},
    {26, Kind::assign, Takes::any, true, [](double target, double q, double r) { return target * q / r; }},
    {27, Kind::assign, Takes::any, true, [](double, double q, double r) { return std::hypot(q, r); }},
    {31, Kind::assign, Takes::any, true, [](double, double q, double r) { return q * std::sin(r * kRadians); }},
    {32, Kind::assign, Takes::any, true, [](double, double q, double r) { return q * std::cos(r * kRadians); }},
    {33, Kind::assign, Takes::any, true, [](double, double q, double r) { return q * std::tan(r * kRadians); }},
    {34, Kind::assign, Takes::any, true, [](double, double q, double r) { return std::atan2(q, r) / kRadians; }},
    {80, Kind::go, Takes::any, false, nullptr},
    {81, Kind::go_if, Takes::any, false, [](double, double q, double r) -> double { return q == r; }},
    {82, Kind::go_if, Takes::any, false, [](double, double q, double r) -> double { return q != r; }},
    {83, Kind::go_if, Takes::any, false, [](double, double q, double r) -> double { return q > r; }},
    {84, Kind::go_if, Takes::any, false, [](double, double q, double r) -> double { return q < r; }},
    {85, Kind::go_if, Takes::any, false, [](double, double q, double r) -> double { return q >= r; }},
    {86, Kind::go_if, Takes::any, false, [](double, double q, double r) -> double { return q <= r; }},
    {99, Kind::alarm, Takes::any, false, nullptr},
};
// Operations that divide by R, and by it only.
constexpr std::int64_t kDividing[] = {5, 23, 26};

const program::ComputedWord* computed_word(const Executor& ex, char letter, std::size_t& place) {
  for (place = 0; place < ex.block.computed_count; ++place)
    if (ex.block.computed[place].letter == letter) return &ex.block.computed[place];
  return nullptr;
}

// Q, R or P as a value; a word that is missing, or a variable without a value, is 0.
double operand(const Executor& ex, char letter) {
  std::size_t place = 0;
  if (computed_word(ex, letter, place) != nullptr) return macro::or_zero(ex.macros->computed[place]);
  return ex.block.has(letter) ? ex.block[letter].value() : 0;
}

std::uint32_t column_of(const Executor& ex, char letter) {
  return ex.block.has(letter) ? ex.block[letter].column : ex.code_column;
}

// The variable that P names. @return false after an alarm.
bool target_variable(Executor& ex, std::uint32_t& number) {
  std::size_t place = 0;
  const program::ComputedWord* word = computed_word(ex, 'P', place);
  if (word == nullptr || ex.macros->filled == nullptr) return ex.alarm(R::h_target, column_of(ex, 'P'), "P");
  macro::Expression expression = (*ex.macros->filled)[word->expression];
  const macro::Instruction last = expression.code.empty() ? macro::Instruction{} : expression.code.back();
  if (expression.code.size() == 1 && last.op == macro::Op::variable) {
    number = last.number;
    return true;
  }
  if (last.op != macro::Op::indirect) return ex.alarm(R::h_target, column_of(ex, 'P'), "P");
  expression.code.pop_back();
  double value = 0;
  const Result result = macro::evaluate(expression, ex.macros->variables, 1, value);
  if (!result.ok() || !macro::Variables::number_of(macro::or_zero(value), number))
    return ex.alarm(R::macro_variable, column_of(ex, 'P'), "P");
  return true;
}

bool jump(Executor& ex) {
  // A negative number is searched backwards first (218T L2401): where a sequence number is there once, the same.
  const double wanted = std::fabs(operand(ex, 'P'));
  if (wanted != std::floor(wanted) || wanted < 1 || wanted > 99'999)
    return ex.alarm(R::macro_goto_target, column_of(ex, 'P'), "P");
  return ex.begin_search(static_cast<std::int64_t>(wanted), column_of(ex, 'P'), R::macro_goto_target);
}

bool form_is_right(Executor& ex) {
  const program::Block& b = ex.block;
  if (b.g_count != 1) return ex.alarm(R::macro_with_words, b.g[1], 'G');
  if (b.m_count != 0) return ex.alarm(R::macro_with_words, b.m[0], 'M');
  for (char letter = 'A'; letter <= 'Z'; ++letter) {
    if (!b.has(letter)) continue;
    const bool operand_word = letter == 'H' || letter == 'P' || letter == 'Q' || letter == 'R';
    if (!operand_word || b[letter].column < ex.code_column)  // only O and N may stand before G65 (218T E40)
      return ex.alarm(R::macro_with_words, b[letter].column, std::string(1, letter));
  }
  return true;
}

enum class Series : std::uint8_t { gsk_218t, gsk_2000tc };

// 218T: 400 + n. 2000TC: its worked example says 515 for H99 P15 (L5521), its table 3000 + n (L5345), which is
// what #3000 raises: the example is followed.
bool raise_user_alarm(Executor& ex, Series series) {
  constexpr double kMost = 99;
  const double n = operand(ex, 'P');
  if (n != std::floor(n) || n < 0 || n > kMost) return ex.alarm(R::macro_argument, column_of(ex, 'P'), "P");
  const int base = series == Series::gsk_218t ? 400 : 500;
  return ex.alarm_code(std::to_string(base + static_cast<int>(n)), ex.code_column, {});
}

bool run_operation(Executor& ex, Series series) {
  if (!form_is_right(ex)) return false;
  const std::int64_t h = ex.block.has('H') ? ex.whole('H', R::h_code) : 0;
  if (h < 0) return false;
  const auto* code = std::find_if(std::begin(kCodes), std::end(kCodes), [h](const HCode& c) { return c.number == h; });
  if (code == std::end(kCodes) || (code->only_2000tc && series == Series::gsk_218t))
    return ex.alarm(R::h_code, column_of(ex, 'H'), "H" + std::to_string(h));
  if (code->kind == Kind::go) return jump(ex);
  if (code->kind == Kind::alarm) return raise_user_alarm(ex, series);
  const double q = operand(ex, 'Q'), r = operand(ex, 'R');
  if (code->takes == Takes::bits) {
    for (const char letter : {'Q', 'R'}) {
      const double value = operand(ex, letter);
      if (value != std::floor(value) || std::fabs(value) > kMostBits)
        return ex.alarm(R::h_operand, column_of(ex, letter), std::string(1, letter));
    }
  }
  if (r == 0 && std::find(std::begin(kDividing), std::end(kDividing), h) != std::end(kDividing))
    return ex.alarm(R::macro_divide, column_of(ex, 'R'), "R");
  if (code->kind == Kind::go_if) return code->value(0, q, r) == 0 || jump(ex);

  std::uint32_t number = 0;
  if (!target_variable(ex, number)) return false;
  double before = 0;
  if (h == 26) {
    if (const Result result = ex.macros->variables.read(number, before); !result.ok())
      return ex.alarm(result.fault, column_of(ex, 'P'), "P");
  }
  double value = code->value(macro::or_zero(before), q, r);
  if (macro::is_null(value)) return ex.alarm(R::h_operand, column_of(ex, 'Q'), "Q");
  if (!std::isfinite(value)) return ex.alarm(R::h_operand, column_of(ex, 'R'), "R");
  if (h == 5 && series == Series::gsk_218t) value = std::trunc(value);  // the fraction is dropped (L2505)
  const Result result = ex.macros->variables.write(number, value);
  return result.ok() || ex.alarm(result.fault, column_of(ex, 'P'), "P");
}

bool run(Executor& ex, Series series) {
  if (!run_operation(ex, series)) return false;
  if (!ex.stops_at_statements()) return true;
  auto& passed = ex.emit<interp::Message>();  // single block stops here too (218T L2499)
  passed.at = ex.at;
  passed.kind = interp::MessageKind::statement;
  return true;
}

}  // namespace

bool run_h_code_218t(Executor& ex) {
  return run(ex, Series::gsk_218t);
}
bool run_h_code_2000tc(Executor& ex) {
  return run(ex, Series::gsk_2000tc);
}

}  // namespace headstock::dialects::gsk

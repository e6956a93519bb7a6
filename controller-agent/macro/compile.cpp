// Expressions.
#include <utility>

#include "macro/names.hpp"
#include "macro/parser.hpp"
#include "program/characters.hpp"

namespace headstock::macro {
namespace {

using program::is_digit;
using program::is_letter;
using program::upper;

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\0' || c == '\x7f' || c == '\v' || c == '\f';
}

struct FunctionName {
  std::string_view name;
  Op op;
};
// The full names and their second spellings; two letters are enough (L17118), except for POW. Where two begin
// alike the first one is meant.
constexpr FunctionName kFunctions[] = {
    {"SIN", Op::sin},   {"COS", Op::cos},     {"TAN", Op::tan}, {"ASIN", Op::asin}, {"ACOS", Op::acos},
    {"ATAN", Op::atan}, {"ATN", Op::atan},    {"SQRT", Op::sqrt}, {"SQR", Op::sqrt}, {"ABS", Op::abs},
    {"BIN", Op::bin},   {"BCD", Op::bcd},     {"ROUND", Op::round}, {"RND", Op::round}, {"FIX", Op::fix},
    {"FUP", Op::fup},   {"LN", Op::ln},       {"EXP", Op::exp}, {"POW", Op::pow},   {"ADP", Op::adp},
};
constexpr FunctionName kComparisons[] = {{"EQ", Op::eq}, {"NE", Op::ne}, {"GT", Op::gt},
                                         {"GE", Op::ge}, {"LT", Op::lt}, {"LE", Op::le}};

Op function_named(std::string_view word) {
  for (const auto& [name, op] : kFunctions) {
    if (word == name || (word.size() == 2 && op != Op::pow && name.substr(0, 2) == word)) return op;
  }
  return Op::constant;
}

}  // namespace

char Parser::peek() {
  while (at_ < end_) {
    if (*at_ == '(') {
      const char* begin = ++at_;
      while (at_ < end_ && *at_ != ')') ++at_;
      if (comment_.empty()) comment_ = {begin, static_cast<std::size_t>(at_ - begin)};
      if (at_ < end_) ++at_;
    } else if (is_blank(*at_)) {
      ++at_;
    } else {
      return upper(*at_);
    }
  }
  return '\0';
}

bool Parser::take(char wanted) {
  if (peek() != wanted) return false;
  ++at_;
  return true;
}

std::string_view Parser::word() {
  peek();
  std::size_t length = 0;
  for (const char* p = at_; p < end_ && is_letter(*p) && length < 8; ++p) word_[length++] = upper(*p);
  return {word_, length};
}

bool Parser::take_word(std::string_view wanted) {
  if (!word().starts_with(wanted)) return false;  // the next word may follow without a blank: THEN#1=0
  at_ += wanted.size();
  return true;
}

bool Parser::emit(Expression& out, const Instruction& instruction, int change) {
  stack_ += change;
  if (stack_ > kMostStack - 2) return fail(Fault::macro_brackets);
  out.code.push_back(instruction);
  return true;
}

bool Parser::open_bracket() {
  if (!take('[')) return fail(Fault::macro_open_bracket);
  if (++depth_ > rules_.most_brackets) return fail(Fault::macro_brackets);
  return true;
}

bool Parser::bracketed(Expression& out) {
  if (!open_bracket()) return false;
  if (!comparison(out)) return false;
  if (!take(']')) return fail(Fault::macro_close_bracket);
  --depth_;
  return true;
}

bool Parser::expression(Expression& out) {
  stack_ = 0;
  return sum(out);
}

bool Parser::condition(Expression& out) {
  stack_ = 0;
  comparing_ = true;
  const bool good = comparison(out);
  comparing_ = false;
  return good;
}

bool Parser::comparison(Expression& out) {
  if (!sum(out)) return false;
  if (!comparing_) return true;
  const std::string_view wanted = word();
  for (const auto& [name, op] : kComparisons) {
    if (!wanted.starts_with(name)) continue;
    at_ += 2;
    compared_ = true;
    return sum(out) && binary(out, op);
  }
  return true;
}

bool Parser::sum(Expression& out) {
  if (!product(out)) return false;
  for (;;) {
    Op op = Op::add;
    if (const char c = peek(); c == '+' || c == '-') {
      ++at_;
      op = c == '+' ? Op::add : Op::subtract;
    } else if (take_word("OR")) {
      op = Op::bit_or;
    } else if (take_word("XOR")) {
      op = Op::bit_xor;
    } else {
      return true;
    }
    if (!product(out) || !binary(out, op)) return false;
  }
}

bool Parser::product(Expression& out) {
  if (!operand(out)) return false;
  for (;;) {
    Op op = Op::multiply;
    if (const char c = peek(); c == '*' || c == '/') {
      ++at_;
      op = c == '*' ? Op::multiply : Op::divide;
    } else if (take_word("AND")) {
      op = Op::bit_and;
    } else if (take_word("MOD")) {
      op = Op::modulo;
    } else {
      return true;
    }
    if (!operand(out) || !binary(out, op)) return false;
  }
}

bool Parser::operand(Expression& out) {
  const char c = peek();
  if (c == '-' || c == '+') {
    if (++signs_ > 16) return fail(Fault::expression);
    ++at_;
    const bool good = operand(out) && (c == '+' || emit(out, Instruction{.op = Op::negate}, 0));
    --signs_;
    return good;
  }
  if (c == '#') {
    ++at_;
    if (peek() == '[') {
      if (!bracketed(out)) return false;
      return emit(out, Instruction{.op = Op::indirect}, 0);
    }
    Instruction in{.op = Op::variable};
    if (!whole(in.number, 99'999'999)) return fail(Fault::expression);
    if (rules_.nine_is_indirect && in.number >= 9'000 && in.number <= 9'999) {
      in.number -= 9'000;
      return emit(out, in, 1) && emit(out, Instruction{.op = Op::indirect}, 0);
    }
    return emit(out, in, 1);
  }
  if (c == '[') {
    const char* inner = at_ + 1;
    while (inner < end_ && is_blank(*inner)) ++inner;
    if (rules_.names && inner + 1 < end_ && *inner == '#' && (is_letter(inner[1]) || inner[1] == '_')) {
      Instruction how;
      std::string name;
      if (!system_or_named(out, how, name)) return false;
      if (how.op == Op::named) {
        how.number = static_cast<std::uint32_t>(out.names.size());
        out.names.push_back(std::move(name));
      }
      return emit(out, how, how.op == Op::indexed ? 0 : 1);
    }
    return bracketed(out);
  }
  if (is_letter(c)) return function(out);
  Instruction in{.op = Op::constant};
  return number(in.constant) && emit(out, in, 1);
}

bool Parser::function(Expression& out) {
  const std::string_view name = word();
  Op op = function_named(name);
  if (op == Op::constant) return fail(Fault::no_address);  // letters that are no function
  at_ += name.size();
  if (op == Op::adp) {
    if (!open_bracket()) return false;
    Instruction in{.op = Op::adp};
    if (!take('#') || !whole(in.number, rules_.locals) || in.number == 0) return fail(Fault::expression);
    if (!take(']')) return fail(Fault::macro_close_bracket);
    --depth_;
    return emit(out, in, 1);
  }
  if (!open_bracket()) return false;
  const bool was_comparing = std::exchange(comparing_, false);
  if (!sum(out)) return false;
  bool two = false;
  if (peek() == ',') {
    if (op != Op::atan && op != Op::pow) return fail(Fault::macro_two_arguments);
    ++at_;
    two = true;
    if (!sum(out)) return false;
  } else if (op == Op::pow) {
    return fail(Fault::macro_comma);
  }
  comparing_ = was_comparing;
  if (!take(']')) return fail(Fault::macro_close_bracket);
  --depth_;
  if (op == Op::atan && !two && peek() == '/') {  // ATAN[y]/[x]; ATAN[y]/10 is PS1131 (L17030)
    ++at_;
    if (peek() != '[') return fail(Fault::macro_open_bracket);
    if (!bracketed(out)) return false;
    two = true;
  }
  if (op == Op::atan && two) op = Op::atan2;
  return emit(out, Instruction{.op = op}, op == Op::atan2 || op == Op::pow ? -1 : 0);
}

// [#NAME], [#_NAME], [#_NAME[index]].
bool Parser::system_or_named(Expression& out, Instruction& how, std::string& name) {
  if (!open_bracket()) return false;
  take('#');
  const char* begin = at_;
  while (at_ < end_ && *at_ != '[' && *at_ != ']' && *at_ != '(' && *at_ != ')' && !is_blank(*at_)) ++at_;
  for (const char* p = begin; p < at_; ++p) name += upper(*p);
  if (name.size() > 8) return fail(Fault::macro_name_long, begin);
  if (name.front() == '_') {
    const auto known = system_name(std::string_view(name).substr(1), lathe_);
    if (!known) return fail(name.starts_with("_OFS") ? Fault::offset_name : Fault::macro_no_name, begin);
    how = {.op = known->bit >= 0 ? Op::bit : known->most != 0 ? Op::indexed : Op::variable,
           .from_zero = known->from_zero,
           .step = known->bit >= 0 ? static_cast<std::uint16_t>(known->bit) : known->step,
           .most = known->most,
           .number = known->number};
    const bool indexed = peek() == '[';
    if (indexed != (how.op == Op::indexed)) return fail(Fault::macro_subscript);
    if (indexed && !bracketed(out)) return false;
  } else {
    how = {.op = Op::named};
  }
  if (!take(']')) return fail(Fault::macro_close_bracket);
  --depth_;
  return true;
}

bool Parser::place(Place& out) {
  stack_ = 0;
  if (peek() == '[') return system_or_named(out.index, out.how, out.name);
  if (!take('#')) return fail(Fault::macro_syntax);
  if (peek() == '[') {
    out.how = {.op = Op::indirect};
    return bracketed(out.index);
  }
  out.how = {.op = Op::variable};
  return whole(out.how.number, 99'999'999) || fail(Fault::expression);
}

bool Parser::number(double& out) {
  peek();
  std::int64_t digits = 0;
  unsigned count = 0, decimals = 0;
  bool point = false, significant = false;
  const char* begin = at_;
  for (; at_ < end_; ++at_) {
    if (*at_ == '.') {
      if (point) return fail(Fault::expression);
      point = true;
    } else if (is_digit(*at_)) {
      significant = significant || *at_ != '0';
      if (significant && ++count > rules_.most_digits) return fail(Fault::macro_digits, begin);
      if (count <= 18 && decimals < 18) {
        digits = digits * 10 + (*at_ - '0');
        decimals += point ? 1u : 0u;
      }
    } else {
      break;
    }
  }
  if (at_ == begin || (point && at_ == begin + 1)) return fail(Fault::expression, begin);
  // Both are exact in a double below 2^53 and 10^22: the quotient is the correctly rounded constant.
  double scale = 1;
  for (unsigned i = 0; i < decimals; ++i) scale *= 10;
  out = static_cast<double>(digits) / scale;
  return true;
}

bool Parser::whole(std::uint32_t& out, std::uint32_t most) {
  peek();
  std::uint64_t value = 0;
  const char* begin = at_;
  for (; at_ < end_ && is_digit(*at_); ++at_) {
    value = value * 10 + static_cast<std::uint64_t>(*at_ - '0');
    if (value > most) return false;
  }
  out = static_cast<std::uint32_t>(value);
  return at_ != begin;
}

TextFault compile_word(const char*& at, const char* end, const Rules& rules, bool lathe, Expression& out) {
  Parser parser(at, end, rules, lathe);
  bool negative = parser.take('-');
  if (!negative) parser.take('+');
  if (parser.operand(out) && negative) out.code.push_back(Instruction{.op = Op::negate});
  at = parser.at();
  return parser.fault();
}

}  // namespace headstock::macro

#include "macro/k2000-language/expression.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "program/characters.hpp"

namespace headstock::k2000 {
namespace {

constexpr int kMostDepth = 40;  // brackets inside each other; the manual names no limit

using program::is_digit;
using program::is_letter;
using program::upper;

struct Written {
  int level;  // 0 binds loosest
  std::string_view text;
  Operator op;
};
// Longer ones first: << before <. Levels as L19650 lists them.
constexpr Written kOperators[] = {
    {0, "&&", Operator::logical_and}, {0, "||", Operator::logical_or},
    {2, "==", Operator::equal},       {2, "!=", Operator::not_equal},
    {4, "<<", Operator::shift_left},  {4, ">>", Operator::shift_right},
    {3, "<=", Operator::less_equal},  {3, ">=", Operator::greater_equal},
    {3, "<", Operator::less},         {3, ">", Operator::greater},
    {1, "&", Operator::bit_and},      {1, "^", Operator::bit_xor},
    {1, "|", Operator::bit_or},       {5, "+", Operator::add},
    {5, "-", Operator::subtract},     {6, "*", Operator::multiply},
    {6, "/", Operator::divide},       {1, "AND", Operator::bit_and},
    {1, "XOR", Operator::bit_xor},    {1, "OR", Operator::bit_or},
    {2, "EQ", Operator::equal},       {2, "NE", Operator::not_equal},
    {3, "GT", Operator::greater},     {3, "GE", Operator::greater_equal},
    {3, "LT", Operator::less},        {3, "LE", Operator::less_equal},
};
constexpr int kLevels = 7;

struct NamedType {
  std::string_view name;
  Type type;
};
constexpr NamedType kTypes[] = {{"INT", Type::int_},    {"UINT", Type::uint},    {"LONG", Type::long_},
                                {"ULONG", Type::ulong}, {"FLOAT", Type::float_}, {"DOUBLE", Type::double_}};

}  // namespace

void Parser::skip_blanks() {
  while (at_ < end_ && (*at_ == ' ' || *at_ == '\t')) ++at_;
}

char Parser::peek() {
  skip_blanks();
  return at_ < end_ ? *at_ : '\0';
}

bool Parser::fail(Error error) {
  if (error == Error::null_used && empty_read_) error = Error::undefined;
  if (error_ == Error::none) error_ = error;
  return false;
}

bool Parser::take(char c) {
  if (peek() != c) return false;
  ++at_;
  return true;
}

bool Parser::take(std::string_view text) {
  skip_blanks();
  if (static_cast<std::size_t>(end_ - at_) < text.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (upper(at_[i]) != text[i]) return false;
  }
  const char* behind = at_ + text.size();
  if (is_letter(text.back()) && behind < end_ && is_letter(*behind)) return false;
  at_ = behind;
  return true;
}

bool Parser::string(std::string& text) {
  if (!take('"')) return false;
  text.clear();
  for (; at_ < end_ && *at_ != '"'; ++at_) {
    if (*at_ == '\\' && at_ + 1 < end_ && (at_[1] == 'n' || at_[1] == 't')) {
      text += at_[1] == 'n' ? '\n' : '\t';
      ++at_;
    } else {
      text += *at_;
    }
  }
  if (at_ == end_) return fail(Error::syntax);
  ++at_;
  return true;
}

bool Parser::read(std::uint32_t number, Value& value) {
  const Error error = variables_.read(number, value);
  if (error != Error::none) return fail(error);
  empty_read_ = empty_read_ || value.is_null();
  return true;
}

bool Parser::is_place() {
  const char c = peek();
  return c == '#' || (upper(c) == 'R' && at_ + 1 < end_ && is_digit(at_[1]));
}

// #12, #[…], ##3, r5; then an index [i] or a size {n}.
bool Parser::place(Place& place) {
  if (!is_place()) return false;
  if (++depth_ > kMostDepth) return fail(Error::syntax);
  std::int64_t number = 0;
  const bool is_register = *at_ != '#';
  ++at_;
  if (is_register || is_digit(peek())) {
    const char* from = at_;
    for (; at_ < end_ && is_digit(*at_) && at_ - from < 9; ++at_) number = number * 10 + (*at_ - '0');
    if (is_register && number >= kLocals) return fail(Error::no_variable);
    if (!is_register && number == 0 && options_.zero_is_null) return fail(Error::null_used);
  } else {
    Value inner;
    if (peek() == '#' ? !behind_address(inner) : !bracket(inner)) return fail(Error::syntax);
    const double value = inner.number();
    if (inner.is_null()) return fail(Error::null_used);
    if (!(value >= 0 && value < 1e6) || value != std::floor(value)) return fail(Error::no_variable);
    number = static_cast<std::int64_t>(value);
  }
  place.count = 0;
  if (at_ < end_ && *at_ == '[') {
    Value index;
    if (!bracket(index)) return false;
    const auto offset = index.integer();
    if (!offset) return fail(Error::whole_needed);
    if (*offset > 1'000'000 || *offset < -1'000'000) return fail(Error::no_variable);
    number += *offset;
  } else if (at_ < end_ && *at_ == '{') {
    ++at_;
    Value size;
    if (!expression(size) || !take('}')) return fail(Error::syntax);
    const auto count = size.integer();
    if (!count) return fail(Error::whole_needed);
    if (*count < 1 || *count > 1'000) return fail(Error::array_size);
    place.count = static_cast<std::uint32_t>(*count);
  }
  if (number < 0 || (is_register && number + std::max<std::int64_t>(place.count, 1) > kLocals))
    return fail(Error::no_variable);
  place.number = static_cast<std::uint32_t>(number);
  --depth_;
  return true;
}

bool Parser::bracket(Value& value) {
  if (!take('[')) return fail(Error::syntax);
  if (++depth_ > kMostDepth) return fail(Error::syntax);
  if (!expression(value)) return false;
  --depth_;
  return take(']') || fail(Error::syntax);
}

bool Parser::behind_address(Value& value) {
  const bool minus = take('-');
  if (peek() == '[') {
    if (!bracket(value)) return false;
  } else {
    Place where;
    if (!place(where)) return fail(Error::syntax);
    if (where.count != 0) return fail(Error::syntax);
    if (!read(where.number, value)) return false;
  }
  if (!minus) return true;
  const Error error = apply(Sign::minus, value, value);
  return error == Error::none || fail(error);
}

bool Parser::value_or_null(Value& value) {
  if (take("NULL")) {
    value = {};
    const char next = peek();  // NULL stands alone or not at all
    return next == '\0' || next == ',' || next == ']' || fail(Error::null_used);
  }
  if (options_.zero_is_null && peek() == '#') {  // #0 and #00 are NULL as text
    const char* from = at_++;
    bool zeros = at_ < end_ && *at_ == '0';
    while (at_ < end_ && *at_ == '0') ++at_;
    if (zeros && (at_ == end_ || (!is_digit(*at_) && *at_ != '['))) {
      value = {};
      return true;
    }
    at_ = from;
  }
  return expression(value);
}

bool Parser::expression(Value& value) {
  return binary(0, value);
}

bool Parser::next_operator(int level, Operator& op) {
  skip_blanks();
  for (const Written& written : kOperators) {
    const char* from = at_;
    if (!take(written.text)) continue;
    // `&=` and the like are assignments, and end the expression before them.
    const bool assigns =
        !is_letter(written.text[0]) && at_ < end_ && *at_ == '=' && written.text.back() != '=';
    if (written.level == level && !assigns) {
      op = written.op;
      return true;
    }
    at_ = from;
    return false;
  }
  return false;
}

bool Parser::binary(int level, Value& value) {
  if (level == kLevels) return unary(value);
  if (!binary(level + 1, value)) return false;
  Operator op{};
  while (next_operator(level, op)) {
    Value right;
    if (!binary(level + 1, right)) return false;
    if (const Error error = apply(op, value, right, value); error != Error::none) return fail(error);
  }
  return true;
}

bool Parser::unary(Value& value) {
  const char c = peek();
  if (c == '+' || c == '-' || c == '!' || c == '~') {
    if (++depth_ > kMostDepth) return fail(Error::syntax);
    ++at_;
    if (!unary(value)) return false;
    --depth_;
    const Sign sign = c == '+'   ? Sign::plus
                      : c == '-' ? Sign::minus
                      : c == '!' ? Sign::logical_not
                                 : Sign::bit_not;
    const Error error = apply(sign, value, value);
    return error == Error::none || fail(error);
  }
  bool was_cast = false;
  if (c == '[' && !cast(value, was_cast)) return false;
  return was_cast || primary(value);
}

// [INT]5.5
bool Parser::cast(Value& value, bool& was_cast) {
  const char* from = at_;
  ++at_;
  for (const NamedType& type : kTypes) {
    const char* inside = at_;
    if (take(type.name) && take(']')) {
      was_cast = true;
      if (!unary(value)) return false;
      if (value.is_null()) return fail(Error::null_used);
      value = convert(value, type.type);
      return true;
    }
    at_ = inside;
  }
  at_ = from;
  return true;
}

bool Parser::primary(Value& value) {
  const char c = peek();
  if (c == '[') return bracket(value);
  if (is_digit(c) || c == '.') return constant(value);
  if (is_place()) {
    Place where;
    if (!place(where)) return false;
    return where.count == 0 ? read(where.number, value) : fail(Error::syntax);
  }
  if (is_letter(c)) return named(value);
  return fail(Error::syntax);
}

// 12, 0x1f, 5ul, 1.5, 2.5e3, 5.1f
bool Parser::constant(Value& value) {
  const char* from = at_;
  if (*at_ == '0' && at_ + 1 < end_ && upper(at_[1]) == 'X') {
    at_ += 2;
    std::uint64_t bits = 0;
    int digits = 0;
    for (; at_ < end_; ++at_, ++digits) {
      const char h = upper(*at_);
      const int digit = is_digit(h) ? h - '0' : h >= 'A' && h <= 'F' ? h - 'A' + 10 : -1;
      if (digit < 0) break;
      bits = bits << 4 | static_cast<std::uint64_t>(digit);
    }
    if (digits == 0 || digits > 16) return fail(Error::syntax);
    value = {bits <= 0x7fff'ffffu   ? Type::int_
             : bits <= 0xffff'ffffu ? Type::uint
                                    : Type::ulong,
             static_cast<std::int64_t>(bits), 0};
  } else {
    bool real = false, exponent = false;
    while (at_ < end_ && (is_digit(*at_) || *at_ == '.')) {
      if (*at_ == '.') {
        if (real) return fail(Error::syntax);
        real = true;
      }
      ++at_;
    }
    if (at_ < end_ && upper(*at_) == 'E' && at_ + 1 < end_ &&
        (is_digit(at_[1]) || ((at_[1] == '-' || at_[1] == '+') && at_ + 2 < end_ && is_digit(at_[2])))) {
      real = exponent = true;
      at_ += 2;
      while (at_ < end_ && is_digit(*at_)) ++at_;
    }
    const std::string text(from, at_);
    if (text == "." || text.size() > 40) return fail(Error::syntax);
    if (real) {
      value = Value::of_double(std::strtod(text.c_str(), nullptr));
      if (!exponent && at_ < end_ && (upper(*at_) == 'F' || upper(*at_) == 'D')) {
        if (upper(*at_++) == 'F') value = Value::of_float(value.real);
      }
      return true;
    }
    if (text.size() > 19) return fail(Error::syntax);
    const std::uint64_t whole = std::strtoull(text.c_str(), nullptr, 10);
    const Type type = whole <= 0x7fff'ffffu             ? Type::int_
                      : whole <= 0xffff'ffffu           ? Type::uint
                      : whole <= 0x7fff'ffff'ffff'ffffu ? Type::long_
                                                        : Type::ulong;
    value = {type, static_cast<std::int64_t>(whole), 0};
    if (at_ < end_ && (upper(*at_) == 'F' || upper(*at_) == 'D') && (at_ + 1 == end_ || !is_letter(at_[1]))) {
      value = upper(*at_++) == 'F' ? Value::of_float(value.number()) : Value::of_double(value.number());
      return true;
    }
  }
  // s, u, l and their pairs; longer runs of letters belong to what follows (5LE6).
  bool is_long = value.type >= Type::long_, is_unsigned = false, is_signed = false;
  std::size_t letters = 0;
  bool suffix = true;
  for (; at_ + letters < end_ && is_letter(at_[letters]); ++letters) {
    const char s = upper(at_[letters]);
    bool& flag = s == 'L' ? is_long : s == 'U' ? is_unsigned : is_signed;
    suffix = suffix && letters < 2 && (s == 'L' || s == 'U' || s == 'S');
    if (suffix) flag = true;
  }
  if (!suffix || letters == 0) return true;
  at_ += letters;
  if (is_unsigned || is_signed || is_long) {
    const bool plain_unsigned = value.type == Type::uint || value.type == Type::ulong;
    const bool no_sign = is_unsigned || (plain_unsigned && !is_signed);
    value =
        convert(value, is_long ? (no_sign ? Type::ulong : Type::long_) : (no_sign ? Type::uint : Type::int_));
  }
  return true;
}

bool Parser::arguments(std::vector<Value>& values, std::size_t most) {
  if (!take('[')) return fail(Error::syntax);
  if (++depth_ > kMostDepth) return fail(Error::syntax);
  do {
    if (values.size() == most) return fail(Error::syntax);
    Value value;
    if (!expression(value)) return false;
    values.push_back(value);
  } while (take(','));
  --depth_;
  return take(']') || fail(Error::syntax);
}

bool Parser::named(Value& value) {
  skip_blanks();
  char name[12];
  std::size_t length = 0;
  const char* at = at_;
  for (; at < end_ && (is_letter(*at) || (length > 0 && is_digit(*at))) && length < sizeof name; ++at)
    name[length++] = upper(*at);
  const std::string_view word(name, length);
  struct Constant {
    std::string_view name;
    Type type;
    double real;
    std::int64_t whole;
  };
  constexpr double kInf = std::numeric_limits<double>::infinity();
  static constexpr Constant kConstants[] = {
      {"PI", Type::double_, 3.14159265358979323846, 0},
      {"INF", Type::double_, kInf, 0},
      {"PINF", Type::double_, kInf, 0},
      {"NINF", Type::double_, -kInf, 0},
      {"ZERO", Type::double_, 0.0, 0},
      {"PZERO", Type::double_, 0.0, 0},
      {"NZERO", Type::double_, -0.0, 0},
      {"TRUE", Type::uint, 0, 1},
      {"FALSE", Type::uint, 0, 0},
      {"NAN", Type::double_, std::numeric_limits<double>::quiet_NaN(), 0}};
  for (const Constant& constant : kConstants) {
    if (constant.name != word) continue;
    at_ = at;
    value = {constant.type, constant.whole, constant.real};
    return true;
  }
  if (word == "NULL") return fail(Error::null_used);
  at_ = at;
  if (word == "ISNULL") {  // the one function that takes NULL
    if (!take('[') || !value_or_null(value) || !take(']')) return fail(Error::syntax);
    value = Value::of_int(value.is_null() ? 1 : 0);
    return true;
  }
  return function(word, false, value);
}

std::string text_of(const Value& value) {
  char text[40];
  switch (value.type) {
    case Type::null:
      return "NULL";
    case Type::ulong:
      std::snprintf(text, sizeof text, "%llu", static_cast<unsigned long long>(value.whole));
      break;
    case Type::float_:
      std::snprintf(text, sizeof text, "%.6g", value.real);
      break;
    case Type::double_:
      std::snprintf(text, sizeof text, "%.15g", value.real);
      break;
    default:
      std::snprintf(text, sizeof text, "%lld", static_cast<long long>(value.whole));
      break;
  }
  return text;
}

void rewrite(std::string& text) {
  bool in_string = false, in_comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char& c = text[i];
    const char next = i + 1 < text.size() ? text[i + 1] : '\0';
    if (in_comment) {
      const bool closes = c == '*' && next == '/';
      c = ' ';
      if (closes) {
        text[++i] = ' ';
        in_comment = false;
      }
    } else if (in_string) {
      in_string = c != '"';
    } else if (c == '"') {
      in_string = true;
    } else if (c == '/' && next == '/') {
      for (; i < text.size(); ++i) text[i] = ' ';
    } else if (c == '/' && next == '*') {
      in_comment = true;
      c = text[++i] = ' ';
    } else if (c == '[' || c == ']') {
      c = c == '[' ? '{' : '}';
    } else if (c == '(' || c == ')') {
      c = c == '(' ? '[' : ']';
    }
  }
}

}  // namespace headstock::k2000

#include "macro/k2000-language/value.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace headstock::k2000 {
namespace {

std::int64_t narrow(std::int64_t value, Type type) {
  switch (type) {
    case Type::int_:
      return static_cast<std::int32_t>(static_cast<std::uint64_t>(value) & 0xffff'ffffu);
    case Type::uint:
      return static_cast<std::int64_t>(static_cast<std::uint64_t>(value) & 0xffff'ffffu);
    default:
      return value;
  }
}

bool is_unsigned(Type type) {
  return type == Type::uint || type == Type::ulong;
}

std::int64_t from_real(double real, Type type) {
  if (std::isnan(real)) return 0;
  const double cut = std::trunc(real);
  switch (type) {
    case Type::int_:
      return static_cast<std::int64_t>(std::clamp(cut, -2147483648.0, 2147483647.0));
    case Type::uint:
      return static_cast<std::int64_t>(std::clamp(cut, 0.0, 4294967295.0));
    case Type::long_:
      if (cut >= 9223372036854775808.0) return std::numeric_limits<std::int64_t>::max();
      if (cut < -9223372036854775808.0) return std::numeric_limits<std::int64_t>::min();
      return static_cast<std::int64_t>(cut);
    default:
      if (cut >= 18446744073709551616.0) return -1;
      return static_cast<std::int64_t>(static_cast<std::uint64_t>(std::max(cut, 0.0)));
  }
}

// Two's complement throughout: the control does not check for overflow (L18905).
Error whole_operation(Operator op, Type type, std::int64_t a, std::int64_t b, std::int64_t& result) {
  const auto ua = static_cast<std::uint64_t>(a);
  const auto ub = static_cast<std::uint64_t>(b);
  std::uint64_t out = 0;
  switch (op) {
    case Operator::multiply:
      out = ua * ub;
      break;
    case Operator::divide:
      if (b == 0) return Error::divide_by_zero;
      if (is_unsigned(type)) {
        out = ua / ub;
      } else {
        out = b == -1 ? 0 - ua : static_cast<std::uint64_t>(a / b);
      }
      break;
    case Operator::add:
      out = ua + ub;
      break;
    default:
      out = ua - ub;
      break;
  }
  result = static_cast<std::int64_t>(out);
  return Error::none;
}

template <typename T>
bool compares(Operator op, T a, T b) {
  switch (op) {
    case Operator::less:
      return a < b;
    case Operator::less_equal:
      return a <= b;
    case Operator::greater:
      return a > b;
    case Operator::greater_equal:
      return a >= b;
    case Operator::equal:
      return a == b;
    default:
      return a != b;
  }
}

Error bits(Operator op, const Value& left, const Value& right, Value& result) {
  if (left.is_real() || right.is_real()) return Error::whole_needed;
  // The result has no sign; it is long when one side is (L19700).
  const bool shifts = op == Operator::shift_left || op == Operator::shift_right;
  const Type wide = shifts ? left.type : std::max(left.type, right.type);
  const Type type = wide >= Type::long_ ? Type::ulong : Type::uint;
  const auto a = static_cast<std::uint64_t>(narrow(left.whole, type));
  const auto b = static_cast<std::uint64_t>(right.whole);
  const unsigned width = type == Type::ulong ? 64 : 32;
  std::uint64_t out = 0;
  switch (op) {
    case Operator::shift_left:
      out = b < width ? a << b : 0;
      break;
    case Operator::shift_right:
      out = b < width ? a >> b : 0;
      break;
    case Operator::bit_and:
      out = a & b;
      break;
    case Operator::bit_xor:
      out = a ^ b;
      break;
    default:
      out = a | b;
      break;
  }
  result = {type, narrow(static_cast<std::int64_t>(out), type), 0};
  return Error::none;
}

Value truth(bool yes) {
  return {Type::uint, yes ? 1 : 0, 0};
}

}  // namespace

Value Value::of_int(std::int64_t value) {
  return {Type::int_, narrow(value, Type::int_), 0};
}

Value Value::of_uint(std::uint64_t value) {
  return {Type::uint, narrow(static_cast<std::int64_t>(value), Type::uint), 0};
}

Value Value::of_float(double value) {
  // Results too small for a FLOAT become 0, as the manual's own example shows (EXP2F[-149], L21730).
  const auto single = static_cast<float>(value);
  return {Type::float_, 0, std::fpclassify(single) == FP_SUBNORMAL ? 0.0 : static_cast<double>(single)};
}

double Value::number() const {
  if (is_real()) return real;
  return type == Type::ulong ? static_cast<double>(static_cast<std::uint64_t>(whole))
                             : static_cast<double>(whole);
}

Value convert(const Value& value, Type to) {
  switch (to) {
    case Type::null:
      return {};
    case Type::float_:
      return Value::of_float(value.number());
    case Type::double_:
      return Value::of_double(value.number());
    default:
      return {to, value.is_real() ? from_real(value.real, to) : narrow(value.whole, to), 0};
  }
}

Error apply(Operator op, const Value& left, const Value& right, Value& result) {
  if (left.is_null() || right.is_null()) return Error::null_used;
  switch (op) {
    case Operator::logical_and:
      result = truth(left.truth() && right.truth());
      return Error::none;
    case Operator::logical_or:
      result = truth(left.truth() || right.truth());
      return Error::none;
    case Operator::shift_left:
    case Operator::shift_right:
    case Operator::bit_and:
    case Operator::bit_xor:
    case Operator::bit_or:
      return bits(op, left, right, result);
    default:
      break;
  }
  const Type type = std::max(left.type, right.type);
  const Value a = convert(left, type);
  const Value b = convert(right, type);
  if (op >= Operator::less && op <= Operator::not_equal) {
    if (a.is_real()) {
      result = truth(compares(op, a.real, b.real));
    } else if (is_unsigned(type)) {
      result = truth(compares(op, static_cast<std::uint64_t>(a.whole), static_cast<std::uint64_t>(b.whole)));
    } else {
      result = truth(compares(op, a.whole, b.whole));
    }
    return Error::none;
  }
  if (a.is_real()) {
    const double x = a.real, y = b.real;
    const double out = op == Operator::multiply ? x * y
                       : op == Operator::divide ? x / y
                       : op == Operator::add    ? x + y
                                                : x - y;
    result = type == Type::float_ ? Value::of_float(out) : Value::of_double(out);
    return Error::none;
  }
  std::int64_t out = 0;
  const Error error = whole_operation(op, type, a.whole, b.whole, out);
  result = {type, narrow(out, type), 0};
  return error;
}

Error apply(Sign sign, const Value& value, Value& result) {
  if (value.is_null()) return Error::null_used;
  switch (sign) {
    case Sign::plus:
      result = value;
      return Error::none;
    case Sign::minus:
      result = value;
      if (value.is_real()) {
        result.real = -value.real;
      } else {
        result.whole =
            narrow(static_cast<std::int64_t>(0 - static_cast<std::uint64_t>(value.whole)), value.type);
      }
      return Error::none;
    case Sign::logical_not:
      result = truth(!value.truth());
      return Error::none;
    case Sign::bit_not: {
      if (value.is_real()) return Error::whole_needed;
      const Type type = value.type >= Type::long_ ? Type::ulong : Type::uint;
      result = {type, narrow(~value.whole, type), 0};
      return Error::none;
    }
  }
  return Error::none;
}

}  // namespace headstock::k2000

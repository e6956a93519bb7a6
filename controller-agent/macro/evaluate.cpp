#include <array>
#include <cmath>
#include <numbers>

#include "macro/expression.hpp"

namespace headstock::macro {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// Exact at the multiples of 90°, where programs compare.
double sine(double degrees) {
  const double r = std::remainder(degrees, 360);
  if (r == 0 || std::fabs(r) == 180) return 0;
  if (std::fabs(r) == 90) return r > 0 ? 1 : -1;
  return std::sin(r / kDegrees);
}
double cosine(double degrees) {
  const double r = std::remainder(degrees, 360);
  if (std::fabs(r) == 90) return 0;
  return std::cos(r / kDegrees);
}

double nearest(double value) {
  return std::copysign(std::floor(std::fabs(value) + 0.5), value);
}

// 32 bits, as the control's words are (L16870).
bool bits_of(double value, std::uint32_t& bits) {
  const double whole = nearest(value);
  if (!(std::fabs(whole) < 4294967296.0)) return false;
  bits = static_cast<std::uint32_t>(static_cast<std::int64_t>(whole));
  return true;
}

bool bcd_to_binary(double value, double& out) {
  std::uint32_t bits = 0;
  if (!bits_of(value, bits)) return false;
  std::int64_t sum = 0;
  for (int digit = 7; digit >= 0; --digit) {
    const std::uint32_t nibble = bits >> (4 * digit) & 0xfu;
    if (nibble > 9) return false;
    sum = sum * 10 + nibble;
  }
  out = static_cast<double>(sum);
  return true;
}

bool binary_to_bcd(double value, double& out) {
  const double whole = nearest(value);
  if (!(whole >= 0 && whole <= 99'999'999)) return false;
  auto rest = static_cast<std::uint32_t>(whole);
  std::uint32_t bits = 0;
  for (int digit = 0; digit < 8; ++digit, rest /= 10) bits |= (rest % 10) << (4 * digit);
  out = static_cast<double>(bits);
  return true;
}

double full_circle(double degrees) {
  return degrees < 0 ? degrees + 360 : degrees;
}

// One operand. @return false when it is outside what the function takes (PS0119).
bool apply(Op op, double x, double steps, const Variables& variables, double& out) {
  switch (op) {
    case Op::sin:
      out = sine(x);
      return true;
    case Op::cos:
      out = cosine(x);
      return true;
    case Op::tan: {
      const double c = cosine(x);
      out = c == 0 ? 0 : sine(x) / c;
      return c != 0;
    }
    case Op::asin:
      if (std::fabs(x) > 1) return false;
      out = std::asin(x) * kDegrees;
      if (!variables.signed_angles) out = full_circle(out);
      return true;
    case Op::acos:
      if (std::fabs(x) > 1) return false;
      out = std::acos(x) * kDegrees;
      return true;
    case Op::atan:
      out = std::atan(x) * kDegrees;
      return true;
    case Op::sqrt:
      out = std::sqrt(x);
      return x >= 0;
    case Op::abs:
      out = std::fabs(x);
      return true;
    case Op::bin:
      return bcd_to_binary(x, out);
    case Op::bcd:
      return binary_to_bcd(x, out);
    case Op::round:
      out = nearest(x * steps) / steps;
      return true;
    case Op::fix:
      out = std::trunc(x);
      return true;
    case Op::fup:
      out = std::copysign(std::ceil(std::fabs(x)), x);
      return true;
    case Op::ln:
      if (x <= 0) return false;
      out = std::log(x);
      return true;
    case Op::exp:
      out = std::exp(x);
      return std::isfinite(out);
    default:
      return false;
  }
}

bool compare(Op op, double a, double b) {
  switch (op) {
    case Op::eq:
      return is_null(a) || is_null(b) ? is_null(a) && is_null(b) : a == b;
    case Op::ne:
      return is_null(a) || is_null(b) ? is_null(a) != is_null(b) : a != b;
    case Op::gt:
      return or_zero(a) > or_zero(b);
    case Op::ge:
      return or_zero(a) >= or_zero(b);
    case Op::lt:
      return or_zero(a) < or_zero(b);
    default:
      return or_zero(a) <= or_zero(b);
  }
}

Result calculate(Op op, double a, double b, const Variables& variables, double& out) {
  switch (op) {
    case Op::add:
      out = a + b;
      return {};
    case Op::subtract:
      out = a - b;
      return {};
    case Op::multiply:
      out = a * b;
      return {};
    case Op::divide:
      if (b == 0) return Result::failed(Fault::macro_divide);
      out = a / b;
      return {};
    case Op::modulo: {
      const double divisor = nearest(b);
      if (divisor == 0) return Result::failed(Fault::macro_divide);
      out = std::fmod(nearest(a), divisor);
      return {};
    }
    case Op::bit_and:
    case Op::bit_or:
    case Op::bit_xor: {
      std::uint32_t x = 0, y = 0;
      if (!bits_of(a, x) || !bits_of(b, y)) return Result::failed(Fault::macro_integer);
      x = op == Op::bit_and ? x & y : op == Op::bit_or ? x | y : x ^ y;
      out = static_cast<double>(static_cast<std::int32_t>(x));
      return {};
    }
    case Op::atan2:
      out = std::atan2(a, b) * kDegrees;
      if (!variables.signed_angles) out = full_circle(out);
      return {};
    case Op::pow:
      out = std::pow(a, b);
      if (is_null(out) || (a == 0 && b < 0)) return Result::failed(Fault::macro_argument);
      return {};
    default:
      return Result::failed(Fault::expression);
  }
}

}  // namespace

Result evaluate(const Expression& expression, Variables& variables, double steps, double& value) {
  std::array<double, kMostStack> stack;
  double* top = stack.data() - 1;
  for (const Instruction& in : expression.code) {
    switch (in.op) {
      case Op::constant:
        *++top = in.constant;
        continue;
      case Op::variable: {
        const Result read = variables.read(in.number, *++top);
        if (!read.ok()) return read;
        continue;
      }
      case Op::indirect: {
        std::uint32_t number = 0;
        if (!Variables::number_of(*top, number)) return Result::failed(Fault::macro_variable);
        const Result read = variables.read(number, *top);
        if (!read.ok()) return read;
        continue;
      }
      case Op::named: {
        const std::uint32_t number = variables.named(expression.names[in.number]);
        if (number == Variables::kNoVariable) return Result::failed(Fault::macro_no_name);
        const Result read = variables.read(number, *++top);
        if (!read.ok()) return read;
        continue;
      }
      case Op::indexed: {
        const double index = nearest(or_zero(*top)) - (in.from_zero ? 0 : 1);
        if (!(index >= 0 && index < in.most)) return Result::failed(Fault::macro_subscript);
        const auto number = in.number + static_cast<std::uint32_t>(index) * in.step;
        const Result read = variables.read(number, *top);
        if (!read.ok()) return read;
        continue;
      }
      case Op::bit: {
        double word = 0;
        const Result read = variables.read(in.number, word);
        if (!read.ok()) return read;
        *++top = static_cast<double>(static_cast<std::uint32_t>(or_zero(word)) >> in.step & 1u);
        continue;
      }
      case Op::adp: {
        if (variables.adp_refused) return Result::failed(Fault::expression);
        double scale = 1;
        for (int i = variables.locals->implied_decimals[in.number]; i > 0; --i) scale *= 10;
        *++top = or_zero(variables.locals->values[in.number]) * scale;
        continue;
      }
      case Op::negate:
        *top = 0 - or_zero(*top);
        continue;
      case Op::add:
        --top;
        *top = or_zero(top[0]) + or_zero(top[1]);
        break;
      case Op::subtract:
        --top;
        *top = or_zero(top[0]) - or_zero(top[1]);
        break;
      case Op::multiply:
        --top;
        *top = or_zero(top[0]) * or_zero(top[1]);
        break;
      case Op::eq:
      case Op::ne:
      case Op::gt:
      case Op::ge:
      case Op::lt:
      case Op::le:
        --top;
        *top = compare(in.op, top[0], top[1]) ? 1 : 0;
        continue;
      case Op::divide:
      case Op::modulo:
      case Op::bit_and:
      case Op::bit_or:
      case Op::bit_xor:
      case Op::atan2:
      case Op::pow: {
        --top;
        const Result done = calculate(in.op, or_zero(top[0]), or_zero(top[1]), variables, *top);
        if (!done.ok()) return done;
        break;
      }
      default:
        if (!apply(in.op, or_zero(*top), steps, variables, *top))
          return Result::failed(Fault::macro_argument);
        break;
    }
    if (!std::isfinite(*top)) return Result::failed(Fault::macro_overflow);
  }
  value = *top;
  return {};
}

Result locate(const Place& place, Variables& variables, std::uint32_t& number) {
  number = place.how.number;
  if (place.how.op == Op::variable || place.how.op == Op::bit) return {};
  if (place.how.op == Op::named) {
    number = variables.named(place.name);
    return number == Variables::kNoVariable ? Result::failed(Fault::macro_no_name) : Result{};
  }
  double value = 0;
  const Result done = evaluate(place.index, variables, 1, value);
  if (!done.ok()) return done;
  if (place.how.op == Op::indirect) {
    return Variables::number_of(value, number) ? Result{} : Result::failed(Fault::macro_variable);
  }
  const double index = nearest(or_zero(value)) - (place.how.from_zero ? 0 : 1);
  if (!(index >= 0 && index < place.how.most)) return Result::failed(Fault::macro_subscript);
  number += static_cast<std::uint32_t>(index) * place.how.step;
  return {};
}

}  // namespace headstock::macro

// The functions of K2000TC macros (L20810-L21466), each in double and, with F behind its name, in single
// precision.
#include <algorithm>
#include <cmath>
#include <limits>

#include "macro/k2000-language/expression.hpp"

namespace headstock::k2000 {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegree = 3.14159265358979323846 / 180;

using Real = double (*)(double);
enum class Angle : std::uint8_t { none, takes, gives };

struct RealFunction {
  std::string_view name;
  Real work;
  Angle angle;
};

double of_sine(double x) {
  return std::fabs(x) > 1 ? kNan : std::asin(x);
}
double of_cosine(double x) {
  return std::fabs(x) > 1 ? kNan : std::acos(x);
}
double nearest(double x) {
  return std::round(x);
}

constexpr RealFunction kReal[] = {
    {"SQRT", [](double x) { return std::sqrt(x); }, Angle::none},
    {"FABS", [](double x) { return std::fabs(x); }, Angle::none},
    {"ROUND", nearest, Angle::none},
    {"FUP", [](double x) { return std::ceil(x); }, Angle::none},
    {"CEIL", [](double x) { return std::ceil(x); }, Angle::none},
    {"FIX", [](double x) { return std::floor(x); }, Angle::none},
    {"FLOOR", [](double x) { return std::floor(x); }, Angle::none},
    {"TRUNC", [](double x) { return std::trunc(x); }, Angle::none},
    {"LN", [](double x) { return std::log(x); }, Angle::none},
    {"LOG", [](double x) { return std::log(x); }, Angle::none},
    {"LOG2", [](double x) { return std::log2(x); }, Angle::none},
    {"LOG10", [](double x) { return std::log10(x); }, Angle::none},
    {"EXP", [](double x) { return std::exp(x); }, Angle::none},
    {"EXP2", [](double x) { return std::exp2(x); }, Angle::none},
    {"SIN", [](double x) { return std::sin(x); }, Angle::takes},
    {"COS", [](double x) { return std::cos(x); }, Angle::takes},
    {"TAN", [](double x) { return std::tan(x); }, Angle::takes},
    {"ASIN", of_sine, Angle::gives},
    {"ACOS", of_cosine, Angle::gives},
    {"ATAN", [](double x) { return std::atan(x); }, Angle::gives},
};

// C's pow but for one rule: ±1 to the power of ±INF is NAN (L21394, rule 9).
double power(double x, double y) {
  if (std::fabs(x) == 1 && std::isinf(y)) return kNan;
  if (x == 1 && std::isnan(y)) return kNan;
  return std::pow(x, y);
}

// 0, 90, 180 … degrees come out exactly, as people expect of a machine.
double of_degrees(Real work, double degrees) {
  const double turned = std::remainder(degrees, 360.0);
  return work(turned * kDegree);
}

Error bcd(bool to_bcd, const Value& value, Value& result) {
  if (value.is_null()) return Error::null_used;
  const double number = value.number();
  if (!(number >= 0 && number < 4294967296.0) || number != std::floor(number)) return Error::bad_argument;
  auto rest = static_cast<std::uint64_t>(number);
  std::uint64_t out = 0, scale = 1;
  const std::uint64_t from = to_bcd ? 10 : 16, to = to_bcd ? 16 : 10;
  for (; rest != 0; rest /= from, scale *= to) {
    if (rest % from > 9) return Error::bad_argument;
    out += rest % from * scale;
  }
  result = out <= 0xffff'ffffu ? Value::of_uint(out) : Value{Type::ulong, static_cast<std::int64_t>(out), 0};
  return Error::none;
}

int classify(double x) {
  switch (std::fpclassify(x)) {
    case FP_NAN:
      return 0;
    case FP_INFINITE:
      return 1;
    case FP_ZERO:
      return 2;
    case FP_SUBNORMAL:
      return 3;
    default:
      return 4;
  }
}

}  // namespace

bool Parser::function(std::string_view name, bool single, Value& value) {
  const auto give = [&](double result) {
    value = single ? Value::of_float(result) : Value::of_double(result);
    return true;
  };
  const auto argument = [&](const Value& written) {
    return single ? static_cast<double>(static_cast<float>(written.number())) : written.number();
  };
  for (const RealFunction& f : kReal) {
    if (f.name != name) continue;
    std::vector<Value> values;
    if (!arguments(values, 1)) return false;
    if (values[0].is_null()) return fail(Error::null_used);
    const double x = argument(values[0]);
    if (name == "ATAN") {
      const char* behind = at_;
      if (take('/')) {
        if (peek() == '[') {  // ATAN[j]/[k]: the angle of the point (k, j)
          Value other;
          if (!bracket(other)) return false;
          if (other.is_null()) return fail(Error::null_used);
          double angle = std::atan2(x, argument(other)) / kDegree;
          if (angle < 0 && !options_.signed_atan) angle += 360;
          return give(options_.degrees ? angle : angle * kDegree);
        }
        if (is_place()) return fail(Error::bad_argument);  // write [ATAN[j]]/#k (L21150)
        at_ = behind;
      }
    }
    if (f.angle == Angle::takes && options_.degrees) return give(of_degrees(f.work, x));
    const double result = f.work(x);
    return give(f.angle == Angle::gives && options_.degrees ? result / kDegree : result);
  }
  std::vector<Value> values;
  if (name == "POW") {
    if (!arguments(values, 2)) return false;
    if (values.size() != 2) return fail(Error::syntax);
    if (values[0].is_null() || values[1].is_null()) return fail(Error::null_used);
    return give(power(argument(values[0]), argument(values[1])));
  }
  if (name == "ABS") {  // integers only; the result has no sign (L21000)
    if (!arguments(values, 1)) return false;
    if (values[0].is_null()) return fail(Error::null_used);
    if (!values[0].is_whole()) return fail(Error::whole_needed);
    const Value& v = values[0];
    const bool negative = v.whole < 0 && v.type != Type::ulong;
    const auto bits = static_cast<std::uint64_t>(v.whole);
    value = {v.type >= Type::long_ ? Type::ulong : Type::uint,
             static_cast<std::int64_t>(negative ? 0 - bits : bits), 0};
    return true;
  }
  if (name == "BIN" || name == "BCD") {
    if (!arguments(values, 1)) return false;
    const Error error = bcd(name == "BCD", values[0], value);
    return error == Error::none || fail(error);
  }
  const bool classifies = name == "FPCLASSIFY" || name == "FINITE" || name == "ISINF" || name == "ISNAN";
  if (classifies) {
    if (!arguments(values, 1)) return false;
    if (values[0].is_null()) return fail(Error::null_used);
    const double x = argument(values[0]);
    const int result = name == "FPCLASSIFY" ? classify(x)
                       : name == "FINITE"   ? (std::isfinite(x) ? 1 : 0)
                       : name == "ISNAN"    ? (std::isnan(x) ? 1 : 0)
                       : std::isinf(x)      ? (x > 0 ? 1 : -1)
                                            : 0;
    value = Value::of_int(result);
    return true;
  }
  if (!single && name.size() > 1 && name.back() == 'F')
    return function(name.substr(0, name.size() - 1), true, value);
  return fail(Error::syntax);
}

}  // namespace headstock::k2000

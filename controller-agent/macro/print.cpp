#include "macro/print.hpp"

#include <cmath>
#include <cstdio>

namespace headstock::macro {
namespace {

double power_of_ten(unsigned exponent) {
  double power = 1;
  while (exponent-- > 0) power *= 10;
  return power;
}

void decimal(const PrintItem& item, double value, const PrintFormat& format, std::string& out) {
  const double scaled = std::floor(std::fabs(value) * power_of_ten(item.decimals) + 0.5);
  // More whole digits than the format has: the lowest ones are printed, as the manual's example does (L20235).
  const double kept = std::fmod(scaled, power_of_ten(item.whole_digits + item.decimals));
  char digits[32];
  std::snprintf(digits, sizeof digits, "%0*.0f", item.whole_digits + item.decimals, kept);
  std::string whole(digits, item.whole_digits);
  const std::string fraction(digits + item.whole_digits);
  std::size_t zeros = whole.find_first_not_of('0');
  if (zeros == std::string::npos) zeros = whole.empty() ? 0 : whole.size() - 1;
  if (value < 0 && scaled > 0) {
    out += '-';
  } else if (!format.plain) {
    out += ' ';
  }
  if (!format.plain) out.append(zeros, ' ');
  out += whole.substr(zeros);
  if (item.decimals > 0) out += '.' + fraction;
}

void word(const PrintItem& item, double value, std::string& out) {
  const double scaled = value * power_of_ten(item.decimals);
  const double whole = std::copysign(std::floor(std::fabs(scaled) + 0.5), scaled);
  const auto bits = static_cast<std::uint32_t>(static_cast<std::int64_t>(whole));
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(bits >> shift & 0xffu);
}

}  // namespace

Result print(const Statement& statement, Variables& variables, const PrintFormat& format, std::string& out) {
  std::string text;
  for (const PrintItem& item : statement.items) {
    text += item.text;
    if (!item.has_value) continue;
    double value = 0;
    const Result done = evaluate(item.value, variables, 1, value);
    if (!done.ok()) return done;
    value = or_zero(value);
    if (std::fabs(value) > 1e12) return Result::failed(Fault::macro_overflow);
    if (statement.kind == StatementKind::print_text) {
      decimal(item, value, format, text);
    } else {
      if (std::fabs(value) * power_of_ten(item.decimals) > 4294967295.0)
        return Result::failed(Fault::macro_overflow);
      word(item, value, text);
    }
  }
  text += format.cr_after_lf ? "\n\r" : "\n";
  out += text;
  return {};
}

}  // namespace headstock::macro

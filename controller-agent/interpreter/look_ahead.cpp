#include "interpreter/look_ahead.hpp"

#include <charconv>
#include <cmath>
#include <string>

#include "interpreter/executor.hpp"

namespace headstock::interp {

// M codes that parameters choose: at the start of a program, and after G10 L52.
void Executor::read_look_ahead_parameters() {
  const dialects::LookAheadRules& rules = dialect.look_ahead;
  const auto code_at = [this](std::string_view first, int n) {
    int number = 0;
    std::from_chars(first.data(), first.data() + first.size(), number);
    const double value = data.parameter(std::to_string(number + n));
    return std::fabs(value) < 1e8 ? static_cast<std::int32_t>(value) : 0;
  };
  look_ahead.held_m.clear();
  for (int n = 0; n < rules.held_m_count; ++n)
    if (const std::int32_t m = code_at(rules.held_m, n); m > 0) look_ahead.held_m.emplace_back(m, m);
  for (int n = 0; n + 1 < rules.held_m_range_count; n += 2) {
    const std::int32_t first = code_at(rules.held_m_ranges, n), last = code_at(rules.held_m_ranges, n + 1);
    if (first > 0 && last >= first) look_ahead.held_m.emplace_back(first, last);
  }
  const auto m_code = [this](std::string_view parameter) {
    const double value = parameter.empty() ? 0 : data.parameter(parameter);
    return value > 0 && value < 1e8 ? static_cast<std::int32_t>(value) : -1;
  };
  part_count_m = m_code(dialect.part_count_m_parameter);
  rigid_m = m_code(dialect.rigid_m_parameter);
  small_hole_m = data.bit(dialect.small_hole_parameter) ? m_code(dialect.small_hole_m_parameter) : -1;
}

}  // namespace headstock::interp

#include "operation/macro_environment.hpp"

#include <cmath>

namespace headstock::operation {
namespace {

constexpr std::uint32_t kQuestionsAPiece = 32;  // each about a thousand blocks: a few milliseconds
constexpr double kClockEnd_ms = 2147483648;
constexpr double kHour_ms = 3.6e6;

}  // namespace

bool MacroEnvironment::wants_pause() {
  if (waiting_.load(std::memory_order_relaxed) == 0 && ++asked_ < kQuestionsAPiece) return false;
  asked_ = 0;
  return true;
}

double MacroEnvironment::clock_ms() {
  const double now = static_cast<double>(realtime_.state().periods) * period_ms_;
  return std::fmod(now + clock_offset_ms_, kClockEnd_ms);
}

void MacroEnvironment::set_clock_ms(double value) {
  clock_offset_ms_ = value - static_cast<double>(realtime_.state().periods) * period_ms_;
}

double MacroEnvironment::running_hours() {
  return static_cast<double>(realtime_.state().run_periods) * period_ms_ / kHour_ms;
}

double MacroEnvironment::clock_hours() {
  return running_hours() + hours_offset_;
}

void MacroEnvironment::set_clock_hours(double value) {
  hours_offset_ = value - running_hours();
}

}  // namespace headstock::operation

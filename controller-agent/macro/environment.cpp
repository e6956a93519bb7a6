#include "macro/environment.hpp"

#include <ctime>

namespace headstock::macro {
namespace {

constexpr double kClockStep_ms = 16;         // its resolution (L15229)
constexpr double kClockEnd_ms = 2147483648;  // where it begins again (L15230)

std::tm now() {
  const std::time_t seconds = std::time(nullptr);
  std::tm local{};
  localtime_r(&seconds, &local);
  return local;
}

}  // namespace

double Environment::clock_ms() {
  const double shown = clock_ms_;
  clock_ms_ += kClockStep_ms;
  if (clock_ms_ >= kClockEnd_ms) clock_ms_ = 0;
  return shown;
}

std::uint32_t Environment::date() {
  const std::tm t = now();
  return static_cast<std::uint32_t>((t.tm_year + 1900) * 10'000 + (t.tm_mon + 1) * 100 + t.tm_mday);
}

std::uint32_t Environment::time() {
  const std::tm t = now();
  return static_cast<std::uint32_t>(t.tm_hour * 10'000 + t.tm_min * 100 + t.tm_sec);
}

}  // namespace headstock::macro

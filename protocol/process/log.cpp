#include "protocol/process/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace headstock::log {
namespace {

spdlog::level::level_enum level_of(Weight weight) {
  switch (weight) {
    case Weight::info:
      return spdlog::level::info;
    case Weight::warning:
      return spdlog::level::warn;
    case Weight::error:
      break;
  }
  return spdlog::level::err;
}

}  // namespace

void send_to(Target target) {
  spdlog::set_default_logger(target == Target::standard_error ? spdlog::stderr_logger_mt("headstock-errors")
                                                              : spdlog::stdout_color_mt("headstock"));
  spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%eZ %l %v", spdlog::pattern_time_type::utc);
}

void leave_out_below(const std::string& name) {
  spdlog::set_level(spdlog::level::from_str(name));
}

void write(Weight weight, fmt::string_view text, fmt::format_args values) noexcept {
  try {
    const auto level = level_of(weight);
    if (!spdlog::should_log(level)) return;
    const auto line = fmt::vformat(text, values);
    spdlog::default_logger_raw()->log(level, spdlog::string_view_t(line));
  } catch (...) {
    // Nobody is left to tell.
  }
}

}  // namespace headstock::log

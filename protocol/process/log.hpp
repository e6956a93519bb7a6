// What a process writes for the one who looks after it: a line a thing that happened, with its time and
// weight.
#pragma once

#include <fmt/core.h>

#include <string>
#include <string_view>

namespace headstock::log {

enum class Weight { info, warning, error };

/// Where lines go. A service manager keeps what stands on stderr.
enum class Target { standard_output, standard_error };

/// Sends lines to TARGET from now on, times in UTC. Call it before other threads log.
void send_to(Target target);
/// Leaves out what is lighter than this: "trace", "debug", "info", "warn", "error", "off".
void leave_out_below(const std::string& name);

/// Any thread. Never throws: a line that cannot be written is lost.
void write(Weight weight, fmt::string_view text, fmt::format_args values) noexcept;

// The text is checked against its values by the compiler; what formats them is compiled once, in the library.
template <class... Values>
void info(fmt::format_string<Values...> text, Values&&... values) {
  write(Weight::info, text, fmt::make_format_args(values...));
}
template <class... Values>
void warning(fmt::format_string<Values...> text, Values&&... values) {
  write(Weight::warning, text, fmt::make_format_args(values...));
}
template <class... Values>
void error(fmt::format_string<Values...> text, Values&&... values) {
  write(Weight::error, text, fmt::make_format_args(values...));
}

}  // namespace headstock::log

// System calls on a terminal device. Apart, because the kernel's own header (needed for speeds without a
// name) does not go together with the C library's.
#pragma once

#include <cstdint>
#include <string>

#include "protocol/serial/settings.hpp"

namespace headstock::serial::tty {

struct Opened {
  int fd = -1;
  std::string reason, text;  ///< of fd < 0
};
/// Opens for us alone, never waiting for a carrier, and sets the line; raw, errors marked (PARMRK).
Opened open(const std::string& device, const LineSettings& settings);
std::size_t queued(int fd);
void hold(int fd, bool on);
void discard(int fd);
void set_rts(int fd, bool on);
Signals signals(int fd);

/// Errors counted by the device since it was made; all 0 when it does not count.
struct ErrorCounts {
  bool known = false;
  std::uint32_t framing = 0, overrun = 0, parity = 0, breaks = 0;
};
ErrorCounts errors(int fd);

}  // namespace headstock::serial::tty

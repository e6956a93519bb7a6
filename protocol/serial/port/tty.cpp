#include "protocol/serial/port/tty.hpp"

#include <asm/ioctls.h>
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace headstock::serial::tty {
namespace {

constexpr tcflag_t kDataBits[] = {CS5, CS6, CS7, CS8};

termios2 raw(const LineSettings& settings) {
  termios2 line{};
  line.c_iflag = INPCK | PARMRK;
  line.c_cflag = CREAD | CLOCAL | HUPCL | BOTHER | kDataBits[settings.data_bits - 5];
  if (settings.stop_bits == 2) line.c_cflag |= CSTOPB;
  if (settings.parity != Parity::none) line.c_cflag |= PARENB;
  if (settings.parity == Parity::odd || settings.parity == Parity::mark) line.c_cflag |= PARODD;
  if (settings.parity == Parity::mark || settings.parity == Parity::space) line.c_cflag |= CMSPAR;
  if (settings.hardware()) line.c_cflag |= CRTSCTS;
  line.c_ispeed = line.c_ospeed = settings.baud;
  line.c_cc[VMIN] = 1;
  return line;
}

Opened failed(int fd, const char* reason, int error) {
  if (fd >= 0) ::close(fd);
  return {-1, reason, error == 0 ? std::string() : std::string(std::strerror(error))};
}

const char* reason_of(int error) {
  switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
    case EIO:
      return "port_not_found";
    case EBUSY:
      return "port_in_use";
    case EACCES:
    case EPERM:
      return "port_forbidden";
    default:
      return "port_failed";
  }
}

}  // namespace

Opened open(const std::string& device, const LineSettings& settings) {
  const int fd = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return failed(-1, reason_of(errno), errno);
  termios2 before{};
  if (::ioctl(fd, TCGETS2, &before) != 0) return failed(fd, "not_a_serial_port", errno);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) return failed(fd, "port_in_use", errno);
  ::ioctl(fd, TIOCEXCL);
  const termios2 wanted = raw(settings);
  if (::ioctl(fd, TCSETS2, &wanted) != 0) return failed(fd, "bad_settings", errno);
  termios2 is{};
  // A device sets the nearest speed it can: more than 2 % off is another speed.
  const bool read = ::ioctl(fd, TCGETS2, &is) == 0;
  const double off = read ? static_cast<double>(is.c_ospeed) / settings.baud - 1.0 : 1.0;
  if (off > 0.02 || off < -0.02) return failed(fd, "bad_baud", 0);
  ::ioctl(fd, TCFLSH, TCIOFLUSH);
  return {fd, {}, {}};
}

std::size_t queued(int fd) {
  int count = 0;
  return ::ioctl(fd, TIOCOUTQ, &count) == 0 && count > 0 ? static_cast<std::size_t>(count) : 0;
}

void hold(int fd, bool on) {
  ::ioctl(fd, TCXONC, on ? TCOOFF : TCOON);
}
void discard(int fd) {
  ::ioctl(fd, TCFLSH, TCOFLUSH);
}

void set_rts(int fd, bool on) {
  const int bit = TIOCM_RTS;
  ::ioctl(fd, on ? TIOCMBIS : TIOCMBIC, &bit);
}

Signals signals(int fd) {
  int bits = 0;
  if (::ioctl(fd, TIOCMGET, &bits) != 0) return {};
  Signals signals;
  signals.known = true;
  signals.rts = bits & TIOCM_RTS;
  signals.dtr = bits & TIOCM_DTR;
  signals.cts = bits & TIOCM_CTS;
  signals.dsr = bits & TIOCM_DSR;
  signals.dcd = bits & TIOCM_CD;
  signals.ring = bits & TIOCM_RI;
  return signals;
}

ErrorCounts errors(int fd) {
  serial_icounter_struct counts{};
  if (::ioctl(fd, TIOCGICOUNT, &counts) != 0) return {};
  const auto number = [](int count) { return static_cast<std::uint32_t>(count); };
  return {true, number(counts.frame), number(counts.overrun) + number(counts.buf_overrun),
          number(counts.parity), number(counts.brk)};
}

}  // namespace headstock::serial::tty

// A place where a serial line can be reached: a local device, a TCP socket, an RFC 2217 serial-device server.
// Nothing waits; everything on the thread of the executor.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/serial/faults.hpp"
#include "protocol/serial/settings.hpp"

namespace headstock::serial {

struct PortAddress {
  enum Kind { tty, tcp, rfc2217 };
  Kind kind = tty;
  std::string device;  ///< of tty: /dev/ttyS0
  std::string host;    ///< of the others
  std::uint16_t port = 0;
};
/// Reads "/dev/ttyS0", "tcp://HOST:PORT", "rfc2217://HOST:PORT" ([v6] in brackets). @return nothing when it
/// is none. A device is an absolute path without "..".
std::optional<PortAddress> address_of(std::string_view text);
std::string to_text(const PortAddress& address);

/// Told by a port. After closed() nothing more comes.
class PortListener {
 public:
  virtual ~PortListener() = default;
  virtual void on_open() = 0;
  virtual void on_bytes(std::string_view bytes) = 0;
  virtual void on_fault(Fault fault) = 0;
  virtual void on_signals(const Signals& signals) = 0;
  virtual void on_writable() = 0;
  /// @param reason message key: port_not_found, port_in_use, port_forbidden, bad_baud, not_a_serial_port,
  /// connect_failed, connect_timeout, no_rfc2217, disconnected …  @param text what the system says.
  virtual void on_closed(const std::string& reason, const std::string& text) = 0;
};

class Port {
 public:
  virtual ~Port() = default;
  virtual void open(PortListener& listener) = 0;
  /// Hands over as many bytes as the device takes now; on_writable() comes when it takes more after less.
  virtual std::size_t write(std::string_view bytes) = 0;
  /// Bytes handed over that the device says it still has; 0 when it does not say.
  virtual std::size_t queued() const = 0;
  /// Stops the device's own queue at once (as far as it can), or lets it go on.
  virtual void hold_output(bool hold) = 0;
  virtual void discard_output() = 0;
  virtual void set_rts(bool on) = 0;
  virtual Signals signals() = 0;
  /// Discards what is queued and closes; no listener call comes of it.
  virtual void close() = 0;
};

std::unique_ptr<Port> make_port(const boost::asio::any_io_executor& executor, const PortAddress& address,
                                const LineSettings& settings);

}  // namespace headstock::serial

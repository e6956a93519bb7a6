// Telnet with the COM-PORT-OPTION of RFC 2217, the client's side, without a socket: data are escaped, line
// settings asked for, what the serial-device server reports (signals, line errors, whether it took the
// settings) comes out as events. One thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/serial/faults.hpp"
#include "protocol/serial/settings.hpp"

namespace headstock::serial {

class Rfc2217 {
 public:
  struct Events {
    std::string data;
    std::vector<Fault> faults;
    bool signals_changed = false;
    bool ready = false;   ///< all settings have been confirmed just now
    std::string refused;  ///< what the server does not do: "no_rfc2217", "bad_baud", "bad_data_bits", …
  };

  explicit Rfc2217(const LineSettings& settings) : settings_(settings) {}
  /// What a client says first.
  std::string hello();
  /// Takes what came; `answer` is to be written.
  Events put(std::string_view bytes, std::string& answer);
  /// Data as they go over the connection (FF doubled).
  static std::string escaped(std::string_view data);
  std::string set_rts(bool on) const;
  std::string set_dtr(bool on) const;
  /// Throws away what the server still has to send.
  std::string discard_output() const;
  const Signals& signals() const { return signals_; }
  bool ready() const { return ready_; }
  /// The server's own queue is full: nothing more until it says so.
  bool suspended() const { return suspended_; }

 private:
  void command(std::uint8_t verb, std::uint8_t option, Events& events, std::string& answer);
  void subnegotiation(Events& events, std::string& answer);
  std::string ask_settings() const;
  void confirmed(std::uint8_t setting, Events& events);

  LineSettings settings_;
  enum class At { data, iac, verb, sub, sub_iac } state_ = At::data;
  std::uint8_t verb_ = 0;
  std::string sub_;
  Signals signals_;
  bool asked_ = false, ready_ = false, suspended_ = false;
  unsigned confirmed_ = 0;
};

}  // namespace headstock::serial

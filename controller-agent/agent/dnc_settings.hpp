// How a machine is fed by somebody else's DNC software over its own line, as its agent is told it:
//
//   --dnc /dev/ttyS0,line=4800-7-E-2-software,code=iso
//   --dnc listen://192.168.1.20:4001,line=9600-8-N-1-hardware
//
// First the port: a device, tcp://HOST:PORT or rfc2217://HOST:PORT (the agent connects),
// listen://ADDRESS:PORT (the DNC software connects; one at a time). Then, as far as they differ:
//   line=BAUD-BITS-PARITY-STOP-HANDSHAKE   software: DC1 and DC3. hardware: RTS, and on listen:// TCP's own
//   code=ascii|iso|eia                     iso (even parity in bit 8)
//   buffer=CHARACTERS                      1,024…1,048,576
//   after-stop=CHARACTERS                  taken after a DC3, then the overflow alarm (PS0087). FANUC: 10
//   tv-check                               blocks of an odd number of characters are an alarm (PS0002)
//   any-start                              without a % at the beginning, too. Then whoever restarts the
//   machine must
//                                          restart the sender as well
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/serial/port/port.hpp"
#include "protocol/serial/settings.hpp"
#include "protocol/tape/code.hpp"

namespace headstock::agent {

struct DncSettings {
  std::string port;                            ///< as written; shown to people
  std::optional<serial::PortAddress> address;  ///< none: listens
  std::string listen_address;
  std::uint16_t listen_port = 0;  ///< 0: any free one (tests)
  serial::LineSettings line;
  tape::Code code = tape::Code::iso;
  std::size_t buffer = 65'536;
  /// More than the 10 of the manual: what operating systems and USB adapters have under way is not the
  /// sender's fault.
  std::size_t after_stop = 8'192;
  bool tv_check = false;
  bool any_start = false;
};

/// @return what is wrong with the text, for the person who wrote it; empty when it was read.
std::string read_dnc_settings(std::string_view text, DncSettings& settings);

}  // namespace headstock::agent

// A TCP port on which somebody else's DNC software connects to this machine, as a serial line: one peer at a
// time, every other is turned away.
//
// set_rts(false) is TCP's own handshake: nothing is read any more, and the peer's writes stop.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "protocol/serial/port/port.hpp"

namespace headstock::agent {

/// Opening says at once whether the address can be had; a peer that goes is Fault::disconnected, and the next
/// may come.
std::unique_ptr<serial::Port> make_listening_port(const boost::asio::any_io_executor& executor,
                                                  std::string address, std::uint16_t port);

}  // namespace headstock::agent

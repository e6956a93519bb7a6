// The kinds of ports. Private to port/.
#pragma once

#include <memory>
#include <string>

#include "protocol/serial/port/port.hpp"

namespace headstock::serial {

std::unique_ptr<Port> make_tty_port(const boost::asio::any_io_executor& executor, std::string device,
                                    const LineSettings& settings);
std::unique_ptr<Port> make_tcp_port(const boost::asio::any_io_executor& executor, std::string host,
                                    std::uint16_t port);
std::unique_ptr<Port> make_rfc2217_port(const boost::asio::any_io_executor& executor, std::string host,
                                        std::uint16_t port, const LineSettings& settings);

}  // namespace headstock::serial

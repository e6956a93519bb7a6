#include <charconv>

#include "protocol/serial/port/port.hpp"
#include "protocol/serial/port/ports.hpp"

namespace headstock::serial {
namespace {

constexpr std::string_view kTcp = "tcp://", kRfc2217 = "rfc2217://";

bool read_host(std::string_view text, PortAddress& address) {
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  auto host = text.substr(0, colon);
  const auto digits = text.substr(colon + 1);
  if (host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return false;
  }
  unsigned number = 0;
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || stop != digits.data() + digits.size() || number == 0 || number > 65'535)
    return false;
  if (host.empty() || host.size() > 255) return false;
  for (const char c : host)
    if (c <= ' ' || c == '/' || c == '@' || c == '\x7F') return false;
  address.host = host;
  address.port = static_cast<std::uint16_t>(number);
  return true;
}

}  // namespace

std::optional<PortAddress> address_of(std::string_view text) {
  PortAddress address;
  if (text.starts_with(kTcp)) {
    address.kind = PortAddress::tcp;
    return read_host(text.substr(kTcp.size()), address) ? std::optional(address) : std::nullopt;
  }
  if (text.starts_with(kRfc2217)) {
    address.kind = PortAddress::rfc2217;
    return read_host(text.substr(kRfc2217.size()), address) ? std::optional(address) : std::nullopt;
  }
  if (!text.starts_with('/') || text.size() > 255 || text.find("..") != std::string_view::npos ||
      text.find('\0') != std::string_view::npos)
    return std::nullopt;
  address.device = text;
  return address;
}

std::string to_text(const PortAddress& address) {
  if (address.kind == PortAddress::tty) return address.device;
  const bool six = address.host.find(':') != std::string::npos;
  std::string text(address.kind == PortAddress::tcp ? kTcp : kRfc2217);
  if (six) text += '[';
  text += address.host;
  if (six) text += ']';
  text += ':';
  return text += std::to_string(address.port);
}

std::unique_ptr<Port> make_port(const boost::asio::any_io_executor& executor, const PortAddress& address,
                                const LineSettings& settings) {
  switch (address.kind) {
    case PortAddress::tty:
      return make_tty_port(executor, address.device, settings);
    case PortAddress::tcp:
      return make_tcp_port(executor, address.host, address.port);
    case PortAddress::rfc2217:
      return make_rfc2217_port(executor, address.host, address.port, settings);
  }
  return nullptr;
}

}  // namespace headstock::serial

#include "server/app/web_tls.hpp"

#include <array>

#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/host_name.hpp>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>

#include "protocol/wire/certificates.hpp"
#include "server/app/shop.hpp"

namespace headstock::app {

namespace ssl = boost::asio::ssl;

namespace {

std::unique_ptr<ssl::context> empty_context() {
  auto context = std::make_unique<ssl::context>(ssl::context::tls_server);
  context->set_options(ssl::context::default_workarounds | ssl::context::no_sslv2 | ssl::context::no_sslv3 |
                       ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1);
  return context;
}

}  // namespace

std::unique_ptr<ssl::context> tls_from_files(const std::filesystem::path& certificate, const std::filesystem::path& key) {
  auto context = empty_context();
  boost::system::error_code error;
  context->use_certificate_chain_file(certificate.string(), error);
  if (error) throw StartError(StartError::tls, "cannot use the certificate " + certificate.string() + ": " + error.message());
  context->use_private_key_file(key.string(), ssl::context::pem, error);
  if (error) throw StartError(StartError::tls, "cannot use the key " + key.string() + ": " + error.message());
  return context;
}

std::unique_ptr<ssl::context> tls_from_pki(const std::filesystem::path& pki_folder,
                                           const std::vector<std::string>& host_names) {
  try {
    const wire::Authority authority(pki_folder, host_names);
    auto context = empty_context();
    const auto chain = authority.server_pem() + authority.ca_pem();
    context->use_certificate_chain(boost::asio::buffer(chain));
    context->use_private_key(boost::asio::buffer(authority.server_key_pem()), ssl::context::pem);
    return context;
  } catch (const std::exception& error) {
    throw StartError(StartError::tls, std::string("cannot make a certificate: ") + error.what());
  }
}

std::vector<std::string> own_names(const std::string& address) {
  std::vector<std::string> names = {"localhost", "127.0.0.1", "::1"};
  const auto add = [&names](const std::string& name) {
    for (const auto& known : names)
      if (known == name) return;
    names.push_back(name);
  };
  boost::system::error_code ignored;
  const auto host = boost::asio::ip::host_name(ignored);
  if (!host.empty()) add(host);
  const auto asked = boost::asio::ip::make_address(address, ignored);
  if (!ignored && !asked.is_unspecified()) add(address);
  ifaddrs* first = nullptr;
  if (::getifaddrs(&first) != 0) return names;
  for (auto* at = first; at; at = at->ifa_next) {
    if (!at->ifa_addr || (at->ifa_flags & IFF_UP) == 0) continue;
    std::array<char, INET6_ADDRSTRLEN> text{};
    const void* raw = nullptr;
    if (at->ifa_addr->sa_family == AF_INET) raw = &reinterpret_cast<sockaddr_in*>(at->ifa_addr)->sin_addr;
    if (at->ifa_addr->sa_family == AF_INET6) raw = &reinterpret_cast<sockaddr_in6*>(at->ifa_addr)->sin6_addr;
    if (raw && ::inet_ntop(at->ifa_addr->sa_family, raw, text.data(), text.size())) add(text.data());
  }
  ::freeifaddrs(first);
  return names;
}

}  // namespace headstock::app

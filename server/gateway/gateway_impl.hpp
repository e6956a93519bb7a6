// The inside of the gateway, shared by its files: connections in gateway.cpp, programs on their way in
// gateway_transfers.cpp. Network thread.
#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "protocol/wire/certificates.hpp"
#include "protocol/wire/tls.hpp"
#include "server/gateway/agent_session.hpp"
#include "server/gateway/gateway.hpp"
#include "server/gateway/outgoing_transfer.hpp"

namespace headstock::server {

/// Failures of the link are answers here, not exceptions.
inline constexpr auto kAsTuple = boost::asio::as_tuple(boost::asio::use_awaitable);

struct Gateway::Impl final : SessionOwner, std::enable_shared_from_this<Impl> {
  Impl(boost::asio::io_context& context, GatewayOptions given, GatewayHost& the_host)
      : io(context),
        settings(std::move(given)),
        host_(the_host),
        authority(settings.pki_folder, settings.host_names),
        tls(wire::server_context(authority)),
        acceptor(context),
        renewal(context) {}

  boost::asio::io_context& io;
  GatewayOptions settings;
  GatewayHost& host_;
  wire::Authority authority;
  boost::asio::ssl::context tls;
  boost::asio::ip::tcp::acceptor acceptor;
  boost::asio::steady_timer renewal;
  bool stopped_ = false, leaving = false;
  std::size_t connections = 0;
  std::set<std::shared_ptr<AgentSession>> sessions;
  std::map<std::int64_t, std::shared_ptr<AgentSession>> machines;
  std::map<std::uint64_t, std::shared_ptr<OutgoingTransfer>> transfers;
  std::map<std::int64_t, std::shared_ptr<wire::Signal>> put_turns;
  std::set<std::int64_t> putting;

  void listen();
  boost::asio::awaitable<void> accept_loop();
  boost::asio::awaitable<void> renewal_loop();
  boost::asio::awaitable<void> serve(std::shared_ptr<AgentSession> session);
  std::shared_ptr<OutgoingTransfer> add_transfer(std::uint64_t id, std::int64_t machine, const char* kind,
                                                 std::string name, std::string sha256,
                                                 std::shared_ptr<BlobReader> content);
  boost::asio::awaitable<void> put_turn(std::int64_t machine);
  boost::asio::awaitable<TransferState> put(std::uint64_t id, std::int64_t machine, std::string name,
                                            std::string sha256, std::shared_ptr<BlobReader> content);
  void stop();

  // ---- SessionOwner
  bool stopped() const override { return stopped_; }
  GatewayHost& host() override { return host_; }
  const GatewayOptions& options() const override { return settings; }
  wire::IssuedCertificate sign(const std::string& request, std::int64_t machine) override {
    return authority.sign(request, machine);
  }
  const std::string& ca_pem() const override { return authority.ca_pem(); }
  std::shared_ptr<AgentSession> session_of(std::int64_t machine) override {
    const auto found = machines.find(machine);
    return found != machines.end() && found->second->open() ? found->second : nullptr;
  }
  void greeted(const std::shared_ptr<AgentSession>& session, const wire::Hello& hello) override;
  void gone(const std::shared_ptr<AgentSession>& session) override;
  void on_credit(AgentSession& session, const wire::Frame& frame, const wire::Credit& credit) override;
  void on_result(AgentSession& session, const wire::TransferResult& result) override;
};

}  // namespace headstock::server

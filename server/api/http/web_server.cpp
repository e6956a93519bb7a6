#include "server/api/http/web_server.hpp"

#include <list>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

#include "protocol/process/log.hpp"
#include "server/api/http/connection.hpp"

namespace headstock::api {

namespace asio = boost::asio;
using asio::ip::tcp;

struct WebServer::Impl : std::enable_shared_from_this<WebServer::Impl> {
  Impl(asio::io_context& context, WebServerOptions given, const Router& table, WebHost calls)
      : io(context), options(std::move(given)), acceptor(io), shared{table, std::move(calls), options.limits} {}

  asio::io_context& io;
  WebServerOptions options;
  tcp::acceptor acceptor;
  Shared shared;

  asio::awaitable<void> accept();
};

WebServer::WebServer(asio::io_context& io, WebServerOptions options, const Router& router, WebHost host)
    : impl_(std::make_shared<Impl>(io, std::move(options), router, std::move(host))) {}

WebServer::~WebServer() = default;

void WebServer::start() {
  auto& impl = *impl_;
  const auto where = impl.options.address + ":" + std::to_string(impl.options.port);
  boost::system::error_code error;
  const auto address = asio::ip::make_address(impl.options.address, error);
  if (error) throw std::runtime_error("'" + impl.options.address + "' is not an address of this computer; give an IP address");
  const tcp::endpoint endpoint(address, impl.options.port);
  impl.acceptor.open(endpoint.protocol(), error);
  if (!error) impl.acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) impl.acceptor.bind(endpoint, error);
  if (!error) impl.acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error == asio::error::address_in_use)
    throw std::runtime_error("port in use: another program already listens on " + where + "; stop it or choose another port");
  if (error) throw std::runtime_error("cannot listen on " + where + ": " + error.message());
  asio::co_spawn(impl.io, impl.accept(), asio::detached);
}

std::uint16_t WebServer::port() const { return impl_->acceptor.local_endpoint().port(); }

std::size_t WebServer::connections() const { return impl_->shared.connections.size(); }

asio::awaitable<void> WebServer::Impl::accept() {
  const auto self = shared_from_this();
  while (acceptor.is_open()) {
    tcp::socket socket(io);
    const auto [error] = co_await acceptor.async_accept(socket, asio::as_tuple(asio::use_awaitable));
    if (error == asio::error::operation_aborted || !acceptor.is_open()) co_return;
    if (error) {
      // Out of file descriptors and the like: the ones in use come free again.
      log::warning("cannot take a connection: {}", error.message());
      asio::steady_timer pause(io, std::chrono::milliseconds(200));
      co_await pause.async_wait(asio::as_tuple(asio::use_awaitable));
      continue;
    }
    boost::system::error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    const auto keeper = std::shared_ptr<Shared>(self, &self->shared);
    if (shared.connections.size() >= options.limits.connections && !options.tls) {
      asio::co_spawn(io, turn_away(std::move(socket), keeper), asio::detached);
    } else if (shared.connections.size() < options.limits.connections) {
      if (options.tls)
        asio::co_spawn(io, serve_tls(std::move(socket), *options.tls, keeper), asio::detached);
      else
        asio::co_spawn(io, serve_plain(std::move(socket), keeper), asio::detached);
    }
  }
}

asio::awaitable<void> WebServer::stop(std::chrono::milliseconds grace) {
  const auto impl = impl_;
  boost::system::error_code ignored;
  impl->acceptor.close(ignored);
  impl->shared.stopping = true;
  asio::steady_timer emptied(impl->io, grace);
  impl->shared.emptied = [&emptied] { emptied.cancel(); };
  for (auto& connection : impl->shared.connections)
    if (connection.idle) connection.cut();
  if (!impl->shared.connections.empty()) co_await emptied.async_wait(asio::as_tuple(asio::use_awaitable));
  emptied.expires_after(std::chrono::seconds(1));
  for (auto& connection : impl->shared.connections) connection.cut();
  if (!impl->shared.connections.empty()) co_await emptied.async_wait(asio::as_tuple(asio::use_awaitable));
  impl->shared.emptied = nullptr;
}

}  // namespace headstock::api

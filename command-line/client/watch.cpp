// Live events of a server: a WebSocket beside the requests of connection.cpp.

#include <optional>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "command-line/client/answer.hpp"
#include "protocol/stream/web_socket.hpp"

namespace headstock::client {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace ssl = asio::ssl;
using asio::awaitable;
using asio::use_awaitable;
using asio::ip::tcp;
using protocol::ByteStream;
using protocol::WebSocket;

awaitable<void> connect(beast::tcp_stream& stream, const std::string& host, const std::string& port) {
  tcp::resolver resolver(co_await asio::this_coro::executor);
  const auto found = co_await resolver.async_resolve(host, port, use_awaitable);
  stream.expires_after(std::chrono::seconds(kConnectS));
  co_await stream.async_connect(found, use_awaitable);
}

ssl::context tls_context(const std::filesystem::path& ca) {
  ssl::context context(ssl::context::tls_client);
  context.set_default_verify_paths();
  if (!ca.empty()) {
    boost::system::error_code error;
    context.load_verify_file(ca.string(), error);
    if (error) throw bad_certificate_file(ca.string(), error.message());
  }
  context.set_verify_mode(ssl::verify_peer);
  return context;
}

awaitable<void> follow(WebSocket& socket, const std::string& host, const std::string& token, const json& subscription,
                       const std::function<bool(const json&)>& message) {
  const auto refused = co_await socket.ask_for(host, "/api/v1/events", token);
  if (refused.status != 0) demand_success(refused.status, refused.body);
  if (refused.error) throw boost::system::system_error(refused.error);
  std::string text = subscription.dump();
  if (const auto error = co_await socket.send(text)) throw boost::system::system_error(error);
  for (;;) {
    if (const auto error = co_await socket.receive(text)) throw boost::system::system_error(error);
    const auto value = json::parse(text, nullptr, false);
    if (value.is_object() && !message(value)) break;
  }
  co_await socket.close();
}

}  // namespace

void Connection::watch(const json& subscription, const std::function<bool(const json&)>& message) {
  asio::io_context io;
  std::exception_ptr failed;
  const auto work = [&]() -> awaitable<void> {
    std::optional<ssl::context> context;
    if (secure_) context = tls_context(server_.ca);
    ByteStream stream(tcp::socket(io), context ? &*context : nullptr);
    stream.demand_host(host_);
    co_await connect(stream.lowest(), host_, port_);
    if (const auto error = co_await stream.handshake(ssl::stream_base::client)) throw not_trusted(error.message());
    WebSocket socket(std::move(stream));
    const std::string host = host_ + ":" + port_;
    co_await follow(socket, host, server_.token, subscription, message);
  };
  asio::co_spawn(io, work(), [&](std::exception_ptr error) { failed = error; });
  io.run();
  if (!failed) return;
  try {
    std::rethrow_exception(failed);
  } catch (const boost::system::system_error& error) {
    throw cannot_connect(server_.url, error.code().message());
  }
}

}  // namespace headstock::client

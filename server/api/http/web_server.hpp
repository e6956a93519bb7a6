// HTTP/1.1 and WebSocket over TCP or TLS: reads requests within bounds, finds the route, checks who asks, calls the
// handler and sends its reply. Knows nothing of machines or programs. Everything runs on the io_context's one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>

#include "server/api/http/router.hpp"
#include "server/api/http/session_cookie.hpp"

namespace headstock::api {

/// Bounds of one server. A client that passes one is refused with the status in brackets, or cut off.
struct Limits {
  std::size_t connections = 512;                   ///< (503)
  std::size_t header_bytes = 16 * 1024;            ///< (431)
  std::size_t json_bytes = 1024 * 1024;            ///< (413)
  std::uint64_t upload_bytes = 2ull << 30;         ///< (413)
  std::size_t socket_message_bytes = 64 * 1024;    ///< from a WebSocket client
  std::chrono::seconds header_time{20};            ///< for a whole header, and between requests of one connection
  std::chrono::seconds body_time{30};              ///< for the next 64 KiB of a body, either way
};

struct WebServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 8080;                       ///< 0: any free port; see port()
  boost::asio::ssl::context* tls = nullptr;        ///< nullptr: plain HTTP; outlives the server
  Limits limits;
};

/// One WebSocket client as the hub sees it: text messages out, one at a time.
class SocketClient {
 public:
  virtual ~SocketClient() = default;
  /// @return false when the client has gone.
  virtual boost::asio::awaitable<bool> send(std::shared_ptr<const std::string> message) = 0;
  /// The next message of the client; nothing when it has gone.
  virtual boost::asio::awaitable<std::optional<std::string>> receive() = 0;
  /// Ends it at once, whatever is under way; safe to call again.
  virtual void cut() = 0;
};

/// What the server asks of the rest.
struct WebHost {
  /// Who has this token? Role `none` when it is not valid (any more).
  std::function<boost::asio::awaitable<Principal>(std::string token)> authenticate;
  /// Of routes that name machines (names_machines): which. Empty: none, only shop-wide rights count.
  std::function<boost::asio::awaitable<std::vector<std::int64_t>>(const Route&, const Call&)> machines{};
  /// Who had this token when it was last looked up, a few minutes ago at most; may be missing. For urgent routes.
  std::function<std::optional<Principal>(const std::string& token)> known{};
  /// Serves one WebSocket client until it goes or the server stops; may send while it receives.
  std::function<boost::asio::awaitable<void>(std::shared_ptr<SocketClient>, Principal)> web_socket;
  /// Files of the browser application (paths outside /api).
  std::function<Reply(const Request&)> file;
};

class WebServer {
 public:
  WebServer(boost::asio::io_context& io, WebServerOptions options, const Router& router, WebHost host);
  ~WebServer();

  /// Throws std::runtime_error with a line for the person who starts it (port in use, bad address).
  void start();
  std::uint16_t port() const;
  /// Takes no more connections, lets requests under way finish for at most `grace`, then cuts off what is left.
  boost::asio::awaitable<void> stop(std::chrono::milliseconds grace);
  std::size_t connections() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;   // connections under way keep it
};

/// The value of `name` in a Cookie header; empty when absent.
std::string cookie_value(const std::string& cookie_header, const std::string& name);
/// Splits a request's target into path and query, percent-decoded. @return false when malformed or with a NUL.
bool split_target(std::string_view target, std::string& path, std::map<std::string, std::string>& query);

}  // namespace headstock::api

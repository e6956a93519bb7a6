// One client's connection, from its first byte to its last: the part that knows Beast.
#pragma once

#include <functional>
#include <list>
#include <memory>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>

#include "server/api/http/web_server.hpp"

namespace headstock::api {

/// A connection in the server's list, so that stopping can reach it.
struct Connected {
  bool idle = true;               ///< between two requests, or a WebSocket: nothing is lost by cutting it
  std::function<void()> cut{};
};

/// What all connections of one server share.
struct Shared {
  const Router& router;
  WebHost host;
  Limits limits;
  std::list<Connected> connections{};
  bool stopping = false;
  std::function<void()> emptied{};  ///< called when the last connection has gone
};

boost::asio::awaitable<void> serve_plain(boost::asio::ip::tcp::socket socket, std::shared_ptr<Shared> shared);
boost::asio::awaitable<void> serve_tls(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context& tls,
                                       std::shared_ptr<Shared> shared);
/// Above the limit of connections: says 503 and closes.
boost::asio::awaitable<void> turn_away(boost::asio::ip::tcp::socket socket, std::shared_ptr<Shared> shared);

}  // namespace headstock::api

// From a parsed header to a reply: the part of serving a request that does not depend on the kind of stream.
#pragma once

#include <optional>

#include "server/api/http/web_server.hpp"

namespace headstock::api {

struct Dispatched {
  Reply reply;
  std::optional<Principal> socket_for;   ///< set: no reply yet, the client may become a WebSocket
};

/// A body whose limit depends on the route.
class BoundedBody : public Body {
 public:
  std::uint64_t limit = 0;               ///< bytes; more is Refused("too_large")
};

/// Never throws: whatever a handler throws becomes a reply.
boost::asio::awaitable<Dispatched> dispatch(const Router& router, const WebHost& host, const Limits& limits,
                                            Request request, BoundedBody& body);

/// Headers every reply carries against sniffing, framing and foreign scripts.
void add_security_headers(Reply& reply);

}  // namespace headstock::api

// Serves one WebSocket client: reads its wishes, sends what becomes due, ends it when it stops reading.
#pragma once

#include <memory>

#include "server/api/http/web_server.hpp"
#include "server/api/services.hpp"

namespace headstock::api {

/// Runs until the client goes, stops reading for 30 s, or its session ends (looked at every 15 s).
boost::asio::awaitable<void> serve_events(Services& services,
                                          std::function<boost::asio::awaitable<Principal>(std::string)> authenticate,
                                          std::shared_ptr<SocketClient> client, Principal who);

}  // namespace headstock::api

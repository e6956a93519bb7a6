// What a page that is behind has not taken waits where newer states replace it, not in the buffers of the
// connection: else a slow tablet shows values of many seconds ago, and so every machine as unknown.
#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http/fields.hpp>
#include <string>

#include "protocol/stream/web_socket.hpp"

namespace headstock::api {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using asio::ip::tcp;

TEST(SlowReader, LittleIsUnderWayToWhoDoesNotRead) {
  asio::io_context io;
  tcp::acceptor acceptor(io, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  tcp::socket tablet(io), accepted(io);
  tablet.connect(acceptor.local_endpoint());
  acceptor.accept(accepted);
  http::request_header<> request;
  request.version(11);
  request.method(http::verb::get);
  request.target("/api/v1/events");
  request.set(http::field::host, "server");
  request.set(http::field::connection, "upgrade");
  request.set(http::field::upgrade, "websocket");
  request.set(http::field::sec_websocket_version, "13");
  request.set(http::field::sec_websocket_key, "AAAAAAAAAAAAAAAAAAAAAA==");
  ASSERT_TRUE(protocol::WebSocket::asked_for(request));

  protocol::WebSocket socket(protocol::ByteStream(std::move(accepted), nullptr));
  std::size_t sent = 0;
  const std::string state(4'000, 'x');
  asio::co_spawn(
      io,
      [&]() -> asio::awaitable<void> {
        if (co_await socket.accept(request, 1'000)) co_return;
        while (sent < 30'000'000 && !co_await socket.send(state)) sent += state.size();
      },
      [](std::exception_ptr) {});
  for (int idle = 0; idle < 1'000;) idle = io.poll() == 0 ? idle + 1 : 0;
  EXPECT_GT(sent, 0);
  // Both ends' buffers; a shop of 60 machines sends some 600 kB a second.
  EXPECT_LT(sent, 1'500'000);
  socket.cut();
  io.restart();
  io.run();
}

}  // namespace
}  // namespace headstock::api

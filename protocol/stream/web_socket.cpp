#include "protocol/stream/web_socket.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>

namespace headstock::protocol {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::awaitable;

namespace {
constexpr auto outcome = asio::as_tuple(asio::use_awaitable);
constexpr std::chrono::seconds kGreeting{10}, kSilence{30};
// The system would take 4 MB of what nobody reads: ten seconds of a shop's states, and a page that shows them as old.
constexpr int kSendBuffer = 64 * 1024;
}  // namespace

struct WebSocket::Kind {
  explicit Kind(ByteStream&& stream) : socket(std::move(stream)) {
    socket.next_layer().lowest().expires_never();  // the WebSocket has its own limits
    socket.text(true);
  }
  websocket::stream<ByteStream> socket;
};

WebSocket::WebSocket(ByteStream&& stream) : kind_(std::make_unique<Kind>(std::move(stream))) {}
WebSocket::~WebSocket() = default;

bool WebSocket::asked_for(const http::request_header<>& request) {
  return websocket::is_upgrade(http::request<http::empty_body>(request));
}

awaitable<boost::system::error_code> WebSocket::accept(const http::request_header<>& request,
                                                       std::size_t longest_message) {
  websocket::stream_base::timeout limits{};
  limits.handshake_timeout = kGreeting;
  limits.idle_timeout = kSilence;
  limits.keep_alive_pings = true;
  kind_->socket.set_option(limits);
  kind_->socket.read_message_max(longest_message);
  boost::system::error_code ignored;  // a connection that is gone already says so below
  kind_->socket.next_layer().lowest().socket().set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
  const http::request<http::empty_body> asked(request);
  const auto [error] = co_await kind_->socket.async_accept(asked, outcome);
  co_return error;
}

awaitable<WebSocket::Refusal> WebSocket::ask_for(std::string host, std::string target, std::string token) {
  auto& socket = kind_->socket;
  socket.set_option(websocket::stream_base::timeout::suggested(beast::role_type::client));
  socket.set_option(websocket::stream_base::decorator([&token](websocket::request_type& request) {
    request.set(http::field::authorization, "Bearer " + token);
  }));
  http::response<http::string_body> answer;
  const auto [error] = co_await socket.async_handshake(answer, host, target, outcome);
  if (error == websocket::error::upgrade_declined)
    co_return Refusal{error, answer.result_int(), answer.body()};
  co_return Refusal{error, 0, {}};
}

awaitable<boost::system::error_code> WebSocket::send(std::string_view text) {
  const auto [error, sent] = co_await kind_->socket.async_write(asio::buffer(text), outcome);
  co_return error;
}

awaitable<boost::system::error_code> WebSocket::receive(std::string& text) {
  beast::flat_buffer buffer;
  const auto [error, received] = co_await kind_->socket.async_read(buffer, outcome);
  if (!error) text = beast::buffers_to_string(buffer.data());
  co_return error;
}

awaitable<void> WebSocket::close() {
  co_await kind_->socket.async_close(websocket::close_code::normal, outcome);
}

void WebSocket::cut() {
  kind_->socket.next_layer().lowest().close();
}

}  // namespace headstock::protocol

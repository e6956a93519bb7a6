#include "server/api/http/connection.hpp"

#include <chrono>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "protocol/process/log.hpp"
#include "protocol/stream/byte_stream.hpp"
#include "protocol/stream/web_socket.hpp"
#include "server/api/http/dispatch.hpp"

namespace headstock::api {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::awaitable;
using asio::ip::tcp;
constexpr auto tuple = asio::as_tuple(asio::use_awaitable);

using Parser = http::request_parser<http::buffer_body>;
using protocol::ByteStream;
using protocol::WebSocket;

/// Entry in the list of connections for as long as the coroutine lives.
class Listed {
 public:
  Listed(std::shared_ptr<Shared> shared) : shared_(std::move(shared)) {
    at_ = shared_->connections.emplace(shared_->connections.end());
  }
  ~Listed() {
    shared_->connections.erase(at_);
    if (shared_->connections.empty() && shared_->emptied) shared_->emptied();
  }
  Listed(const Listed&) = delete;
  Listed& operator=(const Listed&) = delete;
  Connected* operator->() { return &*at_; }

 private:
  std::shared_ptr<Shared> shared_;
  std::list<Connected>::iterator at_;
};

class StreamBody final : public BoundedBody {
 public:
  StreamBody(ByteStream& stream, beast::flat_buffer& buffer, Parser& parser, const Limits& limits)
      : stream_(stream), buffer_(buffer), parser_(parser), limits_(limits) {
    awaits_continue_ = beast::iequals(parser.get()[http::field::expect], "100-continue");
  }

  std::optional<std::uint64_t> announced() const override {
    if (const auto length = parser_.content_length()) return *length;
    return std::nullopt;
  }

  awaitable<std::size_t> read(char* into, std::size_t at_most) override {
    if (awaits_continue_) {
      awaits_continue_ = false;
      static const std::string go_on = "HTTP/1.1 100 Continue\r\n\r\n";
      stream_.lowest().expires_after(limits_.body_time);
      co_await asio::async_write(stream_, asio::buffer(go_on), tuple);
    }
    while (!parser_.is_done()) {
      auto& body = parser_.get().body();
      body.data = into;
      body.size = at_most;
      body.more = true;
      stream_.lowest().expires_after(limits_.body_time);
      auto [error, ignored] = co_await http::async_read(stream_, buffer_, parser_, tuple);
      if (error == http::error::need_buffer) error = {};
      if (error) throw Refused("upload_incomplete");
      const std::size_t got = at_most - body.size;
      total_ += got;
      if (total_ > limit) throw Refused("too_large");
      if (got > 0) co_return got;
    }
    co_return 0;
  }

 private:
  ByteStream& stream_;
  beast::flat_buffer& buffer_;
  Parser& parser_;
  const Limits& limits_;
  std::uint64_t total_ = 0;
  bool awaits_continue_ = false;
};

std::optional<Method> method_of(http::verb verb) {
  switch (verb) {
    case http::verb::get:
    case http::verb::head: return Method::get;
    case http::verb::post: return Method::post;
    case http::verb::patch: return Method::patch;
    case http::verb::delete_: return Method::del;
    default: return std::nullopt;
  }
}

Headers headers_of(const http::fields& fields) {
  const auto text = [&](http::field name) { return std::string(fields[name]); };
  Headers headers;
  headers.authorization = text(http::field::authorization);
  headers.cookie = text(http::field::cookie);
  headers.content_type = text(http::field::content_type);
  headers.if_none_match = text(http::field::if_none_match);
  headers.range = text(http::field::range);
  headers.accept_encoding = text(http::field::accept_encoding);
  headers.origin = text(http::field::origin);
  headers.host = text(http::field::host);
  headers.x_headstock = std::string(fields["X-Headstock"]);
  return headers;
}

/// @return false when the connection broke.
awaitable<bool> send_reply(ByteStream& stream, Reply& reply, bool head, bool keep_alive, const Limits& limits) {
  add_security_headers(reply);
  const std::string_view bytes = reply.fixed.empty() ? std::string_view(reply.body) : reply.fixed;
  http::response<http::span_body<const char>> message{static_cast<http::status>(reply.status), 11};
  for (const auto& [name, value] : reply.headers) message.insert(name, value);
  if (!reply.content_type.empty()) message.set(http::field::content_type, reply.content_type);
  message.keep_alive(keep_alive);
  const bool bodiless = reply.status == 204 || reply.status == 304;
  if (!bodiless) message.content_length(reply.stream ? reply.stream->size() : bytes.size());
  stream.lowest().expires_after(limits.body_time);
  if (head || bodiless || reply.stream) {
    http::response_serializer<http::span_body<const char>> serializer{message};
    const auto [error, ignored] = co_await http::async_write_header(stream, serializer, tuple);
    if (error || head || bodiless) co_return !error;
  } else {
    message.body() = beast::span<const char>(bytes.data(), bytes.size());
    const auto [error, ignored] = co_await http::async_write(stream, message, tuple);
    co_return !error;
  }
  std::vector<char> piece(64 * 1024);
  std::uint64_t left = reply.stream->size();
  while (left > 0) {
    const auto got = co_await reply.stream->read(piece.data(), std::min<std::uint64_t>(left, piece.size()));
    if (got == 0) co_return false;   // the announced length can no longer be kept: a broken connection says so
    stream.lowest().expires_after(limits.body_time);
    const auto [error, ignored] = co_await asio::async_write(stream, asio::buffer(piece.data(), got), tuple);
    if (error) co_return false;
    left -= got;
  }
  co_return true;
}

class Socket final : public SocketClient {
 public:
  explicit Socket(ByteStream&& stream) : socket_(std::move(stream)) {}

  awaitable<bool> accept(const http::request_header<>& request, const Limits& limits) {
    co_return !co_await socket_.accept(request, limits.socket_message_bytes);
  }
  awaitable<bool> send(std::shared_ptr<const std::string> message) override { co_return !co_await socket_.send(*message); }
  awaitable<std::optional<std::string>> receive() override {
    std::string text;
    if (co_await socket_.receive(text)) co_return std::nullopt;
    co_return text;
  }
  void cut() override { socket_.cut(); }

 private:
  WebSocket socket_;
};

/// A reply to what could not be parsed; nothing when there is nobody to answer.
std::optional<Refused> parse_failure(const beast::error_code& error, bool anything_read) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow) return Refused("header_too_large");
  if (error == beast::error::timeout) return anything_read ? std::optional(Refused("timeout")) : std::nullopt;
  if (error.category() == make_error_code(http::error::bad_method).category() && error != http::error::end_of_stream &&
      error != http::error::partial_message)
    return Refused("bad_request");
  return std::nullopt;
}

/// Lets the client read the reply before a reset could destroy it: one that still sends a long upload is heard, and what
/// it sends is dropped, until it is silent for two seconds or for half a minute in all.
awaitable<void> linger(ByteStream& stream) {
  auto& tcp_stream = stream.lowest();
  boost::system::error_code ignored;
  tcp_stream.expires_after(std::chrono::seconds(2));
  co_await stream.shutdown();
  tcp_stream.socket().shutdown(tcp::socket::shutdown_send, ignored);
  std::vector<char> waste(64 * 1024);
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < until) {
    tcp_stream.expires_after(std::chrono::seconds(2));
    const auto [error, got] = co_await tcp_stream.async_read_some(asio::buffer(waste), tuple);
    if (error || got == 0) break;
  }
  tcp_stream.close();
}

awaitable<void> serve(ByteStream stream, std::shared_ptr<Shared> shared) {
  Listed listed(shared);
  beast::tcp_stream& lowest = stream.lowest();
  listed->cut = [&lowest] { lowest.close(); };
  boost::system::error_code ignored;
  const auto endpoint = lowest.socket().remote_endpoint(ignored);
  const std::string peer = ignored ? "" : endpoint.address().to_string();
  const Limits& limits = shared->limits;
  beast::flat_buffer buffer(std::max<std::size_t>(limits.header_bytes, 64 * 1024) + 4096);

  for (bool keep_alive = true; keep_alive && !shared->stopping;) {
    Parser parser;
    parser.header_limit(static_cast<std::uint32_t>(limits.header_bytes));
    parser.body_limit(boost::none);   // counted by StreamBody, by route
    lowest.expires_after(limits.header_time);
    listed->idle = true;
    const auto [error, got] = co_await http::async_read_header(stream, buffer, parser, tuple);
    listed->idle = false;
    if (error) {
      if (const auto refused = parse_failure(error, got > 0 || buffer.size() > 0)) {
        Reply reply = error_reply(*refused);
        co_await send_reply(stream, reply, false, false, limits);
        listed->idle = true;
        co_await linger(stream);
      }
      co_return;
    }
    Request request;
    request.headers = headers_of(parser.get());
    request.peer = peer;
    request.secure = stream.secure();
    request.head = parser.get().method() == http::verb::head;
    const auto method = method_of(parser.get().method());
    const auto target = parser.get().target();
    Dispatched done;
    StreamBody body(stream, buffer, parser, limits);
    if (!method) {
      done.reply = error_reply(Refused("method_not_allowed"));
    } else if (!split_target({target.data(), target.size()}, request.path, request.query)) {
      done.reply = error_reply(Refused("bad_request"));
    } else {
      request.method = *method;
      const bool head = request.head;
      done = co_await dispatch(shared->router, shared->host, limits, std::move(request), body);
      request.head = head;
    }
    if (done.socket_for && WebSocket::asked_for(parser.get())) {
      auto socket = std::make_shared<Socket>(std::move(stream));
      listed->cut = [socket] { socket->cut(); };
      listed->idle = true;
      const bool accepted = co_await socket->accept(parser.get(), limits);
      if (accepted && !shared->stopping) co_await shared->host.web_socket(socket, *done.socket_for);
      socket->cut();
      co_return;
    }
    if (done.socket_for) done.reply = error_reply(Refused("web_socket_only"));
    keep_alive = parser.get().keep_alive() && parser.is_done() && !shared->stopping;
    const bool sent = co_await send_reply(stream, done.reply, request.head, keep_alive, limits);
    if (!sent) co_return;
  }
  listed->idle = true;
  co_await linger(stream);
}

}  // namespace

awaitable<void> serve_plain(tcp::socket socket, std::shared_ptr<Shared> shared) {
  try {
    co_await serve(ByteStream(std::move(socket), nullptr), shared);
  } catch (const std::exception& error) {
    log::warning("a connection ended: {}", error.what());
  }
}

awaitable<void> serve_tls(tcp::socket socket, asio::ssl::context& tls, std::shared_ptr<Shared> shared) {
  try {
    ByteStream stream(std::move(socket), &tls);
    {
      Listed listed(shared);
      listed->cut = [&stream] { stream.lowest().close(); };
      stream.lowest().expires_after(std::chrono::seconds(10));
      const auto error = co_await stream.handshake(asio::ssl::stream_base::server);
      if (error) co_return;   // a scanner, or a browser that does not know the certificate yet
    }
    co_await serve(std::move(stream), shared);
  } catch (const std::exception& error) {
    log::warning("a connection ended: {}", error.what());
  }
}

awaitable<void> turn_away(tcp::socket socket, std::shared_ptr<Shared> shared) {
  try {
    ByteStream stream(std::move(socket), nullptr);
    Reply reply = error_reply(Refused("busy"));
    co_await send_reply(stream, reply, false, false, shared->limits);
    co_await linger(stream);
  } catch (const std::exception& error) {
    log::warning("a connection ended: {}", error.what());
  }
}

}  // namespace headstock::api

#include "command-line/client/connection.hpp"

#include <cctype>
#include <fstream>
#include <optional>
#include <vector>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "command-line/client/output.hpp"
#include "protocol/stream/byte_stream.hpp"

namespace headstock::client {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
namespace ssl = asio::ssl;
using asio::awaitable;
using asio::use_awaitable;
using asio::ip::tcp;
using std::chrono::seconds;

using protocol::ByteStream;

constexpr seconds connect_time{10};
constexpr seconds answer_time{120};   // a check may take long; the server answers 202 well before

Failure cannot_connect(const std::string& where, const std::string& why) {
  return Failure(unreachable, say("cannot reach the server at ", "无法连接服务器 ") + where + ": " + why);
}

awaitable<void> connect(beast::tcp_stream& stream, const std::string& host, const std::string& port) {
  tcp::resolver resolver(co_await asio::this_coro::executor);
  const auto found = co_await resolver.async_resolve(host, port, use_awaitable);
  stream.expires_after(connect_time);
  co_await stream.async_connect(found, use_awaitable);
}

std::string message_of(unsigned status, const json& answer) {
  if (answer.is_object() && answer.contains("error") && answer["error"].is_object()) {
    const auto& error = answer["error"];
    const auto& texts = error.value("message", json::object());
    std::string text = texts.value(chinese() ? "zh" : "en", error.value("code", std::string("error")));
    if (error.contains("where") && error["where"].is_string()) text += " (" + error["where"].get<std::string>() + ")";
    return text;
  }
  return say("the server answered with status ", "服务器返回状态 ") + std::to_string(status);
}

json parsed(const std::string& body) {
  if (body.empty()) return nullptr;
  auto value = json::parse(body, nullptr, false);
  return value.is_discarded() ? json(nullptr) : value;
}

json demand_success(unsigned status, const std::string& body) {
  json answer = parsed(body);
  if (status >= 200 && status < 300) return answer;
  if (status == 401)
    throw Failure(not_signed_in, message_of(status, answer) + say("; use: headstock login", "；请使用 headstock login"), answer);
  throw Failure(refused, message_of(status, answer), answer);
}

/// One exchange on the stream to a server.
struct Exchange {
  ByteStream& stream;

  awaitable<json> request(http::request<http::string_body> message) {
    auto& lowest = stream.lowest();
    lowest.expires_after(answer_time);
    co_await http::async_write(stream, message, use_awaitable);
    beast::flat_buffer buffer;
    http::response_parser<http::string_body> parser;
    parser.body_limit(std::uint64_t{1} << 30);
    co_await http::async_read(stream, buffer, parser, use_awaitable);
    co_return demand_success(parser.get().result_int(), parser.get().body());
  }

  awaitable<json> upload(http::request<http::empty_body> head, std::istream& file, std::uint64_t size,
                         const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    auto& lowest = stream.lowest();
    head.content_length(size);
    http::request_serializer<http::empty_body> serializer{head};
    lowest.expires_after(answer_time);
    co_await http::async_write_header(stream, serializer, use_awaitable);
    std::vector<char> piece(256 * 1024);
    boost::system::error_code broken;
    for (std::uint64_t sent = 0; sent < size && !broken;) {
      file.read(piece.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(piece.size(), size - sent)));
      const auto got = static_cast<std::size_t>(file.gcount());
      if (got == 0) throw Failure(usage, say("the file became shorter while it was sent", "发送过程中文件变短"));
      lowest.expires_after(answer_time);
      // A server that refuses early closes; its answer is still there to be read.
      co_await asio::async_write(stream, asio::buffer(piece.data(), got), asio::redirect_error(use_awaitable, broken));
      sent += got;
      if (progress && !broken) progress(sent, size);
    }
    beast::flat_buffer buffer;
    http::response<http::string_body> answer;
    co_await http::async_read(stream, buffer, answer, use_awaitable);
    co_return demand_success(answer.result_int(), answer.body());
  }

  awaitable<void> download(http::request<http::empty_body> head,
                           const std::function<void(const char*, std::size_t)>& write) {
    auto& lowest = stream.lowest();
    lowest.expires_after(answer_time);
    co_await http::async_write(stream, head, use_awaitable);
    beast::flat_buffer buffer;
    http::response_parser<http::buffer_body> parser;
    parser.body_limit(boost::none);
    co_await http::async_read_header(stream, buffer, parser, use_awaitable);
    std::vector<char> piece(256 * 1024);
    std::string error_body;
    const auto status = parser.get().result_int();
    const bool good = status >= 200 && status < 300;
    while (!parser.is_done()) {
      auto& body = parser.get().body();
      body.data = piece.data();
      body.size = piece.size();
      lowest.expires_after(answer_time);
      boost::system::error_code error;
      co_await http::async_read(stream, buffer, parser, asio::redirect_error(use_awaitable, error));
      if (error && error != http::error::need_buffer) throw boost::system::system_error(error);
      const auto got = piece.size() - body.size;
      if (good)
        write(piece.data(), got);
      else if (error_body.size() < 65536)
        error_body.append(piece.data(), got);
    }
    if (!good) demand_success(status, error_body);
  }
};

awaitable<void> follow(websocket::stream<ByteStream>& socket, const std::string& host, const std::string& token,
                       const json& subscription, const std::function<bool(const json&)>& message) {
  socket.next_layer().lowest().expires_never();
  socket.set_option(websocket::stream_base::timeout::suggested(beast::role_type::client));
  socket.set_option(websocket::stream_base::decorator([&token](websocket::request_type& request) {
    request.set(http::field::authorization, "Bearer " + token);
  }));
  http::response<http::string_body> answer;
  boost::system::error_code error;
  co_await socket.async_handshake(answer, host, "/api/v1/events", asio::redirect_error(use_awaitable, error));
  if (error == websocket::error::upgrade_declined) demand_success(answer.result_int(), answer.body());
  if (error) throw boost::system::system_error(error);
  const auto text = subscription.dump();
  co_await socket.async_write(asio::buffer(text), use_awaitable);
  for (;;) {
    beast::flat_buffer buffer;
    co_await socket.async_read(buffer, use_awaitable);
    const auto value = json::parse(beast::buffers_to_string(buffer.data()), nullptr, false);
    if (value.is_object() && !message(value)) break;
  }
  co_await socket.async_close(websocket::close_code::normal, asio::redirect_error(use_awaitable, error));
}

ssl::context tls_context(const std::filesystem::path& ca) {
  ssl::context context(ssl::context::tls_client);
  context.set_default_verify_paths();
  if (!ca.empty()) {
    boost::system::error_code error;
    context.load_verify_file(ca.string(), error);
    if (error) throw Failure(usage, say("cannot read the certificate ", "无法读取证书 ") + ca.string() + ": " + error.message());
  }
  context.set_verify_mode(ssl::verify_peer);
  return context;
}

/// Opens the kind of stream the server needs, runs `use` on it, and turns what goes wrong into a Failure.
void with_stream(const Server& server, bool secure, const std::string& host, const std::string& port,
                 const std::function<awaitable<void>(ByteStream&)>& use) {
  asio::io_context io;
  std::exception_ptr failed;
  auto work = [&]() -> awaitable<void> {
    std::optional<ssl::context> context;
    if (secure) context = tls_context(server.ca);
    ByteStream stream(tcp::socket(io), context ? &*context : nullptr);
    stream.demand_host(host);
    co_await connect(stream.lowest(), host, port);
    if (const auto error = co_await stream.handshake(ssl::stream_base::client))
      throw Failure(unreachable, say("the server's certificate is not trusted; give the shop's CA (DATA/pki on the server) with login --ca: ",
                                     "服务器证书不受信任；请用 login --ca 指定车间 CA 证书（位于服务器的 DATA/pki）：") + error.message());
    co_await use(stream);
  };
  asio::co_spawn(io, work(), [&](std::exception_ptr error) { failed = error; });
  io.run();
  if (!failed) return;
  try {
    std::rethrow_exception(failed);
  } catch (const boost::system::system_error& error) {
    throw cannot_connect(server.url, error.code().message());
  }
}

}  // namespace

std::string encoded(const std::string& text) {
  static constexpr char digits[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) || c == '-' || c == '.' || c == '_' || c == '~') {
      out += c;
    } else {
      out += '%';
      out += digits[byte >> 4];
      out += digits[byte & 15];
    }
  }
  return out;
}

Connection::Connection(Server server) : server_(std::move(server)) {
  std::string_view rest = server_.url;
  if (rest.starts_with("https://")) {
    secure_ = true;
    rest.remove_prefix(8);
  } else if (rest.starts_with("http://")) {
    rest.remove_prefix(7);
  } else {
    throw Failure(usage, say("the server's address must begin with http:// or https://: ", "服务器地址须以 http:// 或 https:// 开头：") + server_.url);
  }
  rest = rest.substr(0, rest.find('/'));
  const auto close = rest.find(']');
  const auto colon = rest.rfind(':');
  const bool has_port = colon != std::string_view::npos && (close == std::string_view::npos || colon > close);
  port_ = has_port ? std::string(rest.substr(colon + 1)) : (secure_ ? "443" : "80");
  host_ = std::string(rest.substr(0, has_port ? colon : rest.size()));
  if (host_.size() > 2 && host_.front() == '[') host_ = host_.substr(1, host_.size() - 2);
}

namespace {

template <class Body>
http::request<Body> message(http::verb verb, const std::string& path, const std::string& host, const std::string& token) {
  http::request<Body> request{verb, "/api/v1" + path, 11};
  request.set(http::field::host, host);
  request.set(http::field::user_agent, "headstock");
  request.set("X-Headstock", "1");
  request.keep_alive(false);
  if (!token.empty()) request.set(http::field::authorization, "Bearer " + token);
  return request;
}

}  // namespace

json Connection::get(const std::string& path) { return send("GET", path, nullptr); }

json Connection::send(const std::string& method, const std::string& path, const json& body) {
  auto request = message<http::string_body>(http::string_to_verb(method), path, host_, server_.token);
  if (!body.is_null()) {
    request.set(http::field::content_type, "application/json");
    request.body() = body.dump();
  }
  request.prepare_payload();
  json answer;
  with_stream(server_, secure_, host_, port_, [&](ByteStream& stream) -> awaitable<void> {
    Exchange exchange{stream};
    answer = co_await exchange.request(std::move(request));
  });
  return answer;
}

json Connection::upload(const std::string& path, const std::filesystem::path& file,
                        const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  std::ifstream in(file, std::ios::binary);
  if (error || !in) throw Failure(usage, say("cannot read ", "无法读取 ") + file.string());
  json answer;
  with_stream(server_, secure_, host_, port_, [&](ByteStream& stream) -> awaitable<void> {
    auto head = message<http::empty_body>(http::verb::post, path, host_, server_.token);
    head.set(http::field::content_type, "application/octet-stream");
    Exchange exchange{stream};
    answer = co_await exchange.upload(std::move(head), in, size, progress);
  });
  return answer;
}

void Connection::download(const std::string& path, const std::function<void(const char*, std::size_t)>& write) {
  with_stream(server_, secure_, host_, port_, [&](ByteStream& stream) -> awaitable<void> {
    auto head = message<http::empty_body>(http::verb::get, path, host_, server_.token);
    Exchange exchange{stream};
    co_await exchange.download(std::move(head), write);
  });
}

void Connection::watch(const json& subscription, const std::function<bool(const json&)>& on_message) {
  with_stream(server_, secure_, host_, port_, [&](ByteStream& stream) -> awaitable<void> {
    websocket::stream<ByteStream> socket(std::move(stream));
    const std::string host = host_ + ":" + port_;
    co_await follow(socket, host, server_.token, subscription, on_message);
  });
}

}  // namespace headstock::client

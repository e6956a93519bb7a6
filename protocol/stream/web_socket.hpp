// A WebSocket over a ByteStream, the server's or a client's end of it: texts that come whole. Beast's
// templates behind it are compiled once, for the server and for the command line. One reader and one writer
// at a time. One thread: the stream's.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/beast/http/message.hpp>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "protocol/stream/byte_stream.hpp"

namespace headstock::protocol {

class WebSocket {
 public:
  /// The server's answer to a client that asked for a WebSocket and was refused.
  struct Refusal {
    boost::system::error_code error;  ///< none: not refused
    unsigned status = 0;              ///< of HTTP; 0: no answer at all
    std::string body;
  };

  /// @param stream connected, its TLS greeting done.
  explicit WebSocket(ByteStream&& stream);
  ~WebSocket();

  /// Is this request of HTTP one for a WebSocket?
  static bool asked_for(const boost::beast::http::request_header<>& request);
  /// The server's end: accepts. Afterwards the client is asked for a sign of life when it is silent for 15 s,
  /// and given up after 30. @param longest_message in bytes; a longer one ends the connection.
  boost::asio::awaitable<boost::system::error_code> accept(
      const boost::beast::http::request_header<>& request, std::size_t longest_message);
  /// The client's end: asks for `target` of `host` ("name:port") with the right of `token`.
  boost::asio::awaitable<Refusal> ask_for(std::string host, std::string target, std::string token);

  /// @param text must live until it is sent.
  boost::asio::awaitable<boost::system::error_code> send(std::string_view text);
  boost::asio::awaitable<boost::system::error_code> receive(std::string& text);
  /// Says good-bye and waits for the other's.
  boost::asio::awaitable<void> close();
  /// Ends it at once, whatever is under way; safe to call again.
  void cut();

 private:
  struct Kind;
  std::unique_ptr<Kind> kind_;
};

}  // namespace headstock::protocol

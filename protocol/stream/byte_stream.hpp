// A TCP connection, plain or under TLS, as one type: which it is is decided at run time. What is built on it (HTTP,
// WebSocket) is compiled once instead of once a kind of stream; those templates are the longest in the build.
// Meets Beast's AsyncStream. One thread: that of its executor.
#pragma once

#include <array>
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/dispatch.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream_base.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <functional>
#include <memory>
#include <utility>

namespace headstock::protocol {

class ByteStream {
 public:
  using executor_type = boost::asio::any_io_executor;
  using Done = std::function<void(boost::system::error_code, std::size_t)>;

  /// As much of a sequence of buffers as one call takes; the rest is for the next call.
  template <class Buffer>
  class Few {
   public:
    using value_type = Buffer;
    using const_iterator = const Buffer*;
    template <class Sequence>
    explicit Few(const Sequence& all) {
      const auto end = boost::asio::buffer_sequence_end(all);
      for (auto at = boost::asio::buffer_sequence_begin(all); at != end && count_ < few_.size(); ++at)
        if (Buffer(*at).size() != 0) few_[count_++] = Buffer(*at);
    }
    const Buffer* begin() const { return few_.data(); }
    const Buffer* end() const { return few_.data() + count_; }

   private:
    std::array<Buffer, 16> few_{};
    std::size_t count_ = 0;
  };
  using ReadBuffers = Few<boost::asio::mutable_buffer>;
  using WriteBuffers = Few<boost::asio::const_buffer>;

  /// @param tls nullptr: plain. Must outlive the stream.
  ByteStream(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context* tls);
  ~ByteStream();
  ByteStream(ByteStream&&) noexcept;
  ByteStream& operator=(ByteStream&&) noexcept;

  executor_type get_executor() const;
  bool secure() const;
  /// The connection below TLS: its time limits (`expires_after`), its socket, `close()`.
  boost::beast::tcp_stream& lowest();

  /// The greeting of TLS; done at once on a plain stream.
  boost::asio::awaitable<boost::system::error_code> handshake(boost::asio::ssl::stream_base::handshake_type side);
  /// TLS's good-bye; nothing on a plain stream. The socket stays open.
  boost::asio::awaitable<void> shutdown();
  /// A client: which name the server's certificate must bear. Before handshake().
  void demand_host(const std::string& host);

  template <class Buffers, class Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const ReadBuffers& some) { start_read(some, erased(std::move(handler))); }, token,
        ReadBuffers(buffers));
  }
  template <class Buffers, class Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const WriteBuffers& some) { start_write(some, erased(std::move(handler))); }, token,
        WriteBuffers(buffers));
  }

  // What Beast's WebSocket asks of the layer below it.
  template <class Handler>
  friend void async_teardown(boost::beast::role_type, ByteStream& stream, Handler&& handler) {
    boost::asio::dispatch(stream.get_executor(), [&stream, handler = std::forward<Handler>(handler)]() mutable {
      boost::system::error_code ignored;  // the other side may have gone already
      stream.lowest().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
      std::move(handler)(boost::system::error_code());
    });
  }
  friend void teardown(boost::beast::role_type, ByteStream& stream, boost::system::error_code& error) {
    stream.lowest().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, error);
    error = {};
  }
  friend void beast_close_socket(ByteStream& stream) { stream.lowest().close(); }

 private:
  struct Kind;

  /// Handlers may be of any type and may only be moved; the kinds below want one type.
  template <class Handler>
  static Done erased(Handler handler) {
    auto kept = std::make_shared<Handler>(std::move(handler));
    return [kept](boost::system::error_code error, std::size_t bytes) {
      auto home = boost::asio::get_associated_executor(*kept);
      boost::asio::dispatch(home, [kept, error, bytes]() mutable { std::move (*kept)(error, bytes); });
    };
  }
  void start_read(const ReadBuffers& buffers, Done done);
  void start_write(const WriteBuffers& buffers, Done done);

  std::unique_ptr<Kind> kind_;
};

}  // namespace headstock::protocol

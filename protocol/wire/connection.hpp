// One TLS connection that carries frames, for either side. Everything on the thread of its io_context.
//
// Writing never suspends the caller: frames are appended to one buffer, which a single coroutine writes out
// as large TLS records (frames that come while a write is under way leave together). The buffer is bounded: a
// peer that does not read is closed.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "protocol/wire/frame.hpp"

namespace headstock::wire {

using Milliseconds = std::chrono::milliseconds;

/// Wakes coroutines of one thread; check the condition again after waiting.
class Signal {
 public:
  explicit Signal(const boost::asio::any_io_executor& executor);
  boost::asio::awaitable<void> wait();
  /// @return after a notify or the time.
  boost::asio::awaitable<void> wait_for(Milliseconds time);
  void notify() { timer_.cancel(); }

 private:
  boost::asio::steady_timer timer_;
};

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  using Stream = boost::asio::ssl::stream<boost::asio::ip::tcp::socket>;
  using Clock = std::chrono::steady_clock;

  Connection(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context& context);

  /// @return false when it failed or took longer than `limit`; reason() says why.
  boost::asio::awaitable<bool> handshake(boost::asio::ssl::stream_base::handshake_type side,
                                         Milliseconds limit);
  /// The next frame; its body stays valid until the next call. @return false when the connection is closed.
  boost::asio::awaitable<bool> receive(Frame& frame);
  /// Appends a frame to what is written next. @return false when closed, or closed now because the peer does
  /// not read.
  bool send(Type type, std::uint32_t stream, std::string_view body);
  /// Bytes as they are, for tests of what a broken peer sends.
  void send_raw(std::string_view bytes);
  /// Waits until little is left to be written (bulk data go out no faster than the peer takes them).
  boost::asio::awaitable<void> room();

  /// Writes out what was sent, then closes: for a refusal that the peer should read. Nothing more is
  /// received.
  void finish(std::string reason);
  void close(std::string reason);
  bool open() const { return open_ && !finishing_; }
  const std::string& reason() const { return reason_; }

  /// Time since the peer was last heard, or since a write has been stuck, whichever is longer.
  Milliseconds silence() const;
  Clock::time_point last_heard() const { return last_heard_; }
  std::size_t waiting_bytes() const { return outgoing_.size() + (writing_now_ ? writing_.size() : 0); }
  boost::asio::any_io_executor executor() { return stream_.get_executor(); }
  SSL* tls() { return stream_.native_handle(); }
  /// "192.0.2.7:50123"
  const std::string& peer() const { return peer_; }

 private:
  boost::asio::awaitable<void> write_loop();
  void close_after(Milliseconds limit, std::string reason);

  Stream stream_;
  boost::asio::steady_timer deadline_;
  Signal to_write_, room_;
  FrameReader reader_;
  std::string outgoing_, writing_, reason_, peer_;
  bool open_ = true, finishing_ = false, writing_now_ = false;
  Clock::time_point last_heard_ = Clock::now(), write_started_ = last_heard_;
};

}  // namespace headstock::wire

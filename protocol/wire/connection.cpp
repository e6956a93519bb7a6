#include "protocol/wire/connection.hpp"

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

#include "protocol/wire/messages.hpp"
#include "protocol/wire/tls.hpp"

namespace headstock::wire {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
constexpr auto kAsTuple = asio::as_tuple(asio::use_awaitable);

/// Most bytes waiting for a peer that does not read.
constexpr std::size_t kMaxWaiting = 4u << 20;
/// Bulk data wait while more than this is queued: two frames ahead keep the pipe full.
constexpr std::size_t kBulkWaiting = 256u << 10;
constexpr Milliseconds kFinishLimit{1'000};

std::string why(const error_code& error) {
  if (error == asio::error::eof || error == asio::ssl::error::stream_truncated)
    return "closed by the other side";
  return error.message();
}

}  // namespace

Signal::Signal(const asio::any_io_executor& executor) : timer_(executor) {}

asio::awaitable<void> Signal::wait() {
  timer_.expires_at(asio::steady_timer::time_point::max());
  co_await timer_.async_wait(kAsTuple);
}

asio::awaitable<void> Signal::wait_for(Milliseconds time) {
  timer_.expires_after(time);
  co_await timer_.async_wait(kAsTuple);
}

Connection::Connection(asio::ip::tcp::socket socket, asio::ssl::context& context)
    : stream_(std::move(socket), context),
      deadline_(stream_.get_executor()),
      to_write_(stream_.get_executor()),
      room_(stream_.get_executor()) {
  error_code ignored;
  stream_.next_layer().set_option(asio::ip::tcp::no_delay(true), ignored);
  const auto endpoint = stream_.next_layer().remote_endpoint(ignored);
  if (!ignored) peer_ = endpoint.address().to_string() + ':' + std::to_string(endpoint.port());
}

void Connection::close_after(Milliseconds limit, std::string reason) {
  deadline_.expires_after(limit);
  deadline_.async_wait([self = weak_from_this(), reason = std::move(reason)](const error_code& error) {
    if (error) return;
    if (const auto connection = self.lock()) connection->close(reason);
  });
}

asio::awaitable<bool> Connection::handshake(asio::ssl::stream_base::handshake_type side, Milliseconds limit) {
  const auto self = shared_from_this();
  close_after(limit, "the TLS handshake took too long");
  const auto [error] = co_await stream_.async_handshake(side, kAsTuple);
  deadline_.cancel();
  if (error) {
    std::string reason = verification_failure(tls());
    if (reason.empty() || error == asio::error::operation_aborted)
      reason = "TLS: " + why(error);
    else
      reason = "certificate not accepted: " + reason;
    close(std::move(reason));
    co_return false;
  }
  if (!open_) co_return false;
  last_heard_ = Clock::now();
  asio::co_spawn(
      stream_.get_executor(), [self] { return self->write_loop(); }, asio::detached);
  co_return true;
}

asio::awaitable<bool> Connection::receive(Frame& frame) {
  const auto self = shared_from_this();
  std::array<char, 4096> discarded;
  while (open_) {
    if (!finishing_) {
      const FrameReader::Status status = reader_.next(frame);
      if (status == FrameReader::Status::frame) co_return true;
      if (status == FrameReader::Status::malformed) {
        if (reader_.foreign_version()) {
          Refuse refuse;
          refuse.reason = "version";
          refuse.text = reader_.fault();
          refuse.versions = {kVersion};
          send(Type::refuse, 0, encode(refuse));
          finish(reader_.fault());
        } else {
          close(reader_.fault());
        }
        continue;
      }
    }
    const auto into = finishing_ ? std::span<char>(discarded) : reader_.space();
    const auto [error, bytes] =
        co_await stream_.async_read_some(asio::buffer(into.data(), into.size()), kAsTuple);
    if (error) {
      close(why(error));
      break;
    }
    last_heard_ = Clock::now();
    if (!finishing_) reader_.received(bytes);
  }
  co_return false;
}

bool Connection::send(Type type, std::uint32_t stream, std::string_view body) {
  if (!open()) return false;
  if (outgoing_.size() + body.size() > kMaxWaiting) {
    close("the other side does not read");
    return false;
  }
  append_frame(outgoing_, type, stream, body);
  to_write_.notify();
  return true;
}

void Connection::send_raw(std::string_view bytes) {
  outgoing_ += bytes;
  to_write_.notify();
}

asio::awaitable<void> Connection::room() {
  const auto self = shared_from_this();
  while (open() && outgoing_.size() >= kBulkWaiting) co_await room_.wait();
}

asio::awaitable<void> Connection::write_loop() {
  const auto self = shared_from_this();
  while (open_) {
    if (outgoing_.empty()) {
      if (finishing_) break;
      co_await to_write_.wait();
      continue;
    }
    writing_.clear();
    std::swap(writing_, outgoing_);
    room_.notify();
    write_started_ = Clock::now();
    writing_now_ = true;
    const auto [error, bytes] = co_await asio::async_write(stream_, asio::buffer(writing_), kAsTuple);
    writing_now_ = false;
    if (error) close(why(error));
  }
  if (open_) {
    // Closed for sending only: were it closed at once with bytes unread, the peer might never see the
    // refusal.
    error_code ignored;
    stream_.next_layer().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  }
}

void Connection::finish(std::string reason) {
  if (!open()) return;
  reason_ = reason;
  finishing_ = true;
  close_after(kFinishLimit, std::move(reason));
  to_write_.notify();
  room_.notify();
}

void Connection::close(std::string reason) {
  if (!open_) return;
  if (!finishing_) reason_ = std::move(reason);
  open_ = false;
  error_code ignored;
  stream_.next_layer().close(ignored);
  deadline_.cancel();
  to_write_.notify();
  room_.notify();
}

Milliseconds Connection::silence() const {
  const auto now = Clock::now();
  const auto heard = now - last_heard_;
  const auto stuck = writing_now_ ? now - write_started_ : Clock::duration::zero();
  return std::chrono::duration_cast<Milliseconds>(std::max(heard, stuck));
}

}  // namespace headstock::wire

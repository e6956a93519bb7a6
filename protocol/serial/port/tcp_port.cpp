#include <linux/sockios.h>
#include <sys/ioctl.h>

#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocol/serial/port/ports.hpp"

namespace headstock::serial {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr auto kConnectLimit = std::chrono::seconds(10);
/// Small: what waits here cannot be called back after a DC3.
constexpr int kSendBuffer = 4'608;

class TcpPort final : public std::enable_shared_from_this<TcpPort> {
 public:
  TcpPort(const asio::any_io_executor& executor, std::string host, std::uint16_t port)
      : host_(std::move(host)), port_(port), socket_(executor), resolver_(executor), limit_(executor) {}

  void open(PortListener& listener) {
    listener_ = &listener;
    limit_.expires_after(kConnectLimit);
    limit_.async_wait([self = shared_from_this()](error_code error) {
      if (!error && !self->connected_) self->lost("connect_timeout", "");
    });
    resolver_.async_resolve(
        host_, std::to_string(port_),
        [self = shared_from_this()](error_code error, const tcp::resolver::results_type& found) {
          if (self->listener_ == nullptr) return;
          if (error) return self->lost("connect_failed", error.message());
          self->connect(found);
        });
  }

  std::size_t write(std::string_view bytes) {
    if (!connected_) return 0;
    error_code error;
    const std::size_t count = socket_.write_some(asio::buffer(bytes.data(), bytes.size()), error);
    if (error && error != asio::error::would_block && error != asio::error::try_again) {
      lost("disconnected", error.message());
      return 0;
    }
    if (count < bytes.size() && !waiting_to_write_) {
      waiting_to_write_ = true;
      socket_.async_wait(tcp::socket::wait_write, [self = shared_from_this()](error_code failed) {
        self->waiting_to_write_ = false;
        if (!failed && self->listener_ != nullptr) self->listener_->on_writable();
      });
    }
    return count;
  }

  std::size_t queued() {
    int count = 0;
    if (!connected_ || ::ioctl(socket_.native_handle(), SIOCOUTQ, &count) != 0 || count < 0) return 0;
    return static_cast<std::size_t>(count);
  }

  void close() {
    listener_ = nullptr;
    connected_ = false;
    limit_.cancel();
    resolver_.cancel();
    error_code ignored;
    // What is queued is discarded with the connection.
    if (socket_.is_open()) socket_.set_option(asio::socket_base::linger(true, discard_ ? 0 : 1), ignored);
    socket_.close(ignored);
  }
  void discard_output() { discard_ = true; }
  void abandon() {
    *alive_ = false;
    close();
  }

 private:
  void connect(const tcp::resolver::results_type& found) {
    asio::async_connect(socket_, found, [self = shared_from_this()](error_code error, const tcp::endpoint&) {
      if (self->listener_ == nullptr) return;
      if (error) return self->lost("connect_failed", error.message());
      self->limit_.cancel();
      error_code ignored;
      self->socket_.set_option(tcp::no_delay(true), ignored);
      self->socket_.set_option(asio::socket_base::keep_alive(true), ignored);
      self->socket_.set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
      self->socket_.non_blocking(true, ignored);
      self->connected_ = true;
      self->listener_->on_open();
      if (self->listener_ != nullptr) self->read();
    });
  }

  void read() {
    socket_.async_read_some(asio::buffer(piece_),
                            [self = shared_from_this()](error_code error, std::size_t count) {
                              if (self->listener_ == nullptr) return;
                              if (count > 0) self->listener_->on_bytes({self->piece_.data(), count});
                              if (self->listener_ == nullptr) return;
                              if (error) return self->lost("disconnected", error.message());
                              self->read();
                            });
  }

  void lost(const std::string& reason, const std::string& text) {
    PortListener* const listener = listener_;
    close();
    // Not from inside a call of the listener.
    if (listener != nullptr)
      asio::post(socket_.get_executor(), [listener, reason, text, alive = alive_] {
        if (*alive) listener->on_closed(reason, text);
      });
  }

  std::string host_;
  std::uint16_t port_;
  tcp::socket socket_;
  tcp::resolver resolver_;
  asio::steady_timer limit_;
  PortListener* listener_ = nullptr;
  std::array<char, 4'096> piece_{};
  bool connected_ = false, waiting_to_write_ = false, discard_ = false;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

/// Ends the connection with its owner, while handlers under way keep the inside.
class OwnedTcp final : public Port {
 public:
  explicit OwnedTcp(std::shared_ptr<TcpPort> port) : port_(std::move(port)) {}
  ~OwnedTcp() override { port_->abandon(); }
  void open(PortListener& listener) override { port_->open(listener); }
  std::size_t write(std::string_view bytes) override { return port_->write(bytes); }
  std::size_t queued() const override { return port_->queued(); }
  void hold_output(bool) override {}  // what the other machine has cannot be held from here
  void discard_output() override { port_->discard_output(); }
  void set_rts(bool) override {}
  Signals signals() override { return {}; }
  void close() override { port_->close(); }

 private:
  std::shared_ptr<TcpPort> port_;
};

}  // namespace

std::unique_ptr<Port> make_tcp_port(const asio::any_io_executor& executor, std::string host,
                                    std::uint16_t port) {
  return std::make_unique<OwnedTcp>(std::make_shared<TcpPort>(executor, std::move(host), port));
}

}  // namespace headstock::serial

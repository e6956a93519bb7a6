#include "agent/listening_port.hpp"

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>

#include "protocol/process/log.hpp"

namespace headstock::agent {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr int kReceiveBuffer = 32 << 10;

class ListeningPort final : public std::enable_shared_from_this<ListeningPort> {
 public:
  ListeningPort(const asio::any_io_executor& executor, std::string address, std::uint16_t port)
      : address_(std::move(address)), port_(port), acceptor_(executor), peer_(executor) {}

  void open(serial::PortListener& listener) {
    listener_ = &listener;
    error_code error;
    const auto address = asio::ip::make_address(address_, error);
    if (!error) acceptor_.open(tcp::endpoint(address, port_).protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    // Little waits here unread: the sender stands soon after the machine does.
    if (!error) acceptor_.set_option(asio::socket_base::receive_buffer_size(kReceiveBuffer), error);
    if (!error) acceptor_.bind(tcp::endpoint(address, port_), error);
    if (!error) acceptor_.listen(1, error);
    asio::post(acceptor_.get_executor(), [self = shared_from_this(), error] {
      if (self->listener_ == nullptr) return;
      if (error) {
        self->acceptor_.close();
        const char* reason = error == asio::error::address_in_use ? "port_in_use" : "port_failed";
        return std::exchange(self->listener_, nullptr)->on_closed(reason, error.message());
      }
      const auto port = self->acceptor_.local_endpoint().port();
      log::info("DNC input: listening on {}:{}", self->address_, port);
      self->listener_->on_open();
      if (self->listener_ != nullptr) self->accept();
    });
  }

  std::size_t write(std::string_view bytes) {
    if (!peer_.is_open()) return 0;
    error_code error;
    const std::size_t count = peer_.write_some(asio::buffer(bytes.data(), bytes.size()), error);
    if (!error || error == asio::error::would_block || error == asio::error::try_again) return count;
    return 0;  // the reading side notices, too
  }

  void reading(bool on) {
    if (on == std::exchange(reading_, on) || !on || !peer_.is_open()) return;
    deliver();
  }

  void close() {
    listener_ = nullptr;
    error_code ignored;
    acceptor_.close(ignored);
    peer_.close(ignored);
  }

 private:
  void accept() {
    acceptor_.async_accept([self = shared_from_this()](error_code error, tcp::socket socket) {
      if (self->listener_ == nullptr) return;
      if (error) return;
      if (self->peer_.is_open()) {
        log::warning("DNC input: a second sender was turned away");
        socket.close(error);
      } else {
        self->peer_ = std::move(socket);
        self->peer_.non_blocking(true, error);
        self->peer_.set_option(tcp::no_delay(true), error);
        self->peer_.set_option(asio::socket_base::keep_alive(true), error);
        self->waiting_ = {};
        self->listener_->on_writable();
        self->read();
      }
      if (self->listener_ != nullptr) self->accept();
    });
  }

  void read() {
    if (under_way_ || listener_ == nullptr || !peer_.is_open()) return;
    under_way_ = true;
    peer_.async_read_some(asio::buffer(piece_),
                          [self = shared_from_this()](error_code error, std::size_t count) {
                            self->under_way_ = false;
                            if (self->listener_ == nullptr) return;
                            self->waiting_ = {self->piece_.data(), count};
                            self->gone_ = static_cast<bool>(error);
                            self->deliver();
                          });
  }

  /// What was read goes on only while it is wanted: a handful at a time, so that a stop is seen at once.
  void deliver() {
    constexpr std::size_t kHandful = 8;
    while (reading_ && !waiting_.empty() && listener_ != nullptr) {
      const auto some = waiting_.substr(0, kHandful);
      waiting_.remove_prefix(some.size());
      listener_->on_bytes(some);
    }
    if (listener_ == nullptr || !waiting_.empty()) return;
    if (!gone_) {
      if (reading_) read();
      return;
    }
    gone_ = false;
    error_code ignored;
    peer_.close(ignored);
    listener_->on_fault(serial::Fault::disconnected);
  }

  std::string address_;
  std::uint16_t port_;
  tcp::acceptor acceptor_;
  tcp::socket peer_;
  serial::PortListener* listener_ = nullptr;
  std::array<char, 4'096> piece_{};
  std::string_view waiting_;  // read, not yet wanted
  bool reading_ = true, under_way_ = false, gone_ = false;
};

/// Ends with its owner, while handlers under way keep the inside.
class OwnedListening final : public serial::Port {
 public:
  explicit OwnedListening(std::shared_ptr<ListeningPort> port) : port_(std::move(port)) {}
  ~OwnedListening() override { port_->close(); }
  void open(serial::PortListener& listener) override { port_->open(listener); }
  std::size_t write(std::string_view bytes) override { return port_->write(bytes); }
  std::size_t queued() const override { return 0; }
  void hold_output(bool) override {}
  void discard_output() override {}
  void set_rts(bool on) override { port_->reading(on); }
  serial::Signals signals() override { return {}; }
  void close() override { port_->close(); }

 private:
  std::shared_ptr<ListeningPort> port_;
};

}  // namespace

std::unique_ptr<serial::Port> make_listening_port(const asio::any_io_executor& executor, std::string address,
                                                  std::uint16_t port) {
  return std::make_unique<OwnedListening>(
      std::make_shared<ListeningPort>(executor, std::move(address), port));
}

}  // namespace headstock::agent

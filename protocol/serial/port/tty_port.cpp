#include <unistd.h>

#include <array>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <cstring>
#include <utility>

#include "protocol/serial/port/mark_decoder.hpp"
#include "protocol/serial/port/ports.hpp"
#include "protocol/serial/port/tty.hpp"

namespace headstock::serial {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// Handshake lines change without a word from the device; looking costs one system call.
constexpr auto kLook = std::chrono::milliseconds(20);

class TtyPort final : public Port, public std::enable_shared_from_this<TtyPort> {
 public:
  TtyPort(const asio::any_io_executor& executor, std::string device, const LineSettings& settings)
      : device_(std::move(device)), settings_(settings), descriptor_(executor), look_(executor) {}

  void open(PortListener& listener) override {
    listener_ = &listener;
    const tty::Opened opened = tty::open(device_, settings_);
    asio::post(descriptor_.get_executor(), [self = shared_from_this(), opened] { self->opened(opened); });
  }

  std::size_t write(std::string_view bytes) override {
    if (!descriptor_.is_open()) return 0;
    const auto count = ::write(descriptor_.native_handle(), bytes.data(), bytes.size());
    const auto written = count > 0 ? static_cast<std::size_t>(count) : 0;
    if (count < 0 && errno != EAGAIN && errno != EINTR) {
      lost(std::strerror(errno));
      return 0;
    }
    if (written < bytes.size() && !waiting_to_write_) {
      waiting_to_write_ = true;
      descriptor_.async_wait(asio::posix::descriptor_base::wait_write,
                             [self = shared_from_this()](error_code error) {
                               self->waiting_to_write_ = false;
                               if (!error && self->listener_ != nullptr) self->listener_->on_writable();
                             });
    }
    return written;
  }

  std::size_t queued() const override { return fd() < 0 ? 0 : tty::queued(fd()); }
  void hold_output(bool hold) override {
    if (fd() >= 0 && hold != std::exchange(held_, hold)) tty::hold(fd(), hold);
  }
  void discard_output() override {
    if (fd() >= 0) tty::discard(fd());
  }
  void set_rts(bool on) override {
    if (fd() >= 0) tty::set_rts(fd(), on);
  }
  Signals signals() override { return fd() < 0 ? Signals{} : tty::signals(fd()); }

  void close() override {
    listener_ = nullptr;
    look_.cancel();
    if (!descriptor_.is_open()) return;
    // A close waits for what is queued, on a stopped line for half a minute: that is thrown away. With nothing queued
    // a transfer is over, and its last characters may still stand in an adapter: those are not touched.
    hold_output(false);
    if (queued() > 0) tty::discard(fd());
    error_code ignored;
    descriptor_.close(ignored);
  }

 private:
  int fd() const {
    return descriptor_.is_open() ? const_cast<TtyPort*>(this)->descriptor_.native_handle() : -1;
  }

  void opened(const tty::Opened& opened) {
    if (listener_ == nullptr) {
      if (opened.fd >= 0) ::close(opened.fd);
      return;
    }
    if (opened.fd < 0) return std::exchange(listener_, nullptr)->on_closed(opened.reason, opened.text);
    descriptor_.assign(opened.fd);
    errors_ = tty::errors(opened.fd);
    seen_ = tty::signals(opened.fd);
    listener_->on_open();
    if (listener_ == nullptr) return;
    if (seen_.known) listener_->on_signals(seen_);
    wait_to_read();
    if (seen_.known || errors_.known) look();
  }

  void wait_to_read() {
    descriptor_.async_wait(asio::posix::descriptor_base::wait_read,
                           [self = shared_from_this()](error_code error) {
                             if (error || self->listener_ == nullptr) return;
                             self->readable();
                           });
  }

  void readable() {
    std::array<char, 4'096> piece;
    const auto count = ::read(fd(), piece.data(), piece.size());
    if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR))
      return lost(count == 0 ? "hung up" : std::strerror(errno));
    if (count > 0) {
      std::string data;
      const auto faults = marks_.put({piece.data(), static_cast<std::size_t>(count)}, data);
      for (const Fault fault : faults) {
        if (listener_ != nullptr) listener_->on_fault(named(fault));
      }
      if (!data.empty() && listener_ != nullptr) listener_->on_bytes(data);
    }
    if (listener_ != nullptr && descriptor_.is_open()) wait_to_read();
  }

  /// The mark in the input says that a character was wrong; the device's counters say how.
  Fault named(Fault fault) {
    const tty::ErrorCounts now = tty::errors(fd());
    if (!now.known || fault == Fault::line_break) return fault;
    const Fault is = now.framing != errors_.framing ? Fault::framing : fault;
    errors_.framing = now.framing;
    errors_.parity = now.parity;
    return is;
  }

  void look() {
    look_.expires_after(kLook);
    look_.async_wait([self = shared_from_this()](error_code error) {
      if (error || self->listener_ == nullptr || !self->descriptor_.is_open()) return;
      const Signals now = tty::signals(self->fd());
      if (now != self->seen_) {
        self->seen_ = now;
        self->listener_->on_signals(now);
      }
      const tty::ErrorCounts counts = tty::errors(self->fd());
      if (counts.known && counts.overrun != self->errors_.overrun && self->listener_ != nullptr) {
        self->errors_.overrun = counts.overrun;
        self->listener_->on_fault(Fault::overrun);
      }
      if (self->listener_ != nullptr) self->look();
    });
  }

  void lost(const std::string& text) {
    PortListener* const listener = listener_;
    close();
    // Not from inside a call of the listener.
    if (listener != nullptr)
      asio::post(descriptor_.get_executor(), [self = shared_from_this(), listener, text, alive = alive_] {
        if (*alive) listener->on_closed("disconnected", text);
      });
  }

  std::string device_;
  LineSettings settings_;
  asio::posix::stream_descriptor descriptor_;
  asio::steady_timer look_;
  PortListener* listener_ = nullptr;
  MarkDecoder marks_;
  tty::ErrorCounts errors_;
  Signals seen_;
  bool waiting_to_write_ = false, held_ = false;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);

 public:
  /// The owner is gone: nothing of it may be called any more.
  void abandon() {
    *alive_ = false;
    close();
  }
};

/// Ends the port with its owner, while handlers under way keep the inside.
class OwnedTty final : public Port {
 public:
  explicit OwnedTty(std::shared_ptr<TtyPort> port) : port_(std::move(port)) {}
  ~OwnedTty() override { port_->abandon(); }
  void open(PortListener& listener) override { port_->open(listener); }
  std::size_t write(std::string_view bytes) override { return port_->write(bytes); }
  std::size_t queued() const override { return port_->queued(); }
  void hold_output(bool hold) override { port_->hold_output(hold); }
  void discard_output() override { port_->discard_output(); }
  void set_rts(bool on) override { port_->set_rts(on); }
  Signals signals() override { return port_->signals(); }
  void close() override { port_->close(); }

 private:
  std::shared_ptr<TtyPort> port_;
};

}  // namespace

std::unique_ptr<Port> make_tty_port(const asio::any_io_executor& executor, std::string device,
                                    const LineSettings& settings) {
  return std::make_unique<OwnedTty>(std::make_shared<TtyPort>(executor, std::move(device), settings));
}

}  // namespace headstock::serial

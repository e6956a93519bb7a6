#include <boost/asio/steady_timer.hpp>
#include <utility>

#include "protocol/serial/port/ports.hpp"
#include "protocol/serial/port/rfc2217.hpp"

namespace headstock::serial {
namespace {

namespace asio = boost::asio;

constexpr auto kAnswerLimit = std::chrono::seconds(5);

class Rfc2217Port final : public Port, private PortListener {
 public:
  Rfc2217Port(const asio::any_io_executor& executor, std::string host, std::uint16_t port,
              const LineSettings& settings)
      : tcp_(make_tcp_port(executor, std::move(host), port)), telnet_(settings), limit_(executor) {}

  void open(PortListener& listener) override {
    listener_ = &listener;
    tcp_->open(*this);
  }

  std::size_t write(std::string_view bytes) override {
    if (!telnet_.ready() || telnet_.suspended() || !waiting_.empty()) return 0;
    waiting_ = Rfc2217::escaped(bytes);
    flush();
    return bytes.size();
  }
  std::size_t queued() const override { return waiting_.size() + tcp_->queued(); }
  void hold_output(bool) override {}
  void discard_output() override {
    waiting_ = telnet_.discard_output();
    flush();
  }
  void set_rts(bool on) override {
    waiting_ += telnet_.set_rts(on);
    flush();
  }
  Signals signals() override { return telnet_.signals(); }
  void close() override {
    listener_ = nullptr;
    limit_.cancel();
    tcp_->close();
  }

 private:
  void flush() {
    const std::size_t count = tcp_->write(waiting_);
    waiting_.erase(0, count);
  }

  void on_open() override {
    waiting_ = telnet_.hello();
    flush();
    limit_.expires_after(kAnswerLimit);
    limit_.async_wait([this](const boost::system::error_code& error) {
      if (!error) end("no_rfc2217", "the server does not answer as RFC 2217 asks");
    });
  }
  void on_bytes(std::string_view bytes) override {
    std::string answer;
    const Rfc2217::Events events = telnet_.put(bytes, answer);
    if (!answer.empty()) {
      waiting_ += answer;
      flush();
    }
    if (!events.refused.empty()) return end(events.refused, "");
    if (events.ready) {
      limit_.cancel();
      listener_->on_open();
    }
    for (const Fault fault : events.faults)
      if (listener_ != nullptr && telnet_.ready()) listener_->on_fault(fault);
    if (events.signals_changed && listener_ != nullptr && telnet_.ready())
      listener_->on_signals(telnet_.signals());
    if (!events.data.empty() && listener_ != nullptr && telnet_.ready()) listener_->on_bytes(events.data);
    if (listener_ != nullptr && telnet_.ready() && waiting_.empty()) listener_->on_writable();
  }
  void on_fault(Fault) override {}
  void on_signals(const Signals&) override {}
  void on_writable() override {
    if (!waiting_.empty()) flush();
    if (waiting_.empty() && listener_ != nullptr && telnet_.ready()) listener_->on_writable();
  }
  void on_closed(const std::string& reason, const std::string& text) override { end(reason, text); }

  void end(const std::string& reason, const std::string& text) {
    limit_.cancel();
    tcp_->close();
    if (PortListener* const listener = std::exchange(listener_, nullptr)) listener->on_closed(reason, text);
  }

  std::unique_ptr<Port> tcp_;
  Rfc2217 telnet_;
  asio::steady_timer limit_;
  PortListener* listener_ = nullptr;
  std::string waiting_;
};

}  // namespace

std::unique_ptr<Port> make_rfc2217_port(const asio::any_io_executor& executor, std::string host,
                                        std::uint16_t port, const LineSettings& settings) {
  return std::make_unique<Rfc2217Port>(executor, std::move(host), port, settings);
}

}  // namespace headstock::serial

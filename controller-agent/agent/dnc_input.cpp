#include "agent/dnc_input.hpp"

#include <array>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <mutex>
#include <utility>

#include "agent/listening_port.hpp"
#include "protocol/process/log.hpp"
#include "protocol/serial/reader.hpp"
#include "protocol/wire/digest.hpp"

namespace headstock::agent {
namespace {

namespace asio = boost::asio;
using program::ReadStatus;
using namespace std::chrono_literals;

/// How long a sender may take to send the rest behind the end of the program, its %.
constexpr auto kFinishWithin = 3s;
/// The next program is offered when the controller has come to the end of the last one.
constexpr auto kOfferAgain = 100ms;
constexpr auto kAskAgain = 1s;

serial::ReaderRules rules_of(const DncSettings& settings) {
  serial::ReaderRules rules;
  rules.code = settings.code;
  rules.software_handshake = settings.line.software();
  rules.hardware_handshake = settings.line.hardware();
  rules.buffer = settings.buffer;
  rules.reserve = settings.after_stop;
  rules.tv_check = settings.tv_check;
  rules.demand_start_mark = !settings.any_start;
  return rules;
}

}  // namespace

std::string_view name_of(DncInput::State state) {
  constexpr std::string_view names[] = {"off", "ready", "reading", "finishing"};
  return names[static_cast<std::size_t>(state)];
}

struct DncInput::Impl final : serial::PortListener, std::enable_shared_from_this<Impl> {
  Impl(asio::any_io_executor the_executor, DncSettings the_settings, Offer the_offer, MakePort the_make_port)
      : executor(std::move(the_executor)),
        settings(std::move(the_settings)),
        offer(std::move(the_offer)),
        make_port(std::move(the_make_port)),
        timer(executor),
        asking(executor),
        reader(rules_of(settings)) {
    if (!make_port) {
      make_port = [this] {
        return settings.address
                   ? serial::make_port(executor, *settings.address, settings.line)
                   : make_listening_port(executor, settings.listen_address, settings.listen_port);
      };
    }
  }

  const asio::any_io_executor executor;
  const DncSettings settings;
  const Offer offer;
  MakePort make_port;
  asio::steady_timer timer, asking;
  std::unique_ptr<serial::Port> port;
  std::string to_write;
  bool rts = true;
  std::uint64_t offers = 0;  ///< a source of an earlier offer has no say any more

  // ---- shared with the look-ahead thread
  mutable std::mutex mutex;
  serial::Reader reader;
  State state = State::off;
  bool open = false;
  std::string reason;
  std::string failed_because;      ///< what the interpreter was told to be the end; the reader forgets it
  std::uint64_t failed_offer = 0;  ///< and of which offer
  std::uint64_t taken = 0;
  wire::Sha256 digest;
  Status last;

  // ---- the port
  void on_open() override {
    {
      const std::scoped_lock lock(mutex);
      open = true;
      // Cycle start may have been quicker than the device.
      if (state == State::reading) reader.start();
    }
    pump();
  }
  void on_bytes(std::string_view bytes) override {
    {
      const std::scoped_lock lock(mutex);
      reader.on_bytes(bytes);
    }
    pump();
  }
  void on_fault(serial::Fault fault) override {
    {
      const std::scoped_lock lock(mutex);
      reader.on_fault(fault);
    }
    pump();
  }
  void on_signals(const serial::Signals& signals) override {
    {
      const std::scoped_lock lock(mutex);
      reader.on_signals(signals);
    }
    pump();
  }
  void on_writable() override { pump(); }
  void on_closed(const std::string& why, const std::string& text) override {
    log::error("DNC input: {}: {} {}", settings.port, why, text);
    {
      const std::scoped_lock lock(mutex);
      open = false;
      reason = why;
      reader.on_fault(serial::Fault::disconnected);
    }
    pump();
  }

  /// Writes what the reader has to say; the only place that does.
  void pump() {
    bool over = false, wants = true, more = false;
    {
      const std::scoped_lock lock(mutex);
      to_write += reader.take_output();
      if (state == State::finishing) {
        more = take_rest();
        to_write += reader.take_output();
        over = more || reader.state() != serial::Reader::State::reading;
      }
      wants = reader.wants_rts();
    }
    if (port) {
      to_write.erase(0, port->write(to_write));
      if (settings.line.hardware() && wants != std::exchange(rts, wants)) port->set_rts(wants);
    }
    if (over) finished(more);
  }

  /// Behind the end of a program comes its % and nothing else. @return something else came: the program was
  /// left in the middle.
  bool take_rest() {
    std::array<char, 256> rest;
    while (const std::size_t count = reader.take(rest)) {
      const std::string_view text(rest.data(), count);
      if (text.find_first_not_of("% \r\n") != std::string_view::npos) return true;
    }
    return false;
  }

  /// A DC1 that came before the sender had opened its side is lost: while nothing comes, it is said again.
  void ask_again() {
    if (!settings.line.software()) return;
    asking.expires_after(kAskAgain);
    asking.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
      const auto self = weak.lock();
      if (error || !self) return;
      {
        const std::scoped_lock lock(self->mutex);
        if (self->state != State::reading || self->reader.received() > 0) return;
        if (self->reader.state() == serial::Reader::State::reading && self->to_write.empty())
          self->to_write += static_cast<char>(tape::dc1);
      }
      self->pump();
      self->ask_again();
    });
  }

  void post_pump() {
    asio::post(executor, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->pump();
    });
  }

  void post_ask_again() {
    asio::post(executor, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->ask_again();
    });
  }

  operation::CommandResult offer_stream();

  // ---- how a program ends (executor's thread)
  /// The interpreter has let go of the stream.
  void let_go(std::uint64_t offered) {
    if (offered != offers) return;
    bool off = false;
    {
      const std::scoped_lock lock(mutex);
      if (state != State::reading) {
        off = state == State::ready;  // another program was chosen before cycle start
      } else {
        last.bytes = taken;
        last.sha256 = digest.hex();
        state = State::finishing;
      }
    }
    if (off) return switch_off("");
    timer.expires_after(kFinishWithin);
    timer.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
      const auto self = weak.lock();
      if (!error && self) self->finished(true);
    });
    pump();
  }

  /// The sender has said its %, or there is more than that, or nothing came.
  void finished(bool left_in_the_middle) {
    std::string outcome;
    {
      const std::scoped_lock lock(mutex);
      if (state != State::finishing) return;
      if (reader.state() == serial::Reader::State::failed)
        outcome = reader.reason();
      else if (left_in_the_middle)
        outcome = "broken_off";
      reader.stop();
      to_write += reader.take_output();
      last.outcome = outcome.empty() ? "drained" : outcome;
      log::info("DNC input: {} characters, sha256 {}, {}", last.bytes, last.sha256, last.outcome);
      state = State::ready;
    }
    timer.cancel();
    if (port) to_write.erase(0, port->write(to_write));
    if (!outcome.empty()) return switch_off(outcome);
    offer_again();
  }

  void offer_again() {
    timer.expires_after(kOfferAgain);
    timer.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
      const auto self = weak.lock();
      if (error || !self) return;
      {
        const std::scoped_lock lock(self->mutex);
        if (self->state != State::ready) return;
      }
      const auto result = self->offer_stream();
      if (result.accepted) return;
      if (result.reason == "running" || result.reason == "resetting") return self->offer_again();
      self->switch_off(result.reason);
    });
  }

  operation::CommandResult switch_on() {
    {
      const std::scoped_lock lock(mutex);
      if (state == State::reading || state == State::finishing) return {false, "running"};
    }
    switch_off("");
    {
      const std::scoped_lock lock(mutex);
      state = State::ready;
      reason.clear();
    }
    const auto result = offer_stream();
    if (!result.accepted) {
      const std::scoped_lock lock(mutex);
      state = State::off;
      return result;
    }
    rts = true;
    port = make_port();
    port->open(*this);
    return result;
  }

  void switch_off(const std::string& why) {
    {
      const std::scoped_lock lock(mutex);
      if (state == State::off) return;
      state = State::off;
      open = false;
      if (!why.empty()) reason = why;
      reader.stop();
      to_write += reader.take_output();
    }
    ++offers;
    timer.cancel();
    asking.cancel();
    if (port) {
      port->write(to_write);
      port->close();
      port.reset();
    }
    to_write.clear();
  }
};

/// What the interpreter reads. Look-ahead thread.
class DncSource final : public program::Source {
 public:
  DncSource(std::shared_ptr<DncInput::Impl> input, std::uint64_t offered)
      : input_(std::move(input)), offered_(offered) {}
  ~DncSource() override {
    asio::post(input_->executor, [weak = std::weak_ptr(input_), offered = offered_] {
      if (const auto input = weak.lock()) input->let_go(offered);
    });
  }

  program::ReadResult read(std::span<char> buffer) override {
    program::ReadResult result{ReadStatus::wait, 0};
    bool tell = false, first = false;
    {
      DncInput::Impl& input = *input_;
      const std::scoped_lock lock(input.mutex);
      if (!begun_) {
        if (input.state != DncInput::State::ready) return {ReadStatus::failed, 0};
        begun_ = true;
        input.state = DncInput::State::reading;
        input.taken = 0;
        input.digest.reset();
        if (input.open) input.reader.start();
        tell = first = true;
      }
      // The port could not be opened, or was lost before anything came.
      const bool idle = input.reader.state() == serial::Reader::State::idle;
      if (input.state != DncInput::State::reading || (idle && !input.reason.empty()))
        return {ReadStatus::failed, 0};
      if (const std::size_t count = input.reader.take(buffer); count > 0) {
        result = {ReadStatus::data, count};
        input.taken += count;
        input.digest.update({buffer.data(), count});
        // The reader may go on asking.
        tell = true;
      } else if (input.reader.state() == serial::Reader::State::failed) {
        result.status = ReadStatus::failed;
        input.failed_because = input.reader.reason();
        input.failed_offer = offered_;
      } else if (input.reader.state() == serial::Reader::State::ended) {
        result.status = ReadStatus::end;
      }
    }
    if (tell) input_->post_pump();
    if (first) input_->post_ask_again();
    return result;
  }
  bool seek(std::uint64_t) override { return false; }

 private:
  std::shared_ptr<DncInput::Impl> input_;
  std::uint64_t offered_;
  bool begun_ = false;
};

operation::CommandResult DncInput::Impl::offer_stream() {
  const std::uint64_t offered = ++offers;
  // Asked when the blocks before the fault have been executed: the line may be closed by then.
  const auto why = [weak = weak_from_this(), offered]() -> std::string {
    const auto self = weak.lock();
    if (!self) return "disconnected";
    const std::scoped_lock lock(self->mutex);
    return self->failed_offer == offered ? self->failed_because : "disconnected";
  };
  auto result = offer(std::make_unique<DncSource>(shared_from_this(), offered), why);
  if (!result.accepted) ++offers;  // the stream that was not taken has nothing to say
  return result;
}

DncInput::DncInput(asio::any_io_executor executor, DncSettings settings, Offer offer, MakePort make_port)
    : impl_(std::make_shared<Impl>(std::move(executor), std::move(settings), std::move(offer),
                                   std::move(make_port))) {}
DncInput::~DncInput() {
  impl_->switch_off("");
}

operation::CommandResult DncInput::switch_on() {
  return impl_->switch_on();
}
void DncInput::switch_off(const std::string& reason) {
  impl_->switch_off(reason);
}
const DncSettings& DncInput::settings() const {
  return impl_->settings;
}

DncInput::Status DncInput::status() const {
  const std::scoped_lock lock(impl_->mutex);
  Status status = impl_->last;
  status.state = impl_->state;
  status.open = impl_->open;
  status.reason = impl_->reason;
  status.received = impl_->reader.received();
  status.buffered = impl_->reader.buffered();
  return status;
}

}  // namespace headstock::agent

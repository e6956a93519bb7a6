#include "protocol/serial/port/line.hpp"

#include <boost/asio/steady_timer.hpp>
#include <optional>
#include <utility>

#include "protocol/tape/code.hpp"

namespace headstock::serial {
namespace {

namespace asio = boost::asio;

constexpr auto kReportEvery = std::chrono::milliseconds(200);
constexpr auto kLoopSilence = std::chrono::seconds(2);
constexpr auto kBacklog = std::chrono::milliseconds(20);
constexpr auto kDeviceFull = std::chrono::milliseconds(2);

std::int64_t unix_ms() {
  using namespace std::chrono;
  return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

std::string words_of(const Signals& signals) {
  std::string text;
  const auto add = [&](bool on, const char* name) {
    if (!on) return;
    if (!text.empty()) text += ' ';
    text += name;
  };
  add(signals.rts, "RTS"), add(signals.dtr, "DTR"), add(signals.cts, "CTS");
  add(signals.dsr, "DSR"), add(signals.dcd, "DCD"), add(signals.ring, "RI");
  return text;
}

struct SendJob {
  Sender sender;
  std::function<void(const SendReport&)> changed;
  std::string text;
  Sender::State told = Sender::State::cancelled;
  Time told_at{};
};

struct ReceiveJob {
  Receiver receiver;
  std::function<std::size_t(std::string_view)> store;
  std::function<void(const ReceiveReport&)> changed;
  std::string text;
  Receiver::State told = Receiver::State::cancelled;
  Time told_at{};
};

struct LoopJob {
  std::string pattern;
  std::size_t sent = 0, back = 0;
  Pacer pacer;
  Time started, last;
  std::optional<Time> first_back;
  LoopReport report;
  std::function<void(const LoopReport&)> done;
};

/// Every character that is not a steering code, in an order that shows stuck and swapped bits.
std::string test_pattern(std::size_t count, unsigned data_bits) {
  std::string pattern;
  const unsigned mask = (1u << data_bits) - 1;
  for (unsigned i = 0; pattern.size() < count; ++i) {
    const auto byte = static_cast<std::uint8_t>((i * 37 + 0x55) & mask);
    if (const auto code = byte & 0x7Fu; byte != 0xFF && (code < 0x11 || code > 0x13))
      pattern += static_cast<char>(byte);
  }
  return pattern;
}

}  // namespace

struct Line::Impl final : PortListener, std::enable_shared_from_this<Impl> {
  Impl(const asio::any_io_executor& the_executor, const PortAddress& the_address,
       const LineSettings& the_settings, LineCallbacks the_callbacks)
      : executor(the_executor),
        address(the_address),
        settings(the_settings),
        callbacks(std::move(the_callbacks)),
        timer(the_executor) {}

  bool busy() const { return sending || receiving || looping; }

  // ---- the port
  void on_open() override {
    open = true;
    monitor.add(MonitorEntry::note, "opened", unix_ms());
    if (callbacks.opened) callbacks.opened();
  }
  void on_bytes(std::string_view bytes) override {
    const auto keep = shared_from_this();
    const Time now = Clock::now();
    monitor.bytes(MonitorEntry::in, bytes, unix_ms());
    if (sending) {
      sending->sender.on_bytes(bytes, now);
    } else if (receiving) {
      take(bytes, now);
    } else if (looping) {
      looped(bytes, now);
    } else if (callbacks.idle_bytes) {
      callbacks.idle_bytes(bytes);
    }
    pump();
  }
  void on_fault(Fault fault) override {
    const auto keep = shared_from_this();
    const Time now = Clock::now();
    monitor.add(MonitorEntry::fault, std::string(name_of(fault)), unix_ms());
    if (sending) sending->sender.on_fault(fault, now);
    if (receiving) receiving->receiver.on_fault(fault, now);
    if (looping && looping->report.reason.empty()) looping->report.reason = name_of(fault);
    pump();
  }
  void on_signals(const Signals& now_are) override {
    const auto keep = shared_from_this();
    signals = now_are;
    monitor.add(MonitorEntry::signals, words_of(now_are), unix_ms());
    if (sending) sending->sender.on_signals(now_are, Clock::now());
    if (callbacks.signals) callbacks.signals(now_are);
    pump();
  }
  void on_writable() override {
    const auto keep = shared_from_this();
    pump();
  }
  void on_closed(const std::string& reason, const std::string& text) override {
    const auto keep = shared_from_this();
    open = false;
    const Time now = Clock::now();
    monitor.add(MonitorEntry::fault, reason, unix_ms());
    if (sending) {
      sending->text = text;
      sending->sender.on_fault(Fault::disconnected, now);
    }
    if (receiving) {
      receiving->text = text;
      receiving->receiver.on_fault(Fault::disconnected, now);
    }
    if (looping) end_loop("disconnected");
    pump();
    timer.cancel();
    if (callbacks.closed) callbacks.closed(reason, text);
  }

  // ---- what to do next; the only place that writes
  void pump() {
    if (sending) pump_sender();
    if (receiving) pump_receiver();
    if (looping) pump_loop();
  }

  std::size_t write(std::string_view bytes) {
    if (!open || bytes.empty()) return 0;
    const std::size_t count = port->write(bytes);
    if (count > 0) monitor.bytes(MonitorEntry::out, bytes.substr(0, count), unix_ms());
    return count;
  }

  void pump_sender() {
    const auto job = sending;
    Sender& sender = job->sender;
    Time now = Clock::now();
    if (open) port->hold_output(sender.hold_device());
    bool full = false;
    while (open && !full) {
      const auto bytes = sender.peek(now, port->queued());
      if (bytes.empty()) break;
      const std::size_t count = write(bytes);
      sender.wrote(count, now);
      full = count < bytes.size();
      now = Clock::now();
    }
    sender.tick(now, open ? port->queued() : 0);
    const bool over = sender.over();
    if (over && open) {
      if (sender.state() != Sender::State::done) port->discard_output();
      port->hold_output(false);
    }
    // The callback may end this line or start the next job.
    if (over) {
      sending = nullptr;
      timer.cancel();
    }
    tell(*job, now);
    if (sender.state() == Sender::State::done && !sender.early().empty() && open && !busy() &&
        callbacks.idle_bytes)
      callbacks.idle_bytes(sender.early());
    if (sending == job) wake_at(full ? now + kDeviceFull : sender.wake(now));
  }

  void tell(SendJob& job, Time now) {
    const auto state = job.sender.state();
    if (state == job.told && now - job.told_at < kReportEvery) return;
    job.told = state;
    job.told_at = now;
    if (!job.changed) return;
    const SendReport report{state, job.sender.reason(), job.text, job.sender.counters(),
                            job.sender.rules().window};
    job.changed(report);
  }

  void take(std::string_view bytes, Time now) {
    std::string data;
    receiving->receiver.on_bytes(bytes, now, data);
    if (!data.empty()) receiving->receiver.on_backlog(receiving->store(data));
  }

  void pump_receiver() {
    const auto job = receiving;
    Receiver& receiver = job->receiver;
    const Time now = Clock::now();
    if (receiver.stopped()) receiver.on_backlog(job->store({}));
    receiver.tick(now);
    to_write += receiver.take_output();
    to_write.erase(0, write(to_write));
    const bool over = receiver.over();
    if (over) {
      receiving = nullptr;
      timer.cancel();
    }
    if (over || receiver.state() != job->told || now - job->told_at >= kReportEvery) {
      job->told = receiver.state();
      job->told_at = now;
      const ReceiveReport report{receiver.state(), receiver.reason(), job->text,
                                 receiver.bytes(), receiver.closed(), receiver.faults()};
      if (job->changed) job->changed(report);
    }
    if (receiving != job) return;
    const Time wake = receiver.stopped() ? now + kBacklog : receiver.wake(now);
    wake_at(to_write.empty() ? wake : now + kDeviceFull);
  }

  void looped(std::string_view bytes, Time now) {
    LoopJob& job = *looping;
    job.last = now;
    if (!job.first_back) {
      job.first_back = now;
      job.report.round_trip_us =
          std::chrono::duration_cast<std::chrono::microseconds>(now - job.started).count();
    }
    for (const char byte : bytes) {
      if (job.report.reason.empty() && (job.back >= job.sent || byte != job.pattern[job.back])) {
        job.report.reason = "wrong_characters";
        job.report.first_wrong = job.back;
      }
      ++job.back;
    }
  }

  void pump_loop() {
    const auto keep = looping;
    LoopJob& job = *keep;
    const Time now = Clock::now();
    if (!job.report.reason.empty()) return end_loop(job.report.reason);
    if (job.back == job.pattern.size()) return end_loop("");
    bool full = false;
    while (open && job.sent < job.pattern.size() && !full) {
      const std::size_t room = job.pacer.room(now);
      if (room == 0) break;
      const auto bytes = std::string_view(job.pattern).substr(job.sent, room);
      const std::size_t count = write(bytes);
      job.pacer.wrote(count, now);
      job.sent += count;
      full = count < bytes.size();
      if (count > 0) job.last = now;
    }
    if (now - std::max(job.last, job.pacer.empty_at()) >= kLoopSilence)
      return end_loop(job.back == 0 ? "nothing_came" : "missing_characters");
    wake_at(job.sent < job.pattern.size() ? (full ? now + kDeviceFull : job.pacer.room_at())
                                          : std::max(job.last, job.pacer.empty_at()) + kLoopSilence);
  }

  void end_loop(const std::string& reason) {
    const auto job = std::exchange(looping, nullptr);
    timer.cancel();
    LoopReport report = job->report;
    report.reason = reason;
    report.ok = reason.empty();
    report.sent = job->sent;
    report.received = job->back;
    const double seconds = std::chrono::duration<double>(job->last - job->started).count();
    report.characters_s = seconds > 0 ? static_cast<double>(job->back) / seconds : 0;
    if (open) port->discard_output();
    if (job->done) job->done(report);
  }

  void wake_at(Time when) {
    timer.expires_at(when);
    timer.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
      const auto self = weak.lock();
      if (!error && self) self->pump();
    });
  }

  asio::any_io_executor executor;
  PortAddress address;
  LineSettings settings;
  LineCallbacks callbacks;
  asio::steady_timer timer;
  std::unique_ptr<Port> port;
  bool open = false;
  Signals signals;
  Monitor monitor;
  std::shared_ptr<SendJob> sending;
  std::shared_ptr<ReceiveJob> receiving;
  std::shared_ptr<LoopJob> looping;
  std::string to_write;
};

Line::Line(const asio::any_io_executor& executor, const PortAddress& address, const LineSettings& settings,
           LineCallbacks callbacks)
    : impl_(std::make_shared<Impl>(executor, address, settings, std::move(callbacks))) {}

Line::~Line() {
  impl_->callbacks = {};
  close();
}

void Line::open() {
  impl_->port = make_port(impl_->executor, impl_->address, impl_->settings);
  impl_->port->open(*impl_);
}

void Line::close() {
  cancel("closed");
  impl_->timer.cancel();
  impl_->open = false;
  impl_->port.reset();
}

bool Line::is_open() const {
  return impl_->open;
}
bool Line::busy() const {
  return impl_->busy();
}
Monitor& Line::monitor() {
  return impl_->monitor;
}
Signals Line::signals() const {
  return impl_->signals;
}

void Line::send(SendRules rules, std::unique_ptr<Source> source,
                std::function<void(const SendReport&)> changed) {
  impl_->sending = std::make_shared<SendJob>(
      SendJob{Sender(std::move(rules), std::move(source), Clock::now()), std::move(changed), {}});
  impl_->sending->sender.on_signals(impl_->signals, Clock::now());
  impl_->pump();
}

void Line::receive(const ReceiveRules& rules, std::function<std::size_t(std::string_view)> store,
                   std::function<void(const ReceiveReport&)> changed) {
  receive_from({}, rules, std::move(store), std::move(changed));
}

void Line::receive_from(std::string_view first, const ReceiveRules& rules,
                        std::function<std::size_t(std::string_view)> store,
                        std::function<void(const ReceiveReport&)> changed) {
  impl_->to_write.clear();
  impl_->receiving = std::make_shared<ReceiveJob>(
      ReceiveJob{Receiver(rules, Clock::now()), std::move(store), std::move(changed), {}});
  if (!first.empty()) impl_->take(first, Clock::now());
  impl_->pump();
}

void Line::loop_test(std::size_t characters, std::function<void(const LoopReport&)> done) {
  const auto& settings = impl_->settings;
  const auto character = std::chrono::duration_cast<Duration>(settings.character_time());
  const Time now = Clock::now();
  impl_->looping = std::make_shared<LoopJob>(LoopJob{test_pattern(characters, settings.data_bits),
                                                     0,
                                                     0,
                                                     Pacer(character, 16),
                                                     now,
                                                     now,
                                                     std::nullopt,
                                                     {},
                                                     std::move(done)});
  impl_->pump();
}

void Line::pause() {
  if (!impl_->sending) return;
  impl_->sending->sender.pause(Clock::now());
  impl_->pump();
}

void Line::resume() {
  if (!impl_->sending) return;
  impl_->sending->sender.resume(Clock::now());
  impl_->pump();
}

void Line::cancel(std::string_view reason) {
  const auto keep = impl_;
  const Time now = Clock::now();
  if (keep->sending) keep->sending->sender.cancel(now, reason);
  if (keep->receiving) keep->receiving->receiver.cancel(now, reason);
  if (keep->looping) keep->end_loop(std::string(reason));
  keep->pump();
}

}  // namespace headstock::serial

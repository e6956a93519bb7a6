#include "server/dnc/port_line.hpp"

#include <algorithm>
#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <utility>

#include "protocol/process/log.hpp"
#include "protocol/serial/port/prompt_thread.hpp"
#include "protocol/tape/code.hpp"

namespace headstock::dnc {

namespace asio = boost::asio;

namespace {

constexpr auto kNoise = std::chrono::seconds(2);
constexpr auto kOpenAgain = std::chrono::seconds(5);

}  // namespace

LineThread::LineThread() : work_(io_.get_executor()) {
  thread_ = std::thread([this] {
    if (!serial::serve_promptly())
      log::info(
          "lines have no priority on this computer (RTPRIO limit): a DC3 may wait behind other work");
    io_.run();
  });
}

LineThread::~LineThread() {
  work_.reset();
  // What was posted before runs first: lines are closed on their own thread.
  asio::post(io_, [this] { io_.stop(); });
  thread_.join();
}

struct PortLine::Impl : std::enable_shared_from_this<Impl> {
  Impl(LineThread& the_lines, asio::any_io_executor the_network, serial::PortAddress the_address,
       PortSettings the_settings, bool listening, PortEvents the_events)
      : lines(the_lines.io()),
        network(std::move(the_network)),
        address(std::move(the_address)),
        settings(std::move(the_settings)),
        listens(listening),
        events(std::move(the_events)),
        again(lines) {}

  /// Runs `work` on the lines' thread.
  template <class F>
  void there(F work) {
    asio::post(lines, [self = shared_from_this(), work = std::move(work)]() mutable {
      if (!self->ended) work(*self);
    });
  }
  /// Runs `work(events)` on the network thread, unless the owner has gone.
  template <class F>
  void back(F work) {
    asio::post(network, [self = shared_from_this(), work = std::move(work)]() mutable {
      if (!self->forgotten) work(self->events);
    });
  }

  // ---- lines' thread
  void tell(std::string state, std::string reason = {}, std::string text = {}) {
    PortState now{std::move(state), std::move(reason), std::move(text),
                  line ? line->signals() : serial::Signals{}};
    last_state = now.state;
    back([now](PortEvents& to) { to.state(now); });
  }

  void open() {
    tell("opening");
    serial::LineCallbacks callbacks;
    callbacks.opened = [this] { opened(); };
    callbacks.closed = [this](const std::string& reason, const std::string& text) { closed(reason, text); };
    callbacks.idle_bytes = [this](std::string_view bytes) { idle(bytes); };
    callbacks.signals = [this](const serial::Signals&) { tell(last_state); };
    line = std::make_unique<serial::Line>(lines.get_executor(), address, settings.link.line,
                                          std::move(callbacks));
    line->open();
  }

  /// Starts `work` when the line is open. `failed` says what became of it otherwise.
  void with_line(std::function<void()> work,
                 std::function<void(const std::string&, const std::string&)> failed) {
    if (line && line->is_open()) {
      tell("busy");
      return work();
    }
    pending = std::move(work);
    pending_failed = std::move(failed);
    again.cancel();
    open();
  }

  void opened() {
    if (pending) {
      tell("busy");
      std::exchange(pending, nullptr)();
    } else {
      tell("listening");
    }
  }

  void closed(const std::string& reason, const std::string& text) {
    tell("failed", reason, text);
    const auto failed = std::exchange(pending_failed, nullptr);
    if (std::exchange(pending, nullptr) && failed) failed(reason, text);
    if (listens) open_again();
  }

  void open_again() {
    again.expires_after(kOpenAgain);
    again.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
      const auto self = weak.lock();
      if (!error && self && !self->ended && !(self->line && self->line->is_open())) self->open();
    });
  }

  /// After a job: a port that does not listen is free for others.
  void rest() {
    if (!line || !line->is_open()) return;
    if (listens) return tell("listening");
    // Not from inside the line's own callback.
    asio::post(lines, [self = shared_from_this()] {
      if (self->ended || !self->line || self->line->busy() || self->pending || self->listens) return;
      self->line->close();
      self->tell("closed");
    });
  }

  void send_failed(const std::string& reason, const std::string& text) {
    serial::SendReport report;
    report.state = serial::Sender::State::failed;
    report.reason = reason;
    report.text = text;
    back([report](PortEvents& to) { to.sending(report); });
  }

  void send(const serial::SendRules& rules, std::shared_ptr<std::unique_ptr<serial::Source>> source) {
    // A listening port may have begun to take a punch.
    if (line && line->busy()) return send_failed("busy", "");
    with_line(
        [this, rules, source] {
          line->send(rules, std::move(*source), [this](const serial::SendReport& report) {
            back([report](PortEvents& to) { to.sending(report); });
            if (report.over()) rest();
          });
        },
        [this](const std::string& reason, const std::string& text) { send_failed(reason, text); });
  }

  void receive(std::string first) {
    const auto text = std::make_shared<std::string>();
    with_line(
        [this, text, first] {
          auto rules = serial::receive_rules(settings.link);
          // A click on the line of a listening port is not the beginning of a long wait.
          if (!first.empty()) rules.start_limit = kNoise;
          line->receive_from(
              first, rules,
              [text](std::string_view bytes) {
                text->append(bytes);
                return std::size_t{0};
              },
              [this, text](const serial::ReceiveReport& report) {
                back([report, text = report.over() ? text : nullptr](PortEvents& to) {
                  to.receiving(report, text);
                });
                if (!report.over()) return;
                deaf = report.reason == "too_large" || report.reason == "never_ends";
                last_idle = serial::Clock::now();
                rest();
              });
        },
        [this](const std::string& reason, const std::string& detail) {
          serial::ReceiveReport report;
          report.state = serial::Receiver::State::failed;
          report.reason = reason;
          report.text = detail;
          back([report](PortEvents& to) { to.receiving(report, nullptr); });
        });
  }

  void idle(std::string_view bytes) {
    if (!listens || !line || line->busy()) return;
    // A control that asks, or stops asking, while nothing is to be sent: no punch begins with that.
    if (std::ranges::all_of(bytes, [](char c) { return (c & 0x7F) == tape::dc1 || (c & 0x7F) == tape::dc3; }))
      return;
    // The rest of a punch that was too much is not the beginning of the next one.
    const auto now = serial::Clock::now();
    const bool still =
        now - std::exchange(last_idle, now) < std::chrono::milliseconds(settings.link.quiet_ms);
    if (deaf && still) return;
    deaf = false;
    receive(std::string(bytes));
  }

  void loop_test(std::size_t characters) {
    with_line(
        [this, characters] {
          line->loop_test(characters, [this](const serial::LoopReport& report) {
            back([report](PortEvents& to) { to.looped(report); });
            rest();
          });
        },
        [this](const std::string& reason, const std::string& text) {
          serial::LoopReport report;
          report.reason = reason;
          report.text = text;
          back([report](PortEvents& to) { to.looped(report); });
        });
  }

  asio::io_context& lines;
  asio::any_io_executor network;
  serial::PortAddress address;
  PortSettings settings;
  bool listens;
  PortEvents events;
  asio::steady_timer again;
  std::unique_ptr<serial::Line> line;
  std::function<void()> pending;
  std::function<void(const std::string&, const std::string&)> pending_failed;
  std::string last_state = "closed";
  bool deaf = false;  ///< until the line has been quiet
  serial::Time last_idle{};
  bool ended = false;      ///< lines' thread
  bool forgotten = false;  ///< network thread
};

PortLine::PortLine(LineThread& lines, asio::any_io_executor network, serial::PortAddress address,
                   PortSettings settings, bool listens, PortEvents events)
    : impl_(std::make_shared<Impl>(lines, std::move(network), std::move(address), std::move(settings),
                                   listens, std::move(events))) {
  if (listens) impl_->there([](Impl& self) { self.open(); });
}

PortLine::~PortLine() {
  impl_->forgotten = true;
  asio::post(impl_->lines, [self = impl_] {
    self->ended = true;
    self->again.cancel();
    self->line.reset();
  });
}

void PortLine::send(serial::SendRules rules, std::unique_ptr<serial::Source> source) {
  const auto shared = std::make_shared<std::unique_ptr<serial::Source>>(std::move(source));
  impl_->there([rules = std::move(rules), shared](Impl& self) { self.send(rules, shared); });
}

void PortLine::receive() {
  impl_->there([](Impl& self) { self.receive({}); });
}

void PortLine::loop_test(std::size_t characters) {
  impl_->there([characters](Impl& self) { self.loop_test(characters); });
}

void PortLine::pause() {
  impl_->there([](Impl& self) {
    if (self.line) self.line->pause();
  });
}

void PortLine::resume() {
  impl_->there([](Impl& self) {
    if (self.line) self.line->resume();
  });
}

void PortLine::cancel(std::string reason) {
  impl_->there([reason = std::move(reason)](Impl& self) {
    const auto failed = std::exchange(self.pending_failed, nullptr);
    if (std::exchange(self.pending, nullptr) && failed) failed(reason, "");
    if (self.line) self.line->cancel(reason);
  });
}

asio::awaitable<MonitorPiece> PortLine::monitor(std::uint64_t after, std::size_t most) {
  const auto self = impl_;
  const auto look = [self, after, most]() -> asio::awaitable<MonitorPiece> {
    MonitorPiece piece;
    if (self->line) {
      piece.entries = self->line->monitor().since(after, most);
      piece.last = self->line->monitor().last();
    }
    co_return piece;
  };
  co_return co_await asio::co_spawn(self->lines, look, asio::use_awaitable);
}

}  // namespace headstock::dnc

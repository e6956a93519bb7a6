// `headstock dnc send|receive|test`: a serial line from this computer, without a server.
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>

#include "offline/offline.hpp"
#include "protocol/process/options.hpp"
#include "protocol/serial/port/line.hpp"
#include "protocol/serial/port/prompt_thread.hpp"
#include "protocol/serial/protocols.hpp"
#include "protocol/tape/punch.hpp"

namespace headstock::offline {
namespace {

using serial::LinkSettings;

struct Options {
  std::string port, protocol = "dc1-dc4", line, code, end_of_block, symbols, file;
  std::optional<std::uint32_t> after_stop, start_limit, hold_limit, leader, trailer, block_delay;
  bool monitor = false, tv = false, no_frame = false, split = false;
  std::uint32_t characters = 1'000;
};

void say(const std::string& text) {
  std::cerr << "headstock dnc: " << text << '\n';
}

/// @return nothing after saying what is wrong.
std::optional<LinkSettings> settings_of(const Options& options) {
  if (serial::protocol_named(options.protocol) == nullptr) {
    say("no protocol " + options.protocol + "; there are:");
    for (const auto& row : serial::protocols())
      std::cerr << "  " << row.name << std::string(12 - std::min<std::size_t>(row.name.size(), 11), ' ')
                << row.en << '\n';
    return std::nullopt;
  }
  LinkSettings settings = serial::default_settings(options.protocol);
  if (!options.line.empty()) {
    const auto line = serial::settings_of(options.line);
    if (!line) return say("--line is not of the form 9600-8-E-1-software: " + options.line), std::nullopt;
    settings.line = *line;
  }
  if (!options.code.empty()) settings.code = *tape::code_named(options.code);
  if (!options.end_of_block.empty()) settings.end_of_block = *tape::end_of_block_named(options.end_of_block);
  if (const auto error = settings.symbols.read(options.symbols); !error.empty())
    return say("--symbols: " + error), std::nullopt;
  settings.pad_for_tv = settings.tv_check = options.tv;
  if (options.no_frame) settings.frame = false;
  settings.after_stop = options.after_stop.value_or(settings.after_stop);
  settings.start_limit_s = options.start_limit.value_or(settings.start_limit_s);
  settings.hold_limit_s = options.hold_limit.value_or(settings.hold_limit_s);
  settings.leader = options.leader.value_or(settings.leader);
  settings.trailer = options.trailer.value_or(settings.trailer);
  settings.block_delay_ms = options.block_delay.value_or(settings.block_delay_ms);
  return settings;
}

/// A file on its way out, encoded piece by piece.
class FileSource final : public serial::Source {
 public:
  FileSource(std::istream& in, const LinkSettings& settings)
      : in_(in), encoder_(serial::punch_format(settings)) {}
  Result read(std::span<char> into) override {
    while (at_ == bytes_.size() && !finished_) fill();
    if (!encoder_.findings().none()) return {Status::failed, 0};
    if (at_ == bytes_.size()) return {Status::end, 0};
    const std::size_t count = bytes_.copy(into.data(), into.size(), at_);
    at_ += count;
    return {Status::data, count};
  }
  std::string reason() const override { return tape::describe(encoder_.findings().kept().front()); }

 private:
  void fill() {
    char piece[4'096];
    in_.read(piece, sizeof piece);
    bytes_.clear();
    at_ = 0;
    encoder_.put({piece, static_cast<std::size_t>(in_.gcount())}, bytes_);
    if (in_.gcount() > 0) return;
    encoder_.finish(bytes_);
    finished_ = true;
  }
  std::istream& in_;
  tape::Encoder encoder_;
  std::string bytes_;
  std::size_t at_ = 0;
  bool finished_ = false;
};

/// An opened line and the loop it runs in. Ctrl-C ends the job at once.
class Session {
 public:
  Session(const Options& options, const LinkSettings& settings, const serial::PortAddress& address)
      : options_(options), settings_(settings) {
    serial::serve_promptly();
    serial::LineCallbacks callbacks;
    callbacks.opened = [this] { opened_ = true, io_.stop(); };
    callbacks.closed = [this](const std::string& reason, const std::string& text) {
      closed_ = reason + (text.empty() ? "" : ": " + text);
      io_.stop();
    };
    line_ = std::make_unique<serial::Line>(io_.get_executor(), address, settings.line, std::move(callbacks));
    signals_.async_wait([this](const boost::system::error_code& error, int) {
      if (!error) line_->cancel();
    });
  }

  bool open() {
    line_->open();
    io_.run();
    io_.restart();
    if (!opened_) say(options_.port + ": " + closed_);
    return opened_;
  }
  serial::Line& line() { return *line_; }
  void run_until(const bool& over) {
    while (!over) {
      io_.run_one();
      if (io_.stopped()) io_.restart();
      if (options_.monitor) print_monitor();
    }
  }

 private:
  void print_monitor() {
    auto& monitor = line_->monitor();
    if (monitor.last() <= shown_ + 1) return;
    for (const auto& entry : monitor.since(shown_, monitor.last() - shown_ - 1)) {
      const bool bytes = entry.kind == serial::MonitorEntry::in || entry.kind == serial::MonitorEntry::out;
      std::cerr << serial::name_of(entry.kind) << ' '
                << (bytes ? serial::readable(entry.data, settings_.code != tape::Code::ascii) : entry.data)
                << '\n';
      shown_ = entry.sequence;
    }
  }

  const Options& options_;
  const LinkSettings& settings_;
  boost::asio::io_context io_;
  boost::asio::signal_set signals_{io_, SIGINT, SIGTERM};
  std::unique_ptr<serial::Line> line_;
  bool opened_ = false;
  std::string closed_;
  std::uint64_t shown_ = 0;
};

int send(const Options& options, const LinkSettings& settings, Session& session) {
  std::ifstream file;
  if (options.file != "-") {
    file.open(options.file, std::ios::binary);
    if (!file) return say(options.file + ": cannot be read"), 1;
  }
  if (!session.open()) return 1;
  bool over = false;
  serial::SendReport last;
  say(std::string(serial::name_of(last.state)));
  session.line().send(serial::send_rules(settings),
                      std::make_unique<FileSource>(options.file == "-" ? std::cin : file, settings),
                      [&](const serial::SendReport& report) {
                        if (report.state != last.state) say(std::string(serial::name_of(report.state)));
                        last = report;
                        over = report.over();
                      });
  session.run_until(over);
  const auto& counters = last.counters;
  std::cerr << counters.bytes << " characters, " << counters.blocks << " blocks, stopped " << counters.stops
            << " times, at most " << counters.most_after_stop << " characters under way at a stop\n";
  if (last.state == serial::Sender::State::done) return 0;
  say(last.reason + (last.text.empty() ? "" : ": " + last.text));
  return 2;
}

int write_received(const Options& options, const LinkSettings& settings, const std::string& bytes) {
  tape::Findings findings;
  const std::string text = tape::decoded(bytes, serial::read_format(settings), &findings);
  for (const auto& finding : findings.kept()) std::cerr << tape::describe(finding) << '\n';
  tape::PunchSplitter splitter;
  splitter.put(text);
  splitter.finish();
  for (const auto& piece : splitter.pieces())
    std::cerr << tape::name_of(piece.kind) << ' ' << tape::punched_name(piece, tape::NameRule::number, "-")
              << ' ' << piece.lines << " lines " << piece.comment << '\n';
  if (!findings.none()) return say("the punch has characters of wrong parity; nothing was written"), 2;
  if (options.file == "-") return std::cout << text << std::flush, 0;
  // Beside, then in place: a file that is there is whole.
  const std::string beside = options.file + ".part";
  std::ofstream out(beside, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  if (!out || std::rename(beside.c_str(), options.file.c_str()) != 0)
    return say(options.file + ": cannot be written"), 1;
  return 0;
}

int receive(const Options& options, const LinkSettings& settings, Session& session) {
  if (!session.open()) return 1;
  bool over = false;
  std::string bytes;
  serial::ReceiveReport last;
  say(std::string(serial::name_of(last.state)));
  session.line().receive(
      serial::receive_rules(settings),
      [&](std::string_view data) {
        bytes += data;
        return std::size_t{0};
      },
      [&](const serial::ReceiveReport& report) {
        if (report.state != last.state) say(std::string(serial::name_of(report.state)));
        last = report;
        over = report.over();
      });
  session.run_until(over);
  std::cerr << last.bytes << " characters" << (last.closed ? "" : ", without an end mark") << '\n';
  if (last.state == serial::Receiver::State::done) return write_received(options, settings, bytes);
  say(last.reason + (last.text.empty() ? "" : ": " + last.text));
  return 2;
}

int test(const Options& options, Session& session) {
  if (!session.open()) return 1;
  bool over = false;
  serial::LoopReport result;
  session.line().loop_test(options.characters, [&](const serial::LoopReport& report) {
    result = report;
    over = true;
  });
  session.run_until(over);
  std::cout << (result.ok ? "ok" : result.reason) << ": " << result.sent << " sent, " << result.received
            << " back, first after " << result.round_trip_us << " us, "
            << static_cast<int>(result.characters_s) << " characters/s\n";
  return result.ok ? 0 : 2;
}

template <class Job>
int with_session(const Options& options, Job job) {
  const auto settings = settings_of(options);
  if (!settings) return 1;
  const auto address = serial::address_of(options.port);
  if (!address) return say("not a port (/dev/…, tcp://HOST:PORT, rfc2217://HOST:PORT): " + options.port), 1;
  Session session(options, *settings, *address);
  return job(*settings, session);
}

void add_options(options::Command command, Options& options) {
  command.option("--port", options.port, "/dev/ttyS0, tcp://HOST:PORT or rfc2217://HOST:PORT").required();
  command.option("--protocol", options.protocol, "dc1-dc4, xon-xoff, plain, rts-cts, lathe-200t …")
      .shows_default();
  command.option("--line", options.line, "Speed, bits, parity, stop bits, handshake: 9600-7-E-2-software");
  command.option("--code", options.code, "iso, eia, ascii").one_of({"iso", "eia", "ascii"});
  command.option("--eob", options.end_of_block, "lf, crlf, lfcrcr, cr")
      .one_of({"lf", "crlf", "lfcrcr", "cr"});
  command.option("--symbols", options.symbols, "EIA holes of macro characters, as #=4C,*=0D");
  command.flag("--tv", options.tv, "TV check: pad what is sent, check what is received");
  command.flag("--no-frame", options.no_frame, "Do not add % lines; they do not end a punch either");
  command.option("--start-limit", options.start_limit,
                 "Seconds to wait for the other side to begin; 0: for ever");
  command.flag("--monitor", options.monitor, "Show every byte both ways");
}

}  // namespace

void add_dnc(options::Command app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  auto dnc = app.add_command("dnc", "Send and receive programs over a serial line of this computer");
  dnc.requires_command();
  auto sending = dnc.add_command("send", "Send a program; done when the last character has left");
  add_options(sending, *options);
  sending.option("--after-stop", options->after_stop, "Characters the control takes after its DC3")
      .between(3, 4'096);
  sending.option("--hold-limit", options->hold_limit, "Seconds a control may stop us; 0: for ever");
  sending.option("--leader", options->leader, "Blank characters in front").between(0, 10'000);
  sending.option("--trailer", options->trailer, "Blank characters behind").between(0, 10'000);
  sending.option("--block-delay", options->block_delay, "Milliseconds of quiet after each block")
      .between(0, 60'000);
  sending.option("FILE", options->file, "Program, - for standard input").required();
  sending.callback([options, &exit_status] {
    exit_status = with_session(*options, [&](const LinkSettings& settings, Session& session) {
      return send(*options, settings, session);
    });
  });
  auto receiving = dnc.add_command("receive", "Receive what a control punches");
  add_options(receiving, *options);
  receiving.option("FILE", options->file, "File to write, - for standard output").required();
  receiving.callback([options, &exit_status] {
    exit_status = with_session(*options, [&](const LinkSettings& settings, Session& session) {
      return receive(*options, settings, session);
    });
  });
  auto loop = dnc.add_command("test", "Loop-back test with a plug that joins RXD and TXD");
  add_options(loop, *options);
  loop.option("--characters", options->characters, "How many").shows_default().between(1, 1'000'000);
  loop.callback([options, &exit_status] {
    exit_status = with_session(
        *options, [&](const LinkSettings&, Session& session) { return test(*options, session); });
  });
}

}  // namespace headstock::offline

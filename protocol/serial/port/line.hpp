// One line in use: opens its port, carries out one job at a time (send, receive, loop-back test), listens in
// between, and shows everything to the monitor. Everything on the thread of the executor; callbacks come from
// there.
//
// A lost port ends the job and the line: nothing is opened again, let alone sent on, by itself.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "protocol/serial/monitor.hpp"
#include "protocol/serial/port/port.hpp"
#include "protocol/serial/receiver.hpp"
#include "protocol/serial/sender.hpp"

namespace headstock::serial {

struct SendReport {
  Sender::State state = Sender::State::waiting;
  std::string reason, text;  ///< message key; what the system said
  SendCounters counters;
  std::uint32_t window = 0;
  bool over() const { return state >= Sender::State::done; }
};

struct ReceiveReport {
  Receiver::State state = Receiver::State::waiting;
  std::string reason, text;
  std::uint64_t bytes = 0;
  bool closed = false;
  std::array<std::uint32_t, fault_kinds> faults{};
  bool over() const { return state >= Receiver::State::done; }
};

/// What came back of the test pattern (a plug that joins RXD and TXD).
struct LoopReport {
  bool ok = false;
  std::string reason, text;  ///< nothing_came, wrong_characters, missing_characters, line_parity …
  std::uint64_t sent = 0, received = 0;
  std::uint64_t first_wrong = 0;   ///< position, from 0
  std::int64_t round_trip_us = 0;  ///< until the first character was back
  double characters_s = 0;
};

struct LineCallbacks {
  std::function<void()> opened;
  std::function<void(const std::string& reason, const std::string& text)> closed;
  std::function<void(std::string_view)> idle_bytes;  ///< came while no job was running, or behind the last of one
  std::function<void(const Signals&)> signals;
};

class Line {
 public:
  Line(const boost::asio::any_io_executor& executor, const PortAddress& address, const LineSettings& settings,
       LineCallbacks callbacks);
  ~Line();

  void open();
  void close();
  bool is_open() const;
  bool busy() const;

  /// Starts a job; the line must be open and not busy. `changed` comes with every change of state, at most
  /// five times a second with progress, and once at the end (report.over()).
  void send(SendRules rules, std::unique_ptr<Source> source, std::function<void(const SendReport&)> changed);
  /// @param store takes data; returns how many bytes it has not put away yet. While the other side is stopped because
  /// of them it is asked again with nothing.
  void receive(const ReceiveRules& rules, std::function<std::size_t(std::string_view)> store,
               std::function<void(const ReceiveReport&)> changed);
  /// Feeds bytes that came while idle into a receive job that begins because of them.
  void receive_from(std::string_view first, const ReceiveRules& rules,
                    std::function<std::size_t(std::string_view)> store,
                    std::function<void(const ReceiveReport&)> changed);
  void loop_test(std::size_t characters, std::function<void(const LoopReport&)> done);

  void pause();
  void resume();
  void cancel(std::string_view reason = "cancelled");

  Monitor& monitor();
  Signals signals() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace headstock::serial

// One port on the lines' thread, for the server's network thread: jobs go in, reports come back on the
// network thread. The line thread does nothing but lines, so that a DC3 is seen at once whatever the server
// is busy with.
//
// A listening port is opened again five seconds after it was lost; jobs never start again by themselves.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "protocol/serial/port/line.hpp"
#include "server/dnc/settings.hpp"

namespace headstock::dnc {

/// The thread of all lines.
class LineThread {
 public:
  LineThread();
  ~LineThread();
  boost::asio::io_context& io() { return io_; }

 private:
  boost::asio::io_context io_;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  std::thread thread_;
};

struct PortState {
  std::string state = "closed";  ///< closed opening listening busy failed
  std::string reason, text;      ///< of failed
  serial::Signals signals;
};

struct PortEvents {
  std::function<void(PortState)> state;
  std::function<void(serial::SendReport)> sending;
  /// The text comes with the last report.
  std::function<void(serial::ReceiveReport, std::shared_ptr<std::string>)> receiving;
  std::function<void(serial::LoopReport)> looped;
};

struct MonitorPiece {
  std::vector<serial::MonitorEntry> entries;
  std::uint64_t last = 0;
};

class PortLine {
 public:
  /// @param events called on `network`; none after destruction.
  PortLine(LineThread& lines, boost::asio::any_io_executor network, serial::PortAddress address,
           PortSettings settings, bool listens, PortEvents events);
  ~PortLine();

  // Network thread. One job at a time: the caller sees to it.
  void send(serial::SendRules rules, std::unique_ptr<serial::Source> source);
  void receive();
  void loop_test(std::size_t characters);
  void pause();
  void resume();
  void cancel(std::string reason);
  boost::asio::awaitable<MonitorPiece> monitor(std::uint64_t after, std::size_t most);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace headstock::dnc

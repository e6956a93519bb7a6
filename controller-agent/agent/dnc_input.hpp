// The machine fed by somebody else's DNC software over its own RS-232 or TCP, executing while it receives
// (FANUC: DNC operation in RMT mode).
//
// A person at the machine switches it on, starts the sender and presses cycle start; the first read of the
// interpreter asks with DC1. What came before a fault on the line is good and is executed block by block;
// then the controller's own alarm stops the machine. A program that did not end properly switches the input
// off: whoever goes on must start machine and sender again, from the beginning.
//
//   off → ready (cycle start asks) → reading → finishing (what the sender still has, up to its %) → ready
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "agent/dnc_settings.hpp"
#include "operation/controller.hpp"
#include "program/source.hpp"

namespace headstock::agent {

class DncInput {
 public:
  enum class State { off, ready, reading, finishing };
  struct Status {
    State state = State::off;
    bool open = false;   ///< the port is
    std::string reason;  ///< why it is off or cannot be read: a message key; empty when nothing is wrong
    std::uint64_t received = 0;  ///< characters of the program under way
    std::size_t buffered = 0;
    // The last program, as its certificate.
    std::uint64_t bytes = 0;  ///< characters the interpreter took
    std::string sha256;       ///< of them
    std::string outcome;      ///< "drained" (the sender came to its %), or why not; empty: none yet
  };
  /// Gives the controller a stream to run from; `why` says what broke it.
  using Offer = std::function<operation::CommandResult(std::unique_ptr<program::Source> stream,
                                                       std::function<std::string()> why)>;
  using MakePort = std::function<std::unique_ptr<serial::Port>()>;

  /// All on the executor's thread, which must run one at a time. @param make_port none: the port of the
  /// settings.
  DncInput(boost::asio::any_io_executor executor, DncSettings settings, Offer offer, MakePort make_port = {});
  ~DncInput();
  DncInput(const DncInput&) = delete;
  DncInput& operator=(const DncInput&) = delete;

  /// @return refused with "running" while a program runs from it, or what the controller said to the stream.
  operation::CommandResult switch_on();
  /// Stops the sender and closes the port. A machine that runs from it gets its input alarm.
  void switch_off(const std::string& reason = {});
  Status status() const;
  const DncSettings& settings() const;

 private:
  friend class DncSource;
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

/// "off" "ready" "reading" "finishing"
std::string_view name_of(DncInput::State state);

}  // namespace headstock::agent

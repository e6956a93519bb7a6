// Sending over a serial line as a state machine without a port: told what comes in and what time it is, it
// says what may go out now. The control on the other side starts, stops and continues it (DC1, DC3, CTS); a
// person pauses or ends it.
//
//   waiting ── DC1 / at once ──▶ sending ⇄ held (DC3, CTS off) ──▶ draining ──▶ done
//   pause ⇄ resume at any time; failed on a fault or when a time limit passes; cancelled by a person
//
// Done means: the last character has left the device, not that it was handed over. A disconnect ends it for
// good: what a control has in its memory then nobody knows, so a person decides where to go on.
//
// A control that has read the % says DC3 and nothing more: behind it nothing is held back.
//
// DC1 and DC3 are taken with and without parity in bit 8 (FANUC sends 11 and 93). One thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "protocol/serial/faults.hpp"
#include "protocol/serial/pacer.hpp"
#include "protocol/serial/settings.hpp"

namespace headstock::serial {

/// Where the bytes come from. read() is called on the line's thread and does not wait.
class Source {
 public:
  enum class Status { data, wait, end, failed };
  struct Result {
    Status status = Status::end;
    std::size_t count = 0;
  };
  virtual ~Source() = default;
  virtual Result read(std::span<char> into) = 0;
  /// Why read() failed: a message key.
  virtual std::string reason() const { return "source_failed"; }
};
/// A text in memory.
std::unique_ptr<Source> text_source(std::string text);

struct SendRules {
  bool wait_for_start = false;  ///< sends on the control's DC1, not before
  bool obey_dc = true;          ///< DC3 stops, DC1 goes on
  bool obey_cts = false;
  Duration character{};      ///< of the line; 0: not paced
  std::uint8_t percent = '%';  ///< as the line's code punches it: what stands behind it is blank
  std::uint32_t window = 8;  ///< most characters under way; below what the control takes after its DC3
  std::string ending;        ///< bytes behind everything (200T: 1A)
  Duration start_limit = std::chrono::minutes(10);  ///< for the first DC1 or CTS; 0: no limit
  Duration hold_limit{};  ///< for one stop; 0: no limit (a drip-fed control may hold long)
  Duration drain_limit = std::chrono::seconds(30);
  Duration block_delay{};     ///< after each end of block, for controls without any handshake
  bool faults_end_it = true;  ///< parity, framing, overrun, break: a lost DC3 would overrun the control
};

struct SendCounters {
  std::uint64_t bytes = 0;              ///< handed to the line
  std::uint64_t blocks = 0;             ///< ends of block among them
  std::uint32_t stops = 0, starts = 0;  ///< DC3 and DC1 seen
  std::uint32_t unexpected = 0;         ///< other bytes from the control
  std::array<std::uint32_t, fault_kinds> faults{};
  std::uint32_t most_after_stop = 0;  ///< worst number of characters under way when a DC3 was seen
  Duration held{}, longest_hold{};    ///< by the control
  Duration starved{};                 ///< allowed to send, line idle: we were late
  Duration longest_stop{};            ///< from a DC3 until the last character under way was out
  Duration sending{};                 ///< allowed to send and sending
};

class Sender {
 public:
  enum class State { waiting, sending, held, paused, draining, done, failed, cancelled };

  Sender(SendRules rules, std::unique_ptr<Source> source, Time now);

  // ---- what happens
  void on_bytes(std::string_view bytes, Time now);
  void on_signals(const Signals& signals, Time now);
  void on_fault(Fault fault, Time now);
  void pause(Time now);
  void resume(Time now);
  /// Ends it now; what is still queued in the device should be discarded.
  void cancel(Time now, std::string_view reason = "cancelled");
  /// Looks at the time limits. Call at wake() at the latest.
  void tick(Time now, std::size_t device_queue);

  // ---- what to do
  /// What may be handed over now (empty: nothing). @param device_queue bytes the device says it still has.
  std::string_view peek(Time now, std::size_t device_queue);
  void wrote(std::size_t count, Time now);
  /// When to call again if nothing happens.
  Time wake(Time now) const;
  /// Stop the device's own queue: a DC3 came or a person paused.
  bool hold_device() const { return state_ == State::held || state_ == State::paused; }

  State state() const { return state_; }
  bool over() const { return state_ == State::done || state_ == State::failed || state_ == State::cancelled; }
  /// Message key of failed and cancelled: no_start, held_too_long, not_drained, line_parity, disconnected …
  const std::string& reason() const { return reason_; }
  const SendCounters& counters() const { return counters_; }
  const SendRules& rules() const { return rules_; }
  /// What the control said after everything had been handed over, without DC1 and DC3: it may have read the last
  /// block and begun its next punch before the device says that it is done.
  const std::string& early() const { return early_; }

 private:
  void decide(Time now);
  /// Everything has been handed over, or what is left no control reads.
  bool nothing_left() const;
  void enter(State state, Time now);
  void fail(std::string_view reason, Time now);
  bool control_allows() const { return started_ && !stopped_ && (!rules_.obey_cts || cts_); }
  void refill();

  SendRules rules_;
  std::unique_ptr<Source> source_;
  Pacer pacer_;
  State state_ = State::waiting;
  std::string reason_;
  SendCounters counters_;
  std::string buffer_, early_;
  std::size_t at_ = 0;
  bool ended_ = false;     ///< the source has nothing more than buffer_
  bool end_mark_ = false;  ///< the last character handed over was a %, but for line ends and blank tape
  bool started_, stopped_ = false, cts_ = true, paused_ = false;
  Time since_, not_before_{}, last_progress_;
};

/// "waiting", "sending" …
std::string_view name_of(Sender::State state);

}  // namespace headstock::serial

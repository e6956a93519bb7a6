// The tape reader's side of a DNC line: a control that is fed by somebody else's DNC software while it runs
// (RMT mode). Asks with DC1, stops the other side with DC3 before its buffer is full, goes on with DC1, and
// stops it at the final %.
//
// A state machine without a port; one thread. The buffer takes `reserve` characters after a DC3 and no more:
// what comes beyond is the control's buffer overflow alarm (FANUC PS0087), never a lost character.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/serial/faults.hpp"
#include "protocol/serial/pacer.hpp"
#include "protocol/serial/settings.hpp"
#include "protocol/tape/code.hpp"

namespace headstock::serial {

struct ReaderRules {
  tape::Code code = tape::Code::ascii;
  tape::Symbols symbols;
  bool software_handshake = true;   ///< DC1 and DC3
  bool hardware_handshake = false;  ///< RTS off instead of, or beside, DC3
  std::size_t buffer = 8'192;       ///< characters
  std::size_t reserve = 10;         ///< taken after a DC3 at most (PS0087)
  bool tv_check = false;
  /// What comes must begin with a line that has a %: the rest of a program that was broken off before, which the other
  /// side still holds, is not run from its middle.
  bool demand_start_mark = false;
};

class Reader {
 public:
  enum class State { idle, reading, ended, failed };

  explicit Reader(const ReaderRules& rules);
  /// The machine wants data: sends DC1.
  void start();
  /// The machine has been reset: stops the other side and forgets what is buffered.
  void stop();
  void on_bytes(std::string_view bytes);
  void on_fault(Fault fault);
  void on_signals(const Signals& signals);

  /// Program text for the interpreter; moves the buffer on and lets the other side go on when there is room.
  std::size_t take(std::span<char> into);
  std::size_t buffered() const { return filled_; }
  /// Steering codes to be written now.
  std::string take_output();
  bool wants_rts() const { return state_ == State::reading && !stopped_; }

  State state() const { return state_; }
  /// What the control's alarm says: buffer_overflow (PS0087), line_parity … (PS0085), line_framing (PS1823),
  /// dr_off (PS0086), th (PS0001), tv (PS0002), no_start_mark.
  const std::string& reason() const { return reason_; }
  std::uint64_t received() const { return received_; }
  std::uint32_t most_after_stop() const { return most_after_stop_; }

 private:
  void fail(std::string_view reason);
  void one(std::uint8_t byte);
  void put(char character);
  void ask_stop();
  void ask_more();

  ReaderRules rules_;
  tape::CharacterSet set_;
  State state_ = State::idle;
  std::string reason_, output_;
  std::vector<char> ring_;
  std::size_t begin_ = 0, filled_ = 0;
  bool stopped_ = true;
  bool label_ = true;  ///< label skip: until the first end of block
  bool start_mark_ = false;  ///< a % in the label
  bool line_empty_ = true;
  bool dsr_seen_ = false;
  std::uint64_t received_ = 0, block_characters_ = 0;
  std::uint32_t after_stop_ = 0, most_after_stop_ = 0;
};

std::string_view name_of(Reader::State state);

}  // namespace headstock::serial

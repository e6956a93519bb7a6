// Receiving what a control punches, as a state machine without a port.
//
//   waiting ── DC2 / first character ──▶ receiving ── DC4 / end byte / quiet ──▶ done
//
// A character with a line fault makes the whole transfer failed: what is kept is what the control sent, or
// nothing. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/serial/faults.hpp"
#include "protocol/serial/pacer.hpp"
#include "protocol/serial/settings.hpp"

namespace headstock::serial {

struct ReceiveRules {
  bool punch_codes =
      true;          ///< DC2 starts, DC4 ends (with parity or without); a control without them is taken too
  bool iso = false;  ///< bit 8 is parity: DC3 is 93 too (in ASCII 93 may be half of a Chinese character)
  bool obey_percent = true;  ///< the second % line and a short quiet end it, before `quiet` has passed
  bool ask = false;          ///< sends DC1 so that the other side begins
  std::optional<std::uint8_t> end_byte;      ///< 200T: 1A
  std::uint8_t percent = '%';                ///< as it comes over the line: A5 in ISO, 0B in EIA
  std::uint8_t end_of_block = '\n';          ///< 80 in EIA
  Duration quiet = std::chrono::seconds(5);  ///< nothing more for so long: the other side has finished
  Duration quiet_after_percent = std::chrono::milliseconds(500);
  Duration start_limit = std::chrono::minutes(10);  ///< 0: no limit
  Duration total_limit{};                           ///< from the first character on; 0: no limit
  std::uint64_t most_bytes = 16ull << 20;
  bool software_handshake = true;  ///< DC3 and DC1 to the sender when bytes cannot be stored fast enough
  std::size_t backlog_high = 1u << 20, backlog_low = 256u << 10;
};

class Receiver {
 public:
  enum class State { waiting, receiving, done, failed, cancelled };

  Receiver(const ReceiveRules& rules, Time now);

  /// Takes what came. Data are appended to `data`, without the steering codes.
  void on_bytes(std::string_view bytes, Time now, std::string& data);
  void on_fault(Fault fault, Time now);
  /// Bytes taken but not stored yet.
  void on_backlog(std::size_t bytes);
  void cancel(Time now, std::string_view reason = "cancelled");
  void tick(Time now);
  /// We have asked the other side to stop: on_backlog() has to be told when there is room again.
  bool stopped() const { return stopped_; }
  /// Steering codes to be written now; empty when none.
  std::string take_output();
  Time wake(Time now) const;

  State state() const { return state_; }
  bool over() const { return state_ >= State::done; }
  /// nothing_came, too_large, never_ends, line_parity, disconnected, cancelled …
  const std::string& reason() const { return reason_; }
  /// Whether the punch ended as it should (DC4, end byte, second %), or only fell silent.
  bool closed() const { return closed_; }
  std::uint64_t bytes() const { return bytes_; }
  const std::array<std::uint32_t, fault_kinds>& faults() const { return faults_; }

 private:
  void end(State state, std::string_view reason, Time now);
  void finish(Time now);
  void data_byte(char byte, std::string& data);

  ReceiveRules rules_;
  State state_ = State::waiting;
  std::string reason_, fault_reason_, output_;
  std::uint64_t bytes_ = 0;
  std::array<std::uint32_t, fault_kinds> faults_{};
  bool closed_ = false, stopped_ = false, line_start_ = true, percent_line_ = false;
  unsigned percents_ = 0;
  std::uint64_t significant_ = 0;
  Time since_, last_byte_, began_{};
};

std::string_view name_of(Receiver::State state);

}  // namespace headstock::serial

#include "protocol/serial/receiver.hpp"

#include <algorithm>
#include <utility>

#include "protocol/tape/code.hpp"

namespace headstock::serial {
namespace {

bool is_code(char byte, std::uint8_t code, bool iso) {
  const auto value = static_cast<std::uint8_t>(byte);
  return value == code || (iso && value == tape::with_even_parity(code));
}

}  // namespace

std::string_view name_of(Receiver::State state) {
  constexpr std::string_view names[] = {"waiting", "receiving", "done", "failed", "cancelled"};
  return names[static_cast<std::size_t>(state)];
}

Receiver::Receiver(const ReceiveRules& rules, Time now) : rules_(rules), since_(now), last_byte_(now) {
  if (rules_.ask) output_ += static_cast<char>(tape::dc1);
}

void Receiver::end(State state, std::string_view reason, Time now) {
  if (over()) return;
  state_ = state;
  reason_ = reason;
  since_ = now;
  if (stopped_) output_ += static_cast<char>(tape::dc1);  // never leave the other side stopped
  stopped_ = false;
}

void Receiver::finish(Time now) {
  if (!fault_reason_.empty()) return end(State::failed, fault_reason_, now);
  end(State::done, "", now);
}

void Receiver::data_byte(char byte, std::string& data) {
  const auto value = static_cast<std::uint8_t>(byte);
  ++bytes_;
  data += byte;
  if (value == 0 || value == 0x7F || value == 0xFF) return;  // leader, trailer
  ++significant_;
  if (value == rules_.end_of_block) {
    line_start_ = true;
  } else if (line_start_) {
    line_start_ = (value & 0x7F) == '\r';
    if (value == rules_.percent) ++percents_;
  }
}

void Receiver::on_bytes(std::string_view bytes, Time now, std::string& data) {
  for (const char byte : bytes) {
    if (over()) return;
    last_byte_ = now;
    if (began_ == Time{}) began_ = now;
    if (rules_.punch_codes && is_code(byte, tape::dc2, rules_.iso)) {
      if (state_ == State::waiting) state_ = State::receiving;
      continue;
    }
    if (rules_.punch_codes && is_code(byte, tape::dc4, rules_.iso)) {
      if (significant_ == 0) continue;
      closed_ = true;
      return finish(now);
    }
    if (is_code(byte, tape::dc1, rules_.iso) || is_code(byte, tape::dc3, rules_.iso))
      continue;  // the other side's reader, not data
    if (rules_.end_byte && static_cast<std::uint8_t>(byte) == *rules_.end_byte) {
      if (significant_ == 0) continue;
      closed_ = true;
      return finish(now);
    }
    state_ = State::receiving;
    data_byte(byte, data);
    if (bytes_ > rules_.most_bytes) return end(State::failed, "too_large", now);
  }
}

void Receiver::on_fault(Fault fault, Time now) {
  ++faults_[static_cast<std::size_t>(fault)];
  if (fault == Fault::disconnected) return end(State::failed, name_of(fault), now);
  if (fault_reason_.empty()) fault_reason_ = name_of(fault);
  // Noise before anything came (a control being switched on) is not part of a punch.
  if (state_ == State::waiting) fault_reason_.clear();
}

void Receiver::on_backlog(std::size_t bytes) {
  if (!rules_.software_handshake || over()) return;
  if (!stopped_ && bytes >= rules_.backlog_high) {
    stopped_ = true;
    output_ += static_cast<char>(tape::dc3);
  } else if (stopped_ && bytes <= rules_.backlog_low) {
    stopped_ = false;
    output_ += static_cast<char>(tape::dc1);
  }
}

void Receiver::cancel(Time now, std::string_view reason) {
  end(State::cancelled, reason, now);
}

void Receiver::tick(Time now) {
  if (over()) return;
  if (rules_.total_limit > Duration::zero() && began_ != Time{} && now - began_ >= rules_.total_limit)
    return end(State::failed, "never_ends", now);
  if (significant_ == 0) {
    if (rules_.start_limit > Duration::zero() && now - since_ >= rules_.start_limit)
      end(State::failed, fault_reason_.empty() ? "nothing_came" : fault_reason_, now);
    return;
  }
  if (stopped_) return;  // it is silent because we asked it to be
  const bool percent_done = rules_.obey_percent && percents_ >= 2;
  if (now - last_byte_ < (percent_done ? rules_.quiet_after_percent : rules_.quiet)) return;
  closed_ = percent_done;
  finish(now);
}

std::string Receiver::take_output() {
  return std::exchange(output_, {});
}

Time Receiver::wake(Time now) const {
  constexpr auto idle = std::chrono::seconds(1);
  if (over() || stopped_) return now + idle;
  if (significant_ == 0)
    return rules_.start_limit > Duration::zero() ? std::min(since_ + rules_.start_limit, now + idle)
                                                 : now + idle;
  const bool percent_done = rules_.obey_percent && percents_ >= 2;
  return last_byte_ + (percent_done ? rules_.quiet_after_percent : rules_.quiet);
}

}  // namespace headstock::serial

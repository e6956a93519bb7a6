#include "protocol/serial/reader.hpp"

#include <algorithm>
#include <utility>

namespace headstock::serial {

std::string_view name_of(Reader::State state) {
  constexpr std::string_view names[] = {"idle", "reading", "ended", "failed"};
  return names[static_cast<std::size_t>(state)];
}

Reader::Reader(const ReaderRules& rules) : rules_(rules), set_(rules.code, rules.symbols) {
  rules_.buffer = std::max<std::size_t>(rules_.buffer, 2 * rules_.reserve + 2);
  ring_.resize(rules_.buffer);
}

void Reader::ask_stop() {
  if (std::exchange(stopped_, true)) return;
  after_stop_ = 0;
  if (rules_.software_handshake) {
    const std::uint8_t stop = tape::dc3;
    const std::uint8_t code = rules_.code == tape::Code::ascii ? stop : tape::with_even_parity(stop);
    output_ += static_cast<char>(code);
  }
}

void Reader::ask_more() {
  if (!std::exchange(stopped_, false)) return;
  if (rules_.software_handshake) output_ += static_cast<char>(tape::dc1);
}

void Reader::start() {
  if (state_ == State::reading) return;
  state_ = State::reading;
  reason_.clear();
  begin_ = filled_ = 0;
  label_ = line_empty_ = true;
  start_mark_ = false;
  dsr_seen_ = false;
  received_ = block_characters_ = 0;
  stopped_ = true;
  ask_more();
}

void Reader::stop() {
  if (state_ == State::reading) ask_stop();
  state_ = State::idle;
  begin_ = filled_ = 0;
}

void Reader::fail(std::string_view reason) {
  if (state_ != State::reading) return;
  ask_stop();
  state_ = State::failed;
  reason_ = reason;
}

void Reader::put(char character) {
  ring_[(begin_ + filled_) % ring_.size()] = character;
  ++filled_;
  if (ring_.size() - filled_ <= rules_.reserve) ask_stop();
}

void Reader::one(std::uint8_t byte) {
  ++received_;
  if (stopped_) {
    most_after_stop_ = std::max(most_after_stop_, ++after_stop_);
    // The control counts from its DC3, whether there happens to be room or not.
    if (after_stop_ > rules_.reserve || filled_ == ring_.size()) return fail("buffer_overflow");
  }
  const tape::Meaning meaning = set_.meaning_of(byte);
  if (meaning.kind == tape::Meaning::wrong_parity) {
    // Parity is not looked at in the leader, which may be a title punched in letters of holes.
    return label_ ? void() : fail("th");
  }
  if (meaning.kind != tape::Meaning::character) return;
  const char character = meaning.value;
  ++block_characters_;
  if (label_) {
    start_mark_ |= character == '%';
    if (character != '\n') return;
    if (rules_.demand_start_mark && !start_mark_) return fail("no_start_mark");
    label_ = false;
    block_characters_ = 0;
    return;
  }
  if (character == '\n') {
    if (rules_.tv_check && block_characters_ % 2 != 0) return fail("tv");
    block_characters_ = 0;
  }
  if (line_empty_ && character == '%') {
    put(character);
    put('\n');
    ask_stop();
    state_ = State::ended;
    return;
  }
  line_empty_ = character == '\n' || (line_empty_ && character == ' ');
  put(character);
}

void Reader::on_bytes(std::string_view bytes) {
  for (const char byte : bytes) {
    if (state_ != State::reading) return;
    one(static_cast<std::uint8_t>(byte));
  }
}

void Reader::on_fault(Fault fault) {
  fail(name_of(fault));
}

void Reader::on_signals(const Signals& signals) {
  if (!signals.known) return;
  if (signals.dsr) dsr_seen_ = true;
  if (dsr_seen_ && !signals.dsr) fail("dr_off");
}

std::size_t Reader::take(std::span<char> into) {
  const std::size_t count = std::min(into.size(), filled_);
  for (std::size_t i = 0; i < count; ++i) into[i] = ring_[(begin_ + i) % ring_.size()];
  begin_ = (begin_ + count) % ring_.size();
  filled_ -= count;
  if (state_ == State::reading && stopped_ && filled_ <= ring_.size() / 2) ask_more();
  return count;
}

std::string Reader::take_output() {
  return std::exchange(output_, {});
}

}  // namespace headstock::serial

#include "protocol/serial/sender.hpp"

#include <algorithm>
#include <cstring>

#include "protocol/tape/code.hpp"

namespace headstock::serial {
namespace {

constexpr std::size_t kPiece = 16'384;
/// Read so far ahead that the end is known before it is handed over: more than the blank tape behind a program.
constexpr std::size_t kAhead = 12'288;
/// What a control can say while the last characters to it are on the wire: far less than this.
constexpr std::size_t kMostEarly = 4'096;
constexpr std::uint8_t kSevenBits = 0x7F;

class TextSource final : public Source {
 public:
  explicit TextSource(std::string text) : text_(std::move(text)) {}
  Result read(std::span<char> into) override {
    const std::size_t count = std::min(into.size(), text_.size() - at_);
    if (count == 0) return {Status::end, 0};
    std::memcpy(into.data(), text_.data() + at_, count);
    at_ += count;
    return {Status::data, count};
  }

 private:
  std::string text_;
  std::size_t at_ = 0;
};

/// An end of block in ASCII, ISO or EIA.
bool ends_block(char byte) {
  return byte == '\n' || static_cast<std::uint8_t>(byte) == 0x80;
}

/// Line ends and blank tape, in ASCII, ISO or EIA: nothing that a control reads behind the end mark.
bool is_blank(char byte) {
  const auto code = static_cast<std::uint8_t>(byte);
  return code == 0 || code == '\n' || code == '\r' || code == 0x80 || code == 0x8D;
}

}  // namespace

std::unique_ptr<Source> text_source(std::string text) {
  return std::make_unique<TextSource>(std::move(text));
}

std::string_view name_of(Sender::State state) {
  constexpr std::string_view names[] = {"waiting",  "sending", "held",   "paused",
                                        "draining", "done",    "failed", "cancelled"};
  return names[static_cast<std::size_t>(state)];
}

Sender::Sender(SendRules rules, std::unique_ptr<Source> source, Time now)
    : rules_(std::move(rules)),
      source_(std::move(source)),
      pacer_(rules_.character, rules_.window),
      started_(!rules_.wait_for_start),
      since_(now),
      last_progress_(now) {
  decide(now);
}

void Sender::enter(State state, Time now) {
  if (state_ == state) return;
  if (state_ == State::held) {
    counters_.held += now - since_;
    counters_.longest_hold = std::max(counters_.longest_hold, now - since_);
  }
  if (state_ == State::sending) counters_.sending += now - since_;
  state_ = state;
  since_ = now;
  if (state == State::sending) last_progress_ = now;
}

void Sender::decide(Time now) {
  if (over()) return;
  // Once everything is handed over a DC3 (a control sends one when it has read the %) holds nothing back any
  // more, unless the device still has characters: then it is stopped like before.
  if (paused_) return enter(State::paused, now);
  if (!started_ || (rules_.obey_cts && !cts_ && counters_.bytes == 0)) return enter(State::waiting, now);
  if (control_allows() && state_ != State::draining) return enter(State::sending, now);
  refill();
  if (!nothing_left()) return enter(control_allows() ? State::sending : State::held, now);
  at_ = buffer_.size();
  enter(State::draining, now);
}

bool Sender::nothing_left() const {
  if (!ended_ || !reason_.empty()) return false;
  const auto rest = std::string_view(buffer_).substr(at_);
  return rest.empty() || (end_mark_ && std::all_of(rest.begin(), rest.end(), is_blank));
}

void Sender::fail(std::string_view reason, Time now) {
  if (over()) return;
  reason_ = reason;
  enter(State::failed, now);
}

void Sender::on_bytes(std::string_view bytes, Time now) {
  for (const char byte : bytes) {
    const auto code = static_cast<std::uint8_t>(static_cast<std::uint8_t>(byte) & kSevenBits);
    if (code == tape::dc3 && rules_.obey_dc) {
      ++counters_.stops;
      counters_.most_after_stop =
          std::max(counters_.most_after_stop, static_cast<std::uint32_t>(pacer_.in_flight(now)));
      if (pacer_.empty_at() > now)
        counters_.longest_stop = std::max(counters_.longest_stop, pacer_.empty_at() - now);
      stopped_ = true;
    } else if (code == tape::dc1 && (rules_.obey_dc || rules_.wait_for_start)) {
      ++counters_.starts;
      started_ = true;
      stopped_ = false;
    } else if (state_ == State::draining && early_.size() < kMostEarly) {
      early_ += byte;
    } else {
      ++counters_.unexpected;
    }
  }
  decide(now);
}

void Sender::on_signals(const Signals& signals, Time now) {
  cts_ = !signals.known || signals.cts;
  decide(now);
}

void Sender::on_fault(Fault fault, Time now) {
  ++counters_.faults[static_cast<std::size_t>(fault)];
  if (fault == Fault::disconnected || rules_.faults_end_it) fail(name_of(fault), now);
}

void Sender::pause(Time now) {
  paused_ = true;
  decide(now);
}

void Sender::resume(Time now) {
  paused_ = false;
  decide(now);
}

void Sender::cancel(Time now, std::string_view reason) {
  if (over()) return;
  reason_ = reason;
  enter(State::cancelled, now);
}

void Sender::refill() {
  if (ended_ || buffer_.size() - at_ > kAhead) return;
  buffer_.erase(0, at_);
  at_ = 0;
  while (!ended_ && buffer_.size() < kPiece) {
    const std::size_t had = buffer_.size();
    buffer_.resize(kPiece);
    const auto result = source_->read({buffer_.data() + had, kPiece - had});
    buffer_.resize(had + (result.status == Source::Status::data ? result.count : 0));
    if (result.status == Source::Status::wait) return;
    ended_ = result.status != Source::Status::data;
    if (result.status == Source::Status::failed) reason_ = source_->reason();
    if (result.status == Source::Status::end) buffer_ += rules_.ending;
  }
}

std::string_view Sender::peek(Time now, std::size_t device_queue) {
  if (state_ != State::sending || now < not_before_) return {};
  refill();
  if (at_ == buffer_.size()) {
    if (!ended_) return {};
    if (!reason_.empty()) {
      fail(std::string(reason_), now);
    } else {
      enter(State::draining, now);
    }
    return {};
  }
  // A device that is slower than its nominal speed is believed rather than the clock.
  const std::size_t room = pacer_.room(now);
  const std::size_t beyond = device_queue > pacer_.in_flight(now) ? device_queue - pacer_.in_flight(now) : 0;
  if (room <= beyond) return {};
  std::size_t count = std::min(room - beyond, buffer_.size() - at_);
  if (rules_.block_delay > Duration::zero()) {
    for (std::size_t ahead = 0; ahead < count; ++ahead)
      if (ends_block(buffer_[at_ + ahead])) count = ahead + 1;
  }
  return std::string_view(buffer_).substr(at_, count);
}

void Sender::wrote(std::size_t count, Time now) {
  if (count == 0) return;
  if (counters_.bytes > 0 && rules_.character > Duration::zero()) {
    const Time idle_since = std::max({pacer_.empty_at(), last_progress_, not_before_});
    if (now > idle_since) counters_.starved += now - idle_since;
  }
  pacer_.wrote(count, now);
  for (std::size_t i = 0; i < count; ++i) {
    const char byte = buffer_[at_ + i];
    if (!is_blank(byte)) end_mark_ = static_cast<std::uint8_t>(byte) == rules_.percent;
    if (ends_block(byte)) {
      ++counters_.blocks;
      if (rules_.block_delay > Duration::zero()) not_before_ = pacer_.empty_at() + rules_.block_delay;
    }
  }
  counters_.bytes += count;
  at_ += count;
}

void Sender::tick(Time now, std::size_t device_queue) {
  const auto passed = [&](Duration limit) { return limit > Duration::zero() && now - since_ >= limit; };
  if (state_ == State::waiting && passed(rules_.start_limit)) return fail("no_start", now);
  if (state_ == State::held && passed(rules_.hold_limit)) return fail("held_too_long", now);
  if (state_ != State::draining) return;
  if (device_queue == 0 && now >= pacer_.empty_at()) return enter(State::done, now);
  if (now >= std::max(pacer_.empty_at(), since_) + rules_.drain_limit) fail("not_drained", now);
}

Time Sender::wake(Time now) const {
  constexpr auto idle = std::chrono::seconds(1);
  constexpr auto while_draining = std::chrono::milliseconds(5);
  const auto limit = [&](Duration time) {
    return time > Duration::zero() ? std::min(since_ + time, now + idle) : now + idle;
  };
  switch (state_) {
    case State::waiting:
      return limit(rules_.start_limit);
    case State::held:
      return limit(rules_.hold_limit);
    case State::sending:
      return std::max(std::max(pacer_.room_at(), not_before_), now);
    case State::draining:
      return std::max(pacer_.empty_at(), now + while_draining);
    default:
      return now + idle;
  }
}

}  // namespace headstock::serial

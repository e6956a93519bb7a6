// How much has been handed to the line and is not yet on the wire, by the line's own speed: an operating
// system or a serial-device server takes far more than it has sent, and what it holds cannot be called back
// after a DC3. So no more is handed over than a control can still take after its DC3 (FANUC: 10 characters,
// PS0087).
//
// One thread; time is given, so that tests run without a clock.
#pragma once

#include <chrono>
#include <cstdint>

namespace headstock::serial {

using Clock = std::chrono::steady_clock;
using Time = Clock::time_point;
using Duration = Clock::duration;

class Pacer {
 public:
  /// @param character time of one on the wire; 0: not paced, `window` at a time.
  /// @param window most characters under way, at least 1.
  Pacer(Duration character, std::uint32_t window);
  void wrote(std::size_t count, Time now);
  /// Characters that can be handed over now.
  std::size_t room(Time now) const;
  /// Characters handed over and, by the clock, not yet on the wire.
  std::size_t in_flight(Time now) const;
  /// When there is room for at least half the window: waking for every character would cost more than it
  /// gives.
  Time room_at() const;
  /// When the last character has left.
  Time empty_at() const { return empty_at_; }
  std::uint32_t window() const { return window_; }
  Duration character() const { return character_; }

 private:
  Duration character_;
  std::uint32_t window_;
  Time empty_at_{};
};

}  // namespace headstock::serial

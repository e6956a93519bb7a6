// One WebSocket client's share of what changes in the shop: what is due to it next, in bounded memory. Live states are
// newest-wins at most five times a second a machine; other events queue up to 1 MiB, more ends the client.
// No sockets in here. Network thread only.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/fleet/changes.hpp"

namespace headstock::api {

/// What a client asked for: "floor" (all machines), "machine:3" (with its trail), "transfers", "programs".
class Wishes {
 public:
  /// Replaces what was asked before. @return false when the message is none; unknown topics are ignored.
  bool read(const std::string& message);
  bool wants(const fleet::Change& change) const;
  bool floor() const { return floor_; }
  bool machine(std::int64_t id) const { return machines_.contains(id); }
  bool any() const { return floor_ || transfers_ || programs_ || !machines_.empty(); }
  static constexpr std::size_t max_machines = 1'000;

 private:
  bool floor_ = false, transfers_ = false, programs_ = false;
  std::set<std::int64_t> machines_;
};

using Message = std::shared_ptr<const std::string>;

class Outbox {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t max_bytes = 1u << 20;
  static constexpr std::chrono::milliseconds live_interval{200};

  /// Takes over what `change` means for a client with these wishes. @return false when the queue is full.
  bool put(const fleet::Change& change, const Wishes& wishes);
  /// A message of the hub itself (snapshot, tick); dropped by `droppable` when others still wait.
  enum class Kind { needed, droppable };
  bool put(Message message, Kind kind);
  /// The next message due, if any. Events go before live states.
  Message take(Clock::time_point now);
  /// When the next live state becomes due; nothing while none waits.
  std::optional<Clock::time_point> due() const;
  bool idle() const { return queue_.empty() && live_.empty(); }
  std::size_t bytes() const { return bytes_; }

 private:
  struct Waiting {
    fleet::SharedJson live;
    bool with_trail = false;
    nlohmann::json trail;        ///< of the states that were left out, so that the path has no holes
    Clock::time_point due{};
  };
  std::deque<Message> queue_;
  std::size_t bytes_ = 0;
  std::map<std::int64_t, Waiting> live_;
  std::map<std::int64_t, Clock::time_point> sent_;
};

}  // namespace headstock::api

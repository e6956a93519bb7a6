// The signal of interruption macros (M96 … M97) and how far one has come. While M96 is in force the
// look-ahead takes one operation at a time, so that an interruption finds the machine where the interpreter
// is: the axes stand between the blocks.
#pragma once

#include <atomic>
#include <cstdint>

namespace headstock::operation {

struct MacroInterruption {
  enum class Stage : std::uint8_t {
    none,
    braking,  ///< the axes come to rest inside a block
    inside    ///< the program runs and has commanded nothing yet: the rest of the block is kept
  };

  // ---- any thread
  void set_signal(bool now) noexcept {
    if (!on.exchange(now, std::memory_order_acq_rel) && now) edges.fetch_add(1, std::memory_order_release);
  }
  std::atomic<bool> on{false};
  std::atomic<std::uint64_t> edges{0};  ///< rising

  // ---- look-ahead, under the controller's lock
  bool due(bool by_level) const noexcept { return by_level ? on.load() : edges.load() != edges_seen; }
  void see() noexcept { edges_seen = edges.load(); }
  void forget() noexcept {
    stage = Stage::none;
    in_force = all_done = false;
  }
  Stage stage = Stage::none;
  bool in_force = false;  ///< the axes have come to the block of M96: from here on the signal counts
  bool all_done =
      false;  ///< what has been handed out is carried out, and the signal has been asked for since
  std::uint64_t edges_seen = 0;
  std::uint64_t braking_since = 0;  ///< period
};

}  // namespace headstock::operation

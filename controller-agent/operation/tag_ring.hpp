// What rides on every segment: the block it comes from and the modal state it was made under. The look-ahead
// writes an entry before the kernel gets the move; whoever shows or carries out a sample looks the entry up
// by the sample's tag.
#pragma once

#include <cstdint>
#include <vector>

#include "interpreter/canonical.hpp"
#include "motion/kernel.hpp"

namespace headstock::operation {

using machine::AxisVector;

struct SegmentState {
  std::uint64_t tag = 0;  ///< 0: nothing has moved yet
  interp::SourcePosition at;
  interp::ModalSnapshot modal;
  std::uint64_t main_offset = 0;  ///< byte offset reached in the main program, for progress
  const char* cycle = nullptr;
  AxisVector end{};  ///< where the block's move ends, machine coordinates
  bool has_end = false;
  bool cutting = false;            ///< not a rapid
  std::uint16_t skip_signals = 0;  ///< any of these ends the move (G31)
  bool skip_low = false;           ///< … while they are off (0i-D No.6200#1)
  bool fixed_feed = false;         ///< feed override is 100 % (skip moves, G63)
  bool not_held = false;           ///< feed hold waits until the move is over (G63, #3004)
  bool no_single_block = false;    ///< single block does not stop at its end (#3003)
};

class TagRing {
 public:
  // Twice the kernel's queue: an entry that is still to be traced is never overwritten.
  static constexpr std::uint64_t kEntries = 2 * motion::Kernel::kQueueMoves;

  TagRing() : entries_(kEntries) {}
  /// Look-ahead thread. `traced` is the tag being traced now.
  bool has_room(std::uint64_t traced) const noexcept { return newest_ - traced < kEntries - 2; }
  SegmentState& append() noexcept {
    SegmentState& entry = entries_[++newest_ % kEntries];
    entry = {};
    entry.tag = newest_;
    return entry;
  }
  std::uint64_t newest() const noexcept { return newest_; }
  /// Any thread that got `tag` from a sample (the kernel's queue orders this read after the write).
  const SegmentState& find(std::uint64_t tag) const noexcept {
    return tag == 0 ? nothing_ : entries_[tag % kEntries];
  }

 private:
  std::vector<SegmentState> entries_;
  SegmentState nothing_;
  std::uint64_t newest_ = 0;
};

}  // namespace headstock::operation

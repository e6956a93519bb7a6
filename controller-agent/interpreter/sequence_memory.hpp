// Sequence numbers that a program has passed, for GOTOs that look there first (0i-D 14.4.3 L17486: MGO and HGO).
// Where a number stands twice, before and behind the GOTO, the one before it is meant then.
#pragma once

#include <cstdint>
#include <deque>

#include "interpreter/compiled_program.hpp"

namespace headstock::interp {

class SequenceMemory {
 public:
  /// @param first keeps the first 20 numbers passed  @param recent keeps the last 30, and 10 that jumps found
  SequenceMemory(bool first, bool recent) : keeps_first_(first), keeps_recent_(recent) {}

  void pass(std::uint32_t sequence, const BlockPlace& place) {
    if (keeps_first_ && first_.size() < kFirst && find_in(first_, sequence) == nullptr)
      first_.push_back({sequence, place});
    if (keeps_recent_) put(recent_, kRecent, sequence, place);
  }
  /// A GOTO went there.
  void found(std::uint32_t sequence, const BlockPlace& place) {
    if (keeps_recent_) put(history_, kHistory, sequence, place);
  }
  /// @return nullptr when the number is not remembered.
  const BlockPlace* find(std::uint32_t sequence) const {
    const BlockPlace* place = find_in(first_, sequence);
    if (place == nullptr) place = find_in(recent_, sequence);
    return place != nullptr ? place : find_in(history_, sequence);
  }

 private:
  static constexpr std::size_t kFirst = 20, kRecent = 30, kHistory = 10;
  struct Passed {
    std::uint32_t sequence;
    BlockPlace place;
  };
  using List = std::deque<Passed>;

  static const BlockPlace* find_in(const List& list, std::uint32_t sequence) {
    for (auto one = list.rbegin(); one != list.rend(); ++one)
      if (one->sequence == sequence) return &one->place;
    return nullptr;
  }
  static void put(List& list, std::size_t most, std::uint32_t sequence, const BlockPlace& place) {
    std::erase_if(list, [sequence](const Passed& one) { return one.sequence == sequence; });
    if (list.size() == most) list.pop_front();
    list.push_back({sequence, place});
  }

  bool keeps_first_, keeps_recent_;
  List first_, recent_, history_;
};

}  // namespace headstock::interp

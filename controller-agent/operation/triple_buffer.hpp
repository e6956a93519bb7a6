// The newest value from one writing thread to one reading thread, without a lock on either side: the writer
// never waits, the reader sees whole values only.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace headstock::operation {

template <typename T>
class TripleBuffer {
 public:
  /// Writer: where the next value is put together; `publish` hands it over.
  T& back() noexcept { return values_[back_]; }
  void publish() noexcept {
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  /// Reader: the newest published value; stays valid and unchanged until the next call.
  const T& read() noexcept {
    if (middle_.load(std::memory_order_relaxed) & kFresh)
      front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return values_[front_];
  }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;
  std::array<T, 3> values_{};
  std::uint8_t back_ = 0, front_ = 2;
  std::atomic<std::uint8_t> middle_{1};
};

}  // namespace headstock::operation

// One producer (look-ahead), one consumer (real time): items by ever-growing index, no lock, no allocation
// after the constructor. Published items stay in place until the consumer releases them, so both sides may
// look back and ahead.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace headstock::motion {

template <class Item>
class Ring {
 public:
  /// @param capacity a power of two
  explicit Ring(std::size_t capacity) : mask_(capacity - 1), items_(std::make_unique<Item[]>(capacity)) {}

  std::size_t capacity() const { return mask_ + 1; }
  Item& operator[](std::uint64_t index) { return items_[index & mask_]; }
  const Item& operator[](std::uint64_t index) const { return items_[index & mask_]; }

  // producer
  std::size_t room(std::uint64_t written) const {
    return capacity() - static_cast<std::size_t>(written - released_.load(std::memory_order_acquire));
  }
  void publish(std::uint64_t end) { published_.store(end, std::memory_order_release); }

  // consumer
  std::uint64_t published() const { return published_.load(std::memory_order_acquire); }
  void release(std::uint64_t begin) { released_.store(begin, std::memory_order_release); }
  std::uint64_t released() const { return released_.load(std::memory_order_acquire); }

 private:
  std::size_t mask_;
  std::unique_ptr<Item[]> items_;
  std::atomic<std::uint64_t> published_{0};
  std::atomic<std::uint64_t> released_{0};
};

}  // namespace headstock::motion

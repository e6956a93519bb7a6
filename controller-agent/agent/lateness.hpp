// How late periods begin: a histogram that the real-time thread fills and anybody may copy.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace headstock::agent {

/// Not synchronised; see MachineClock::lateness() for a copy.
class Lateness {
 public:
  /// @param ns after the period was due; no allocation
  void add(std::int64_t ns) noexcept {
    const std::int64_t us = ns > 0 ? ns / 1000 : 0;
    ++bins_[static_cast<std::size_t>(us) < bins_.size() ? static_cast<std::size_t>(us) : bins_.size() - 1];
    if (us > max_us_) max_us_ = us;
    ++periods_;
  }
  std::uint64_t periods() const { return periods_; }
  double max_us() const { return static_cast<double>(max_us_); }
  /// @param share 0…1 of the periods were not later than this [µs]; beyond the histogram: max_us()
  double percentile_us(double share) const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i + 1 < bins_.size(); ++i) {
      sum += bins_[i];
      if (static_cast<double>(sum) >= share * static_cast<double>(periods_)) return static_cast<double>(i);
    }
    return max_us();
  }

 private:
  std::array<std::uint64_t, 4096> bins_{};  // µs; the last one: later
  std::uint64_t periods_ = 0;
  std::int64_t max_us_ = 0;
};

}  // namespace headstock::agent

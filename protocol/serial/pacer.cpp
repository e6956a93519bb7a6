#include "protocol/serial/pacer.hpp"

#include <algorithm>

namespace headstock::serial {

Pacer::Pacer(Duration character, std::uint32_t window)
    : character_(character), window_(std::max(window, 1u)) {}

void Pacer::wrote(std::size_t count, Time now) {
  empty_at_ = std::max(empty_at_, now) + character_ * static_cast<Duration::rep>(count);
}

std::size_t Pacer::in_flight(Time now) const {
  if (empty_at_ <= now || character_ <= Duration::zero()) return 0;
  return static_cast<std::size_t>((empty_at_ - now + character_ - Duration(1)) / character_);
}

std::size_t Pacer::room(Time now) const {
  const std::size_t waiting = in_flight(now);
  return waiting >= window_ ? 0 : window_ - waiting;
}

Time Pacer::room_at() const {
  const std::uint32_t keep = window_ / 2;
  return empty_at_ - character_ * static_cast<Duration::rep>(keep);
}

}  // namespace headstock::serial

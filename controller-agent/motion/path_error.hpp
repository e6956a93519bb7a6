// Judges commanded samples from outside the kernel: how far each lies from the programmed geometry. Works on
// the moves themselves, not on anything the kernel made of them.
#pragma once

#include <cstddef>
#include <deque>

#include "motion/kernel.hpp"

namespace headstock::motion {

class PathError {
 public:
  explicit PathError(std::size_t axes) : axes_(axes) { weights_.fill(1); }
  /// @param weights what 1 mm or 1 degree of each axis counts, as tolerance_weights() says
  PathError(std::size_t axes, const AxisVector& weights) : axes_(axes), weights_(weights) {}

  /// The programmed path begins (again) here.
  void start(const AxisVector& position);
  /// The same moves as given to Kernel::push(), in order; at least those up to the one being traced and the
  /// next, before the sample.
  void add(const Move& move);
  /// @return distance of a commanded sample to the programmed path [mm], over all axes.
  /// @param tag of the sample; searched are the moves around the next one with this tag. Tags differ between
  /// moves.
  double sample(const AxisVector& position, std::uint64_t tag) { return search(position, tag, -1); }
  /// The same for max() only: a sample that is no farther than one before is not measured to the end.
  void judge(const AxisVector& position, std::uint64_t tag) { search(position, tag, max_); }
  double max() const { return max_; }

 private:
  struct Traced {
    AxisVector start, end;
    Move move;
  };
  /// @param enough a distance that is near enough to stop looking
  double search(const AxisVector& position, std::uint64_t tag, double enough);
  double distance_to(const Traced& move, const AxisVector& position) const;

  std::size_t axes_;
  AxisVector weights_;
  AxisVector last_end_{};
  std::deque<Traced> moves_;
  std::size_t current_ = 0;
  double max_ = 0;
};

}  // namespace headstock::motion

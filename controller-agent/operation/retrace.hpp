// Handle retrace: in a held program the axes go back along what has been traced and forward again, as far as
// the point where they were held. The way is kept as the moves that the kernel got; it is traced by a kernel
// of its own, so the held one keeps its queue. M, S and T functions are not undone and not repeated.
//
// Under the controller's lock; the kernel's step() belongs to the real-time thread.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "machine/machine.hpp"
#include "motion/kernel.hpp"

namespace headstock::operation {

using machine::AxisVector;

class Retrace {
 public:
  /// Moves kept: what the kernel has queued, and those behind the one being traced (0i-D: about 190 blocks).
  static constexpr std::size_t kKept = motion::Kernel::kQueueMoves + 256;

  explicit Retrace(const machine::Machine& machine) : machine_(machine) {}

  /// A move has been handed to the kernel.
  void record(const AxisVector& start, const motion::Move& move);
  /// What comes next does not begin where the last one ended.
  void forget();

  /// The axes are held here, in the move with this tag. @return false when nothing of it is known
  bool begin(std::uint64_t tag, const AxisVector& position);
  /// Makes the way of so many mm [degrees like mm] along the path, < 0 back, > 0 forward but not beyond where
  /// the axes were held. Threads are not retraced: the way ends there. Precondition: stands().
  /// @return false when there is no way in that direction
  bool go(double way_mm, double feed_mm_s);
  /// The axes have come to rest on the way: go() begins from there.
  void stopped(std::uint64_t tag, const AxisVector& position);
  bool active() const { return active_; }
  bool at_hold() const { return place_.move == hold_.move && place_.share == hold_.share; }
  void end() { active_ = false; }
  motion::Kernel* kernel() { return kernel_.get(); }

 private:
  struct Executed {
    AxisVector start{};
    motion::Move move;
    double length = 0;
  };
  struct Place {
    std::int64_t move = 0;  ///< counted since the first that was ever recorded
    double share = 0;       ///< 0…1 of it
  };
  const Executed& at(std::int64_t move) const { return moves_[static_cast<std::size_t>(move - first_)]; }
  std::int64_t last() const { return first_ + static_cast<std::int64_t>(moves_.size()) - 1; }
  double share_of(const Executed& executed, const AxisVector& position) const;
  AxisVector point(const Executed& executed, double share) const;
  motion::Move part(const Executed& executed, double from, double to) const;
  bool retraceable(std::int64_t move) const;

  const machine::Machine& machine_;
  std::deque<Executed> moves_;
  std::int64_t first_ = 0;
  bool active_ = false;
  Place hold_, place_;
  AxisVector hold_position_{}, position_{};
  std::unique_ptr<motion::Kernel> kernel_;
};

}  // namespace headstock::operation

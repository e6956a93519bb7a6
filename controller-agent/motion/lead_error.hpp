// Judges cut threads from outside the kernel: how far the tool went in each turn of the spindle, against the
// lead that was programmed.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "motion/kernel.hpp"

namespace headstock::motion {

class LeadError {
 public:
  explicit LeadError(std::size_t axes) : axes_(axes) {}

  /// The path begins (again) here.
  void start(const AxisVector& position) { last_end_ = position; }
  /// The same moves as given to Kernel::push(), in order.
  void add(const Move& move);
  /// One period. @param phase_rad of the spindle, not reduced to one turn, at the end of the period
  void sample(const Sample& sample, double phase_rad);

  /// Threads cut so far, one for each move of a chain.
  std::size_t threads() const { return threads_; }
  /// Whole turns that were judged: neither the first of a thread (run-in) nor the last (run-out).
  std::size_t turns() const { return turns_; }
  /// Largest |way of one turn - its lead| along the axis that moves most [mm]. A turn of a variable lead is
  /// compared with the mean of the lead over it.
  double max_mm() const { return max_; }
  /// Longest way from a thread's start in which its lead was not yet within 1 % [mm].
  double run_in_mm() const { return run_in_; }

 private:
  struct Course {
    std::uint64_t tag = 0;
    std::size_t axis = 0;
    double start = 0, direction = 1;
    double lead = 0, change = 0;  ///< mm, mm a revolution
  };
  void begin(const Course& course);
  /// Way along the course at this whole turn.
  void turn_passed(double way);
  double lead_at(double way) const;

  std::size_t axes_;
  AxisVector last_end_{};
  std::deque<Course> ahead_;
  Course course_;
  bool cutting_ = false;
  double way_before_ = 0, turns_before_ = 0;  // at the period before
  double counted_from_ = 0;                   // turns at the beginning of the course
  std::vector<double> at_turns_;              // way at each whole turn since then, the last three
  std::size_t threads_ = 0, turns_ = 0;
  double max_ = 0, run_in_ = 0;
  bool settled_ = false;
};

}  // namespace headstock::motion

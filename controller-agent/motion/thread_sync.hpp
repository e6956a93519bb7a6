// Thread cutting: where along a thread the tool shall be for a phase of the spindle. Real-time thread.
//
// The start is moved ahead by the way the acceleration needs, so that at full speed the tool is on
// length = lead * (phase - start angle) / 2π whatever the spindle speed: every pass meets the same groove.
#pragma once

#include "motion/time_law.hpp"

namespace headstock::motion {

/// A thread move in terms of programmed length.
struct ThreadCourse {
  double begin = 0, end = 0;  ///< mm
  double lead = 0;            ///< mm of length a revolution
  double lead_change = 0;     ///< mm of length a revolution, each revolution
  double start_angle_rad = 0;

  /// Length after so many revolutions from the beginning.
  double at(double revolutions) const {
    return begin + (lead + 0.5 * lead_change * revolutions) * revolutions;
  }
  double lead_at(double revolutions) const { return lead + lead_change * revolutions; }
  /// Revolutions from begin to end.
  double revolutions() const;
};

class ThreadSync {
 public:
  void stop() { phase_ = Phase::off; }
  bool running() const { return phase_ == Phase::running; }
  /// @param course of the move the law's leading length is on; @param at_start nothing of it is traced yet,
  /// axes at rest.
  /// @return what the time law shall do; ratio 0 while waiting for the spindle.
  Demand demand(const ThreadCourse& course, bool at_start, double phase_rad, double rpm, const TimeLaw& law);

 private:
  enum class Phase { off, waiting, running } phase_ = Phase::off;
  double start_turn_ = 0;  // spindle turns at which the motion starts (waiting), or at which the course began
  double course_begin_ = 0;
  double previous_revolutions_ = 0;  // of the course before
};

}  // namespace headstock::motion

#include "motion/thread_sync.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::motion {

double ThreadCourse::revolutions() const {
  const double length = end - begin;
  if (std::abs(lead_change) < 1e-12) return length / lead;
  const double root = lead * lead + 2 * lead_change * length;
  return root > 0 ? 2 * length / (lead + std::sqrt(root)) : lead / -lead_change;
}

Demand ThreadSync::demand(const ThreadCourse& course, bool at_start, double phase_rad, double rpm,
                          const TimeLaw& law) {
  // A spindle turning backward counts backward; the thread only asks how far it has turned.
  const double turn = (rpm < 0 ? -phase_rad : phase_rad) / (2 * M_PI);
  const double turns_s = std::abs(rpm) / 60;
  Demand demand;
  demand.ratio = 0;
  if (phase_ == Phase::off && !at_start) return demand;
  if (phase_ == Phase::off) {
    if (turns_s <= 0) return demand;
    const double speed = course.lead * turns_s, acceleration = 0.9 * std::max(law.acceleration_at(0), 1e-6);
    const double ahead = speed * speed / (2 * acceleration) / course.lead + turns_s * law.lag_s();
    const double angle = course.start_angle_rad / (2 * M_PI);
    // The course begins at a whole turn after the start angle; motion starts `ahead` turns before that.
    start_turn_ = angle + std::ceil(turn + ahead - angle);
    course_begin_ = course.begin;
    previous_revolutions_ = course.revolutions();
    phase_ = Phase::waiting;
  }
  if (phase_ == Phase::waiting) {
    const double speed = course.lead * turns_s, acceleration = 0.9 * std::max(law.acceleration_at(0), 1e-6);
    const double ahead = speed * speed / (2 * acceleration) / course.lead + turns_s * law.lag_s();
    if (turn < start_turn_ - ahead) return demand;
    phase_ = Phase::running;
  }
  if (course.begin != course_begin_) {  // the next thread of the chain: its first turn follows the last one
    start_turn_ += previous_revolutions_;
    course_begin_ = course.begin;
    previous_revolutions_ = course.revolutions();
  }
  const double revolutions = turn + turns_s * law.lag_s() - start_turn_;
  demand.follow = true;
  // Before the start angle the target comes from behind at the speed of the first turn.
  demand.target = revolutions < 0 ? course.begin + course.lead * revolutions : course.at(revolutions);
  demand.target_speed = std::max(0.0, course.lead_at(std::max(0.0, revolutions))) * turns_s;
  return demand;
}

}  // namespace headstock::motion

#include "motion/lead_error.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::motion {

namespace {
constexpr double kSettled = 0.01;  // of the lead
}  // namespace

void LeadError::add(const Move& move) {
  const AxisVector end = std::visit([](const auto& g) { return g.end; }, move.geometry);
  if (const auto* thread = std::get_if<ThreadFeed>(&move.feed)) {
    Course course;
    course.tag = move.tag;
    for (std::size_t i = 0; i < axes_; ++i)
      if (std::abs(end[i] - last_end_[i]) > std::abs(end[course.axis] - last_end_[course.axis]))
        course.axis = i;
    course.start = last_end_[course.axis];
    course.direction = end[course.axis] < course.start ? -1 : 1;
    course.lead = thread->lead_mm;
    course.change = thread->lead_change_mm;
    ahead_.push_back(course);
  }
  last_end_ = end;
}

void LeadError::begin(const Course& course) {
  course_ = course;
  cutting_ = true;
  settled_ = false;
  ++threads_;
  way_before_ = 0;
  counted_from_ = turns_before_;
  at_turns_.clear();
}

double LeadError::lead_at(double way) const {
  return std::sqrt(std::max(0.0, course_.lead * course_.lead + 2 * course_.change * way));
}

void LeadError::turn_passed(double way) {
  // A turn is judged when the next one is whole, too: the last one of a thread runs out.
  at_turns_.push_back(way);
  if (at_turns_.size() < 4) return;
  const double from = at_turns_[1], to = at_turns_[2];
  max_ = std::max(max_, std::abs(to - from - 0.5 * (lead_at(from) + lead_at(to))));
  ++turns_;
  at_turns_.erase(at_turns_.begin());
}

void LeadError::sample(const Sample& sample, double phase_rad) {
  const double turns = std::abs(phase_rad) / (2 * M_PI);
  while (!ahead_.empty() && ahead_.front().tag < sample.tag) ahead_.pop_front();
  if (!ahead_.empty() && ahead_.front().tag == sample.tag && sample.moving) {
    begin(ahead_.front());
    ahead_.pop_front();
  }
  if (cutting_ && (sample.tag != course_.tag || !sample.moving)) cutting_ = false;
  if (cutting_) {
    const double way = (sample.position[course_.axis] - course_.start) * course_.direction;
    const double moved = way - way_before_, turned = turns - turns_before_;
    if (!settled_ && turned > 0) {
      settled_ = std::abs(moved / turned - lead_at(way)) < kSettled * lead_at(way);
      if (!settled_) run_in_ = std::max(run_in_, way);
    }
    const double before = turns_before_ - counted_from_, now = turns - counted_from_;
    for (double whole = std::floor(before) + 1; whole <= now; ++whole)
      turn_passed(way_before_ + moved * (whole - before) / (now - before));
    way_before_ = way;
  }
  turns_before_ = turns;
}

}  // namespace headstock::motion

#include "axes/point_motion.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::axes {
namespace {

constexpr double kNotLimited = 1e9;
constexpr double kThere_mm = 1e-9;

}  // namespace

PointMotion::PointMotion(const Limits& limits, double period_s)
    : acceleration_(limits.acceleration), most_speed_(limits.speed), period_s_(period_s) {
  if (limits.jerk < kNotLimited) {
    const double wanted = std::ceil(2 * acceleration_ / (limits.jerk * period_s_));
    periods_ = static_cast<std::size_t>(std::clamp(wanted, 1.0, static_cast<double>(kMostPeriods)));
    acceleration_ = std::min(acceleration_, limits.jerk * static_cast<double>(periods_) * period_s_ / 2);
  }
  own_acceleration_ = acceleration_;
  own_periods_ = periods_;
  set(0);
}

void PointMotion::shape(double acceleration, double bell_s) noexcept {
  acceleration_ = acceleration > 0 ? std::min(acceleration, own_acceleration_) : own_acceleration_;
  const auto bell = static_cast<std::size_t>(std::max(0.0, std::round(bell_s / period_s_)));
  const std::size_t periods = std::clamp(bell, own_periods_, kMostPeriods);
  if (periods == periods_) return;
  periods_ = periods;
  newest_ = 0;
  window_.fill(leading_);
  still_ = kMostPeriods;
}

void PointMotion::set(double position) noexcept {
  window_.fill(position);
  leading_ = position_ = target_ = position;
  speed_ = velocity_ = wanted_speed_ = 0;
  stopping_ = false;
  still_ = periods_;
}

void PointMotion::go(double target, double speed) noexcept {
  target_ = target;
  wanted_speed_ = std::clamp(speed, 0.0, most_speed_);
  stopping_ = false;
}

void PointMotion::stop() noexcept {
  stopping_ = true;
}

// Highest speed at the end of this period from which the law still stops within `way` of where it is now: it
// runs (v + v')/2 T in this period and v'²/2a + v'T/2 at most in whole periods of braking.
double PointMotion::reachable(double way) const noexcept {
  const double left = way - std::abs(speed_) * period_s_ / 2;
  if (left <= 0) return 0;
  const double t = period_s_;
  return acceleration_ * (std::sqrt(t * t + 2 * left / acceleration_) - t);
}

void PointMotion::step() noexcept {
  const double before = leading_;
  const double most_change = acceleration_ * period_s_;
  double wanted = 0;
  if (!stopping_) {
    const double way = target_ - leading_;
    const double sense = way < 0 ? -1 : 1;
    if (speed_ * sense >= 0) wanted = sense * std::min(wanted_speed_, reachable(std::abs(way)));
  }
  const double speed = std::clamp(wanted, speed_ - most_change, speed_ + most_change);
  // A change of sense goes through a period that ends at rest.
  const double next = speed * speed_ < 0 ? 0 : speed;
  leading_ += (speed_ + next) / 2 * period_s_;
  speed_ = next;
  if (!stopping_ && std::abs(target_ - leading_) < kThere_mm && std::abs(speed_) <= most_change) {
    leading_ = target_;
    speed_ = 0;
  }
  if (stopping_ && speed_ == 0) {
    target_ = leading_;
    wanted_speed_ = 0;
    stopping_ = false;
  }
  still_ = leading_ == before && speed_ == 0 ? std::min(still_ + 1, kMostPeriods) : 0;
  newest_ = (newest_ + 1) % periods_;
  window_[newest_] = leading_;
  const double last = position_;
  if (still_ >= periods_) {
    position_ = leading_;
  } else {
    // About the newest, so that rounding does not grow with the distance from zero.
    double sum = 0;
    for (std::size_t i = 0; i < periods_; ++i) sum += window_[i] - leading_;
    position_ = leading_ + sum / static_cast<double>(periods_);
  }
  velocity_ = (position_ - last) / period_s_;
}

double PointMotion::stopping_way() const noexcept {
  return speed_ * speed_ / (2 * acceleration_) + std::abs(speed_) * period_s_ +
         std::abs(leading_ - position_);
}

}  // namespace headstock::axes

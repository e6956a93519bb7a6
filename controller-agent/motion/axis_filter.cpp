#include "motion/axis_filter.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::motion {
namespace {

// An exponential run-out never ends by itself. From here on the speed falls evenly instead, down to rest on
// the target: at most so far before it [mm], and so near that the change of acceleration is this part of the
// axis' jerk.
constexpr double kRunOut_mm = 0.01, kJerkShare = 0.4;
constexpr double kSettled_mm = 1e-12;

std::size_t periods_of(double time_s, double most_s, double period_s) {
  return static_cast<std::size_t>(std::lround(std::clamp(time_s, 0.0, most_s) / period_s));
}

}  // namespace

AxisFilter::AxisFilter(std::size_t axes, double period_s, const AxisVector& jerk_mm_s3)
    : axes_(axes), period_s_(period_s), jerk_(jerk_mm_s3) {
  const std::size_t most = periods_of(kLongestFilter_s, kLongestFilter_s, period_s) + 1;
  memory_ = std::make_unique_for_overwrite<double[]>(2 * most * (axes + 1));
  double* next = memory_.get();
  const auto give = [&](Channel& channel) {
    for (Average* average : {&channel.first, &channel.second}) {
      average->past = next;
      average->most = most;
      next += most;
    }
  };
  for (std::size_t i = 0; i < axes; ++i) give(channels_[i]);
  give(channels_.back());
}

void AxisFilter::Average::start(std::size_t periods) noexcept {
  size = std::clamp<std::size_t>(periods, 1, most);
  newest = 0;
  sum = 0;
  std::fill_n(past, size, 0.0);
}

double AxisFilter::Average::step(double in) noexcept {
  if (size == 1) return in;
  newest = newest + 1 == size ? 0 : newest + 1;
  sum += in - past[newest];
  past[newest] = in;
  return sum / static_cast<double>(size);
}

void AxisFilter::set(Channel& channel, const AccelerationShape& shape, std::size_t axis,
                     double position) noexcept {
  const double time_s = std::min(shape.after_s[axis], kLongestFilter_s);
  channel.shape = time_s > 0 ? shape.after : FilterShape::none;
  channel.origin = position;
  channel.in = channel.out = 0;
  const bool linear = channel.shape == FilterShape::linear;
  const std::size_t bell = linear ? periods_of(shape.after_bell_s[axis], kLongestFilter_s, period_s_) : 0;
  channel.first.start(linear ? periods_of(time_s, kLongestFilter_s, period_s_) : 1);
  channel.second.start(bell > 0 ? bell + 1 : 1);  // together: both times
  if (channel.shape == FilterShape::exponential) {
    channel.tau_s = time_s;
    channel.share = 1 - std::exp(-period_s_ / time_s);
    channel.ends_at = std::min(kRunOut_mm, kJerkShare * jerk_[axis] * time_s * period_s_ * period_s_);
  }
  channel.still = channel.settling = channel.first.size + channel.second.size - 2;
}

void AxisFilter::set(const AccelerationShape& shape, const AxisVector& position, double length,
                     std::size_t leading) noexcept {
  active_ = shape.filters();
  position_ = position;
  length_ = length;
  empty_ = true;
  lag_s_ = 0;
  if (!active_) return;
  for (std::size_t i = 0; i < axes_; ++i) set(channels_[i], shape, i, position[i]);
  Channel& along = channels_.back();
  set(along, shape, leading, length);
  if (along.shape == FilterShape::exponential)
    lag_s_ = period_s_ * (1 - along.share) / along.share;
  else
    lag_s_ = 0.5 * static_cast<double>(along.settling) * period_s_;
}

bool AxisFilter::Channel::empty() const noexcept {
  return shape == FilterShape::exponential ? out == in : still >= settling;
}

double AxisFilter::Channel::step(double position, double period_s) noexcept {
  const double now = position - origin;
  still = now == in ? still + 1 : 0;
  in = now;
  if (shape == FilterShape::linear) return step_average(position);
  return shape == FilterShape::exponential ? step_lag(position, period_s) : position;
}

double AxisFilter::Channel::step_average(double position) noexcept {
  out = second.step(first.step(in));
  if (still < settling) return origin + out;
  // Run out: on the place itself, and the sums begin anew, so that rounding does not add up.
  if (in != 0) {
    origin = position;
    in = out = 0;
    first.start(first.size);
    second.start(second.size);
  }
  return position;
}

double AxisFilter::Channel::step_lag(double position, double period_s) noexcept {
  const double left = in - out, distance = std::abs(left);
  if (still == 0 || distance > ends_at) {
    out += share * left;
    return out == in ? position : origin + out;
  }
  // Evenly down to rest: v² = ends_at × distance / τ², which at ends_at is the speed of the lag.
  const double way = std::sqrt(ends_at * distance) / tau_s * period_s;
  if (way >= distance || distance <= kSettled_mm) {
    out = in;
    return position;
  }
  out += std::copysign(way, left);
  return origin + out;
}

const AxisVector& AxisFilter::step(const AxisVector& position, double length) noexcept {
  empty_ = true;
  for (std::size_t i = 0; i < axes_; ++i) {
    position_[i] = channels_[i].step(position[i], period_s_);
    empty_ = empty_ && channels_[i].empty();
  }
  // The length is only looked at: with nothing left to move it is where the axes are.
  Channel& along = channels_.back();
  length_ = along.step(length, period_s_);
  if (empty_) length_ = length;
  return position_;
}

}  // namespace headstock::motion

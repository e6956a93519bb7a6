#include "motion/limits_check.hpp"

#include <algorithm>
#include <cmath>

namespace headstock::motion {

void LimitsCheck::add(const AxisVector& position) {
  if (count_++ == 0) {
    p1_ = position;
    v1_ = a1_ = AxisVector{};
    return;
  }
  for (std::size_t i = 0; i < axes_; ++i) {
    const double v = (position[i] - p1_[i]) / period_s_;
    const double a = (v - v1_[i]) / period_s_;
    const double j = (a - a1_[i]) / period_s_;
    velocity_[i] = std::max(velocity_[i], std::abs(v));
    acceleration_[i] = std::max(acceleration_[i], std::abs(a));
    jerk_[i] = std::max(jerk_[i], std::abs(j));
    p1_[i] = position[i];
    v1_[i] = v;
    a1_[i] = a;
  }
}

}  // namespace headstock::motion

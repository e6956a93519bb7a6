// The limit checker on a bench: every period's commanded position, whoever moves the axes.
#pragma once

#include <gtest/gtest.h>

#include "bench.hpp"
#include "motion/limits_check.hpp"

namespace headstock::operation {

class LimitsOnBench {
 public:
  explicit LimitsOnBench(Bench& bench)
      : bench_(bench),
        check_(bench.controller.machine().axes.size(), bench.controller.machine().period_us * 1e-6) {
    check_.add(bench.controller.sample().position);
  }
  void period() {
    bench_.period();
    check_.add(bench_.controller.sample().position);
  }
  template <typename Condition>
  bool until(Condition condition, double seconds) {
    const auto most = static_cast<std::uint64_t>(seconds * 1e6 / bench_.controller.machine().period_us);
    for (std::uint64_t i = 0; i < most && !condition(); ++i) period();
    return condition();
  }
  void expect_inside() const {
    const auto& axes = bench_.controller.machine().axes;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      EXPECT_LE(check_.max_velocity()[i], axes[i].rapid_mm_min / 60 * 1.001) << axes[i].name;
      EXPECT_LE(check_.max_acceleration()[i], axes[i].max_acceleration_mm_s2 * 1.01) << axes[i].name;
      EXPECT_LE(check_.max_jerk()[i], axes[i].max_jerk_mm_s3 * 1.05) << axes[i].name;
    }
  }
  const motion::LimitsCheck& check() const { return check_; }

 private:
  Bench& bench_;
  motion::LimitsCheck check_;
};

}  // namespace headstock::operation

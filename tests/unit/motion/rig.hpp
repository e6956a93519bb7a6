// Runs moves through a kernel in virtual time and judges every sample from outside.
#pragma once

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "machine/machine.hpp"
#include "motion/kernel.hpp"
#include "motion/limits_check.hpp"
#include "motion/path_error.hpp"

namespace headstock::motion::rig {

/// A machine with these limits on every axis [mm/s, mm/s², mm/s³]; jerk >= 1e9: not limited.
machine::Machine machine(std::size_t axes, double speed, double acceleration, double jerk, double rapid = 0);

struct Run {
  std::vector<Sample> samples;
  double time_s = 0;
  AxisVector velocity{}, acceleration{}, jerk{};  // maxima
  double path_error = 0;
  bool finished = false;
};

struct Options {
  AxisVector start{};
  std::function<Overrides(std::size_t period)> overrides;  // default: all 100 %
  std::function<double(std::size_t period)> rpm;           // default: 1000
  std::function<void(const Sample&)> watch;                // every sample
  std::size_t most_periods = 4'000'000;
  std::size_t plans_per_step = 0;   // 0: until there is nothing to do
  std::size_t pushes_per_step = 0;  // 0: as many as there is room for
};

Run run(Kernel& kernel, const machine::Machine& machine, const std::vector<Move>& moves,
        const Options& options = {});

/// "" when every axis is inside its limits: v 0.1 %, a 1 %, j 5 %; else what is not.
std::string violations(const machine::Machine& machine, const Run& run, bool rapid = false);

Move line(AxisVector end, double mm_s, double tolerance = 0.01);

}  // namespace headstock::motion::rig

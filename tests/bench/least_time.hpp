// The least time along a path that is given as samples of one run along it, under velocity and acceleration
// limits of every axis and a feed along the path: what the kernel's time is measured against on any program.
// Shares nothing with the kernel.
//
// The run's own time u is the parameter: between two samples the path goes d in dt, and the run that is
// looked for goes it s times as fast. With x = s² the acceleration of an axis at the sample between two steps
// is linear in the x of both (their mean times d²q/du² plus their difference times dq/du / 2 dt). A backward
// pass finds the highest x of each step from which the rest can still be followed (whatever comes next: a
// linear programme of two unknowns), a forward pass takes the highest x there is: the fastest run at every
// place. The given run, x = 1, keeps the limits; where its own differences do not by a rounding, the limit
// gives way. So the result is never above it.
#pragma once

#include <array>
#include <vector>

namespace headstock::bench {

inline constexpr std::size_t kPathAxes = 3;
/// From one sample to the next.
struct PathStep {
  std::array<double, kPathAxes> way{};  ///< mm
  double feed = 0;                      ///< highest along the path [mm/s]; infinite for rapid
  int line = 0;                         ///< of the program
  double speed_up = 1;                  ///< result: how much faster the fastest run goes it
};
struct PathLimits {
  double velocity = 500;        ///< of each axis [mm/s]
  double acceleration = 2'000;  ///< of each axis [mm/s²]
};

/// From rest to rest. @param period_s between the samples @return seconds
double least_time(std::vector<PathStep>& path, double period_s, const PathLimits& limits);

}  // namespace headstock::bench

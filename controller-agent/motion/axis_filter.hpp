// Acceleration after interpolation: each axis' commanded position through a filter of its own, the last thing
// the kernel does. A moving average makes linear ramps of a fixed time, two of them one behind the other make
// bell-shaped ones, a first-order lag makes exponential ones.
//
// What comes out is a mean of positions that went in, so speed, acceleration and jerk of every axis and its
// travel hold as they held before. What does not hold is the path: a corner is cut by what the axes lag, an
// arc of radius r at speed v becomes smaller by about v² T² / (24 r) (linear), v² τ² / (2 r) (exponential),
// and with another time for each axis even a straight line bends while the speed changes. That is what the
// real controls do, and why they have acceleration before interpolation. Where the path has to be exact they
// wait until the filter has run out, and so does the kernel.
//
// Memory is taken once; the rest is for the real-time thread: no allocation, no loop over the window while
// the axes move.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "machine/machine.hpp"

namespace headstock::motion {

using machine::AxisVector;

enum class FilterShape : std::uint8_t {
  none,
  linear,      ///< from one constant speed to another in after_s + after_bell_s
  exponential  ///< after after_s 63 % of a change is done
};

/// How a kind of motion speeds up and slows down, beside its limits. Both parts may be there.
struct AccelerationShape {
  /// Before interpolation: the acceleration rises and falls in this time at least [s]. The path stays as it
  /// is.
  double bell_s = 0;
  FilterShape after = FilterShape::none;
  AxisVector after_s{};       ///< time constant of each axis, up to kLongestFilter_s; 0: not filtered
  AxisVector after_bell_s{};  ///< linear: the acceleration rises and falls in this time; 0: at once

  bool operator==(const AccelerationShape&) const = default;
  bool filters() const { return after != FilterShape::none && after_s != AxisVector{}; }
  /// How far behind the interpolation an axis is at most, over its speed [s]: a mean of its positions in a time lies
  /// within half of that time at its highest speed, a first-order lag within its time constant.
  double lag_s(std::size_t axis) const {
    if (after == FilterShape::none) return 0;
    return after == FilterShape::linear ? (after_s[axis] + after_bell_s[axis]) / 2 : after_s[axis];
  }
};

inline constexpr double kLongestFilter_s = 4.0;  // 0i-D No. 1622, 1769: 4,000 ms
inline constexpr double kLongestBell_s = 0.25;   // before interpolation; 0i-D No. 1672, 1772: 200 ms

class AxisFilter {
 public:
  /// @param jerk_mm_s3 of each axis: the end of an exponential run-out stays far below it
  AxisFilter(std::size_t axes, double period_s, const AxisVector& jerk_mm_s3);

  /// Standing here, with this shape from now on. @param leading the axis whose lag counts for the length
  /// along the path
  void set(const AccelerationShape& shape, const AxisVector& position, double length,
           std::size_t leading) noexcept;
  bool active() const noexcept { return active_; }
  /// One period: where the interpolation is. @return where the axes are
  const AxisVector& step(const AxisVector& position, double length) noexcept;
  /// Length along the path that the axes have come to.
  double length() const noexcept { return length_; }
  /// Nothing is left in it: the axes are where the interpolation is.
  bool empty() const noexcept { return empty_; }
  /// How much later than the interpolation the axes are somewhere, at constant speed [s].
  double lag_s() const noexcept { return lag_s_; }

 private:
  struct Average {
    double* past = nullptr;
    std::size_t most = 1, size = 1, newest = 0;
    double sum = 0;
    void start(std::size_t periods) noexcept;
    double step(double in) noexcept;
  };
  /// One axis, or the length along the path. Counted from `origin`, where it last stood.
  struct Channel {
    Average first, second;
    FilterShape shape = FilterShape::none;
    double origin = 0, in = 0, out = 0;
    double share = 1, tau_s = 0, ends_at = 0;  // exponential
    std::size_t still = 0, settling = 0;       // periods
    bool empty() const noexcept;
    double step(double position, double period_s) noexcept;
    double step_average(double position) noexcept;
    double step_lag(double position, double period_s) noexcept;
  };
  void set(Channel& channel, const AccelerationShape& shape, std::size_t axis, double position) noexcept;

  std::size_t axes_;
  double period_s_;
  AxisVector jerk_{};
  std::unique_ptr<double[]> memory_;
  std::array<Channel, machine::kMaxAxes + 1> channels_;  // the last: the length
  AxisVector position_{};
  double length_ = 0, lag_s_ = 0;
  bool active_ = false, empty_ = true;
};

}  // namespace headstock::motion

// Between the axes a program knows and the motors that move them: inclined and synchronous axes, backlash
// taken up smoothly, pitch error of the screws (one table, or one for each direction). Real-time thread; the
// tables are read once at the start, no allocation afterwards.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "axes/point_motion.hpp"
#include "machine/machine.hpp"

namespace headstock::axes {

using machine::AxisVector;

/// Error of a screw over its table [mm]: linear between the points, level outside them.
class PitchTable {
 public:
  PitchTable() = default;
  explicit PitchTable(const std::vector<machine::PitchError>& points) : points_(points) {}
  bool empty() const noexcept { return points_.empty(); }
  double at(double position_mm) const noexcept;

 private:
  std::vector<machine::PitchError> points_;
};

class Mechanics {
 public:
  Mechanics(const machine::Machine& machine, double period_s);

  /// Puts the synchronous axes where their masters are; once a period. What a slave was off when it was taken
  /// up is taken away slowly.
  void couple(AxisVector& axes) noexcept;
  /// The axes stand here and the slaves are not moved by that: they may have parted while the drives were
  /// off.
  void take_up(const AxisVector& axes) noexcept;
  /// Motors stand where these axes are.
  void set_position(const AxisVector& axes) noexcept;
  /// What the motors have to do for this commanded position, one period on.
  /// @return the position that the drives are given, compensation included
  AxisVector to_motors(const AxisVector& axes) noexcept;
  /// Where the axes are when the motors are there; with the compensation of the last to_motors().
  AxisVector to_axes(const AxisVector& motors) const noexcept;
  /// Compensation in force now, motor by motor [mm].
  const AxisVector& compensation() const noexcept { return compensation_; }

 private:
  struct Screw {
    PitchTable positive, negative;
    double backlash_mm = 0;  // lost on reversal
    bool compensated = false;
    double sense = 1;   // the axis last moved this way
    PointMotion share;  // 0: positive side … 1: negative side, in mm of the largest difference
    double scale = 1;   // of it
  };
  struct Inclined {
    std::size_t axis = 0, straight = 0;
    double cosine = 1, tangent = 0;
  };

  AxisVector kinematics(const AxisVector& axes) const noexcept;
  double error_at(const Screw& screw, double position, double share) const noexcept;

  std::size_t axes_;
  std::array<int, machine::kMaxAxes> master_{};
  std::array<double, machine::kMaxAxes> slave_shift_{};
  std::array<PointMotion, machine::kMaxAxes> slave_off_;  // what is still to be taken away
  std::vector<Inclined> inclined_;
  std::array<Screw, machine::kMaxAxes> screws_;
  AxisVector last_{}, compensation_{};
};

}  // namespace headstock::axes

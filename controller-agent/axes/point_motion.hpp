// One axis from where it stands to a point that may change at any time: jog, handle, reference return, axes
// of the ladder, rigid tapping. Real-time thread; no allocation after construction, no loop without bound.
//
// A second-order law (speed and acceleration bounded, always able to stop at the target) followed by a moving
// average. The law's acceleration changes by at most 2 a at once, so that an average over 2 a / j keeps the
// jerk within j whatever target and speed do; the average of a law that never passes its target does not pass
// it either.
#pragma once

#include <array>
#include <cstddef>

namespace headstock::axes {

class PointMotion {
 public:
  struct Limits {
    double speed = 0;         ///< mm/s, > 0
    double acceleration = 0;  ///< mm/s², > 0
    double jerk = 0;          ///< mm/s³, > 0; 1e9 and above: not limited
  };
  /// Longest smoothing time in periods; a smaller jerk lowers the acceleration instead.
  static constexpr std::size_t kMostPeriods = 512;

  PointMotion() = default;
  PointMotion(const Limits& limits, double period_s);

  /// At rest only: gentler than its limits from now on; 0, 0: its limits again.
  /// @param bell_s in which the acceleration rises and falls, at least
  void shape(double acceleration, double bell_s) noexcept;
  /// Stands here.
  void set(double position) noexcept;
  /// Where to, and how fast at most [mm/s]; both may be changed while it moves. Speed 0 brakes and holds.
  void go(double target, double speed) noexcept;
  /// Comes to rest as soon as it can; what was left of the way is dropped.
  void stop() noexcept;
  void step() noexcept;

  double position() const noexcept { return position_; }
  double velocity() const noexcept { return velocity_; }  ///< mm/s, over the last period
  double target() const noexcept { return target_; }
  bool at_rest() const noexcept { return speed_ == 0 && still_ >= periods_; }
  /// At rest where it was sent.
  bool arrived() const noexcept { return at_rest() && position_ == target_; }
  /// Way that it needs to come to rest from here.
  double stopping_way() const noexcept;

 private:
  double reachable(double way) const noexcept;

  double acceleration_ = 0, most_speed_ = 0, period_s_ = 0.001;
  double own_acceleration_ = 0;
  std::size_t periods_ = 1, own_periods_ = 1;  // of the moving average
  std::array<double, kMostPeriods> window_{};
  std::size_t newest_ = 0, still_ = kMostPeriods;
  double leading_ = 0, speed_ = 0;  // of the law; signed
  double position_ = 0, velocity_ = 0;
  double target_ = 0, wanted_speed_ = 0;
  bool stopping_ = false;
};

}  // namespace headstock::axes

// The time law: how far along the path the axes are in each period. Real-time thread; no allocation, no loop
// without bound.
//
// Second order (speed, bounded acceleration) under the speed plan, then a moving average over the smoothing
// time. The law looks only at the plan of the cells the next step can reach, so a period costs the same
// however much is queued; override and hold are just another ceiling and act in the next period.
//
// A period is several steps of the law, all under the same demand, so that what a corner or a ramp costs does
// not come in whole periods. That takes no margin: with n steps of length h in a period, the second
// difference of what every n-th step says is the sum of those of the 2 n - 1 steps around it, with weights
// 1, 2 … n … 2, 1, that is n² of them. What no step exceeds, no period does.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "motion/cells.hpp"
#include "motion/ring.hpp"

namespace headstock::motion {

/// What the law is to do in this period.
struct Demand {
  double ratio = 1;         ///< of the reference feed, 0…kMaxOverride; of the rapid rate 0…1
  bool follow = false;      ///< thread: be at `target`, moving at `target_speed`, instead
  double target = 0;        ///< length [mm]
  double target_speed = 0;  ///< mm/s
  /// Come to rest at this length; plan_stop() said that it is possible.
  double stop_at = std::numeric_limits<double>::infinity();
};

class TimeLaw {
 public:
  /// @param steps of the law in a period
  TimeLaw(const Ring<Cell>& cells, double period_s, std::size_t steps, std::size_t smoothing_periods);

  /// Stands at this length, in front of this cell.
  void reset(double length, std::uint64_t cell);
  void advance(const Demand& demand);

  double length() const { return length_; }           ///< after the moving average: where the axes are
  double leading_length() const { return leading_; }  ///< before it
  std::uint64_t cell() const { return cell_; }        ///< the cell of leading_length()
  bool at_rest() const { return speed_ == 0 && still_ >= window_.size(); }
  /// Acceleration that may be used now at this speed [mm/s²].
  double acceleration_at(double speed) const;
  double braking_at(double speed) const;
  /// At rest: the moving average of what comes next. @param lag_after_s of what follows behind the law
  void smooth(std::size_t periods, double lag_after_s);
  /// How much the moving average, and what follows it, lag behind [s].
  double lag_s() const { return 0.5 * static_cast<double>(window_.size() - 1) * period_s_ + lag_after_s_; }
  enum class StopPlan : std::uint8_t { possible, impossible, too_far };
  /// Can the law come to rest at this length, ahead of it? Makes the plan that Demand::stop_at then follows.
  StopPlan plan_stop(double length);
  /// At rest at an exact stop with more path behind it: go on from there.
  bool pass_stop();

 private:
  struct Mix;
  /// One step. @param left_s from its end to the end of the period
  void step(const Demand& demand, const Mix& mix, double left_s);
  /// Is this speed the one that the mixed plan has all along the way of this time [s], and no need to brake
  /// in it?
  bool cruises(const Mix& mix, double time_s) const;
  /// Be at this length, at this speed; not beyond the end of what is known, nor beyond a stop.
  void move_to(double leading, double speed);
  /// Highest speed, at most `most`, that the mixed plan allows at the end of this step.
  double reachable(const Mix& mix, double most) const;
  /// Highest speed, at most `most`, from which the planned stop is still reached.
  double towards_stop(double most) const;

  static constexpr std::size_t kStopCells = 1024;  // a stop is planned over at most

  const Ring<Cell>& cells_;
  double period_s_, step_s_;
  std::size_t steps_;
  std::vector<double> window_;
  std::size_t newest_ = 0;
  std::size_t still_ = 0;  // periods `leading_` has not moved
  double leading_ = 0, speed_ = 0, length_ = 0, lag_after_s_ = 0;
  std::uint64_t cell_ = 0;
  struct StopCell {
    double next = 0;     // v² where the cell ends
    double braking = 0;  // in it
  };
  std::vector<StopCell> stop_;  // from cell stop_first_ on
  std::uint64_t stop_first_ = 0, stop_cells_ = 0;
  double stop_at_ = 0;
};

}  // namespace headstock::motion

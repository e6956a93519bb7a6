// Speed limits along the spline: what every axis' velocity, acceleration and jerk limit leaves for the speed
// along the path, cell by cell, made so that a second-order time law followed by a moving average can never
// leave them.
//
// In a cell the axis i moves with |q'| <= rate, |q''| <= bend, |q'''| <= twist per mm. For path speed v,
// acceleration a, jerk j along the path its limits hold when
//     rate v <= V      bend v² + rate |a| <= A      twist v³ + 3 bend v |a| + rate |j| <= J.
// The moving average of `smoothing_s` makes |j| <= 2 max|a| / smoothing_s, which turns the third into a limit
// on a that falls with v; a line in v² below it takes its place, so that it is linear in v² as the others
// are. Because averaged values mix what happened within that time, each cell's limits are also laid on
// everything within its own highest speed times half that time, before and behind ("spreading"): a window
// whose average lies here and that reaches farther would have gone faster than allowed near here.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <vector>

#include "machine/machine.hpp"
#include "motion/axis_filter.hpp"
#include "motion/smoothing.hpp"

namespace headstock::motion {

enum class FeedKind : std::uint8_t { feed, revolution, rapid, thread };

/// The time law takes several steps in a period, each about this long: cells follow a bend as closely as the
/// law can use them, whatever the period.
inline constexpr double kLawStep_s = 125e-6;

/// Feed override positions for which a complete speed plan is kept; between them plans are mixed (in v²).
inline constexpr std::array<double, 3> kPlans{0.4, 1.0, kMaxOverride};
inline constexpr std::size_t kPlanCount = kPlans.size();
using PerPlan = std::array<double, kPlanCount>;

/// A stretch of the path with constant limits, as the real-time thread reads it.
struct Cell {
  double begin = 0, end = 0;    ///< programmed length [mm]
  bool stop = false;            ///< the path stops at `end`
  std::uint8_t shape = 0;       ///< Move::shape; the same from one stop to the next
  std::uint16_t smoothing = 1;  ///< periods of the moving average; the same from one stop to the next
  FeedKind kind = FeedKind::feed;
  double reference_rpm = 0;  ///< of feed per revolution
  std::size_t axes = 0;
  AxisVector gain{};       ///< acceleration an axis leaves along a straight path [mm/s²]
  AxisVector loss_up{};    ///< of it per v² by curvature when speeding up [1/mm]; negative: curvature helps
  AxisVector loss_down{};  ///< the same when braking
  double speed_up = 0, slow_down = 0;  ///< along the path, whatever the axes could [mm/s²]
  double jerk_gain = 0;                ///< |a| allowed by jerk at no speed, mm/s²
  double jerk_loss = 0;                ///< of it per v² [1/mm], >= 0
  PerPlan ceiling{};                   ///< highest v² of each plan
  PerPlan ceiling_braking{};           ///< deceleration allowed at the ceiling
  /// v² at `begin` from which the path ahead can be followed; only ever raised while published.
  std::array<std::atomic<double>, kPlanCount> entry{};

  double braking_at(double speed_squared) const { return left_of(loss_down, speed_squared); }
  /// The same for a whole period: what counts is the mean of the squares of the speed before and after, which
  /// speeding up makes larger than it was, and braking smaller.
  double acceleration_for(double speed, double period_s) const {
    double a = std::min(speed_up, jerk_gain - jerk_loss * speed * speed);
    for (std::size_t i = 0; i < axes; ++i) {
      const double left = std::max(0.0, gain[i] - loss_up[i] * speed * speed);
      a = std::min(a, left / (1 + std::max(0.0, loss_up[i]) * period_s * (speed + 0.5 * period_s * left)));
    }
    return a > 0 ? a : 0;
  }
  double braking_for(double speed, double period_s) const {
    double a = std::min(slow_down, jerk_gain - jerk_loss * speed * speed);
    for (std::size_t i = 0; i < axes; ++i)
      a = std::min(a, (gain[i] - loss_down[i] * speed * speed) /
                          (1 + std::max(0.0, -loss_down[i]) * speed * period_s));
    return a > 0 ? a : 0;
  }
  /// Braking allowed at every speed up to this one.
  double braking_up_to(double speed_squared) const {
    return std::min(braking_at(speed_squared), braking_at(0));
  }

  /// Highest v² from which, braking over `way`, v² = `ahead` is reached.
  double entry_before(double ahead, double way) const {
    const double twice = 2 * way;
    double square =
        std::min((ahead + twice * jerk_gain) / (1 + twice * jerk_loss), ahead + twice * slow_down);
    for (std::size_t i = 0; i < axes; ++i) {
      // Curvature counts where it leaves least: at the entry when it costs, at the end of the cell when it
      // helps.
      const double loss = twice * loss_down[i], most = ahead + twice * gain[i];
      square = std::min(square, loss > 0 ? most / (1 + loss) : most - loss * ahead);
    }
    return square;
  }

 private:
  double left_of(const AxisVector& loss, double speed_squared) const {
    double a = std::min(slow_down, jerk_gain - jerk_loss * speed_squared);
    for (std::size_t i = 0; i < axes; ++i) {
      const double left = gain[i] - loss[i] * speed_squared;
      if (left < a) a = left;
    }
    return a > 0 ? a : 0;
  }
};

/// What is asked of one move, in the order of the path.
struct FeedSection {
  double end = 0;  ///< programmed length [mm]
  FeedKind kind = FeedKind::feed;
  double speed = 0;  ///< at override 1 [mm/s]; infinite for rapid and thread
  double reference_rpm = 0;
  double highest = std::numeric_limits<double>::infinity();  ///< at any override [mm/s]
  double corner = std::numeric_limits<double>::infinity();   ///< the same at `end`
  /// Acceleration and braking along the path [mm/s²].
  double speed_up = std::numeric_limits<double>::infinity();
  double slow_down = std::numeric_limits<double>::infinity();
  std::uint8_t shape = 0;  ///< Move::shape
  double bell_s = 0;       ///< AccelerationShape::bell_s; both change at stops only
};

/// What a cell allows, and other cells take over where it reaches them.
struct CellLimits {
  AxisVector rate{};                    ///< largest |q'|
  AxisVector bend_up{}, bend_down{};    ///< largest q'' with, against the sense of q'; signed
  double speed = 0;                     ///< highest, whatever the override
  double feed = 0;                      ///< highest at override 1
  double speed_up = 0, slow_down = 0;   ///< as in Cell
  double jerk_gain = 0, jerk_loss = 0;  ///< as in Cell
};

/// A cell before it is final.
struct RawCell : CellLimits {
  double begin = 0, end = 0;
  bool straight = false, stop = false;
  std::uint8_t shape = 0;
  std::uint16_t smoothing = 1;
  FeedKind kind = FeedKind::feed;
  double reference_rpm = 0;
  double reach = 0;  ///< own highest speed times the window: how far its limits are spread
};

class CellMaker {
 public:
  explicit CellMaker(const machine::Machine& machine);

  static constexpr std::size_t kMostSmoothing = 1024;  ///< periods
  double period_s() const { return period_s_; }
  /// Steps of the time law in a period.
  std::size_t law_steps() const { return law_steps_; }
  /// Periods of the moving average where no bell asks for more.
  std::size_t smoothing_periods() const { return own_smoothing_; }

  void reset();
  void add_section(const FeedSection& section) { sections_.push_back(section); }
  void add(const Span& span);
  /// Next final cell; `entry` is left as it is.
  bool next(Cell& out);

 private:
  void smooth(std::size_t periods, bool asked_for);
  void begin_stretch(double from);
  void append(const RawCell& cell, double begin, double end);
  void spread_back(const RawCell& from);
  double same_feed_until(double from, double end) const;
  void cut(const Span& span, const AxisVector& following_twist);
  /// Does the third derivative change little enough at both ends of the span for steps at this speed?
  bool smooth_around(double speed) const;
  void measure(const Span& span, double from, double to, RawCell& cell);
  void add_cell(const RawCell& own, bool stop);
  void limit_by_jerk(const AxisVector& bends, const AxisVector& twist, RawCell& cell) const;

  // Of each axis; of those that the machine has not: infinite, so that loops need not ask how many there are.
  AxisVector feed_{}, rapid_{}, acceleration_{}, jerk_{};
  std::size_t axes_ = 0;
  double period_s_;
  std::size_t law_steps_;
  std::size_t own_smoothing_ = 1, smoothing_periods_ = 1;
  std::uint8_t shape_ = 0;
  double smoothing_s_ = 0, window_s_ = 0, smooth_window_s_ = 0;
  double between_s_ = 0;  // the lengths that are averaged: periods; where nothing is, the law's steps
  double longest_reach_ = 0, fastest_ = 0;
  double twist_share_ = 1;
  bool mixes_feeds_ = false;  // an average does, of neighbours
  bool jerk_limited_ = false;
  std::deque<FeedSection> sections_;
  // Handed over, then final, then those whose limits may still change.
  std::vector<RawCell> staged_;
  std::size_t taken_ = 0, final_ = 0;
  /// Some cells one behind the other: what all of them reach takes over their limits at once.
  struct Reaching {
    static constexpr std::size_t kMost = 4;
    struct One {
      double until, end, reach, speed, feed;  // end + reach, …
    };
    explicit Reaching(const RawCell& own);
    void add(const RawCell& own);
    std::array<One, kMost> ones;
    std::array<CellLimits, kMost> limits;
    CellLimits together;
    std::size_t count = 0;
    double least_until, most_until;
  };
  std::vector<Reaching> reaching_;  // cells whose limits still reach beyond the newest
  struct Ending {
    double at, end, reach;  // end + reach, and of which cell
  };
  std::vector<Ending> ending_;  // of those, inside the newest
  double newest_ = 0;
  std::optional<Span> pending_;
  AxisVector previous_twist_{};  // c[3] of the span before it; a stop counts as a straight line
  AxisVector jump_{};            // of c[3] at either end of the span that is being cut
};

}  // namespace headstock::motion

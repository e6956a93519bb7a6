// How quickly moves speed up and slow down by the parameters of the controllers: time constants and
// accelerations of rapid, cutting (also under look-ahead control) and threads. They only ever make a move
// gentler: the limits of the machine file hold whatever these say, and so does its jerk.
//
// What is taken is the acceleration, not the shape. The controllers' linear, S and bell curves become the
// kernel's own jerk-limited one; an exponential one becomes that of the same time constant (its beginning,
// without the long tail). "After interpolation" lets a real control cut corners by its lag; here the path
// stays inside the tolerance of the machine file in every mode. README.md of operation/ says what that means
// for the time.
#pragma once

#include <array>
#include <cstdint>

#include "interpreter/machine_data.hpp"
#include "machine/machine.hpp"
#include "motion/geometry.hpp"

namespace headstock::operation {

using machine::AxisVector;

/// What a move's acceleration is chosen by.
enum class MotionKind : std::uint8_t { rapid, cutting, cutting_ahead, thread, retreat };
inline constexpr std::size_t kMotionKinds = 5;

/// Look-ahead thread. 0 everywhere: only what the machine file says.
class AccelerationRules {
 public:
  /// What the parameters of this controller say; one that is not set limits nothing.
  static AccelerationRules read(const machine::Machine& machine, const interp::MachineData& data);

  /// Sets Move::speed_up_mm_s2 and slow_down_mm_s2. `retreat` is a positioning away from a thread; a control
  /// that has nothing of its own for it goes as in any positioning.
  /// @param rpm that a feed per revolution and a thread are taken at
  /// @param ratio of the acceleration of a retreat (K2000TC J/K)
  void apply(const motion::Curve& curve, motion::Move& move, MotionKind kind, double rpm,
             double ratio = 1) const;

 private:
  struct Limit {
    AxisVector axis{};    ///< of each axis [mm/s²]; 0: none
    double along = 0;     ///< along the path [mm/s²]; 0: none
    AxisVector time_s{};  ///< to the move's own feed, each axis [s]; 0: none
  };
  struct Kind {
    Limit up, down;
  };
  friend struct AccelerationReader;
  static double allowed(const Limit& limit, const motion::Curve& curve, double feed_mm_s);

  std::array<Kind, kMotionKinds> kinds_{};
};

}  // namespace headstock::operation

// How quickly moves speed up and slow down by the parameters of the controllers, and in which shape: linear,
// S or bell, exponential, before or after interpolation, for rapid, cutting (also under look-ahead control),
// threads and hands (acceleration_modes.hpp is the table). They only ever make a move gentler: the limits of
// the machine file hold whatever these say.
//
// Before interpolation the path is the programmed one inside the tolerance of the machine file. After it the
// axes lag and cut corners as on the real control; README.md of operation/ says what that means.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "interpreter/machine_data.hpp"
#include "machine/machine.hpp"
#include "motion/geometry.hpp"
#include "motion/kernel.hpp"
#include "operation/acceleration_modes.hpp"

namespace headstock::operation {

using machine::AxisVector;

/// Look-ahead thread. 0 everywhere: only what the machine file says.
class AccelerationRules {
 public:
  /// What the parameters of this controller say; one that is not set limits nothing.
  static AccelerationRules read(const machine::Machine& machine, const interp::MachineData& data);

  /// Sets Move::speed_up_mm_s2, slow_down_mm_s2 and shape.
  /// @param rpm that a feed per revolution and a thread are taken at
  /// @param ratio of the acceleration of a retreat (K2000TC J/K)
  void apply(const motion::Curve& curve, motion::Move& move, MotionKind kind, double rpm, double ratio = 1) const;
  /// The move without the filter of its shape, which would not keep it on its path: along the path as gentle as that.
  void without_filter(const motion::Curve& curve, motion::Move& move, double rpm) const;
  /// What Move::shape is about: for the kernel, before its next start.
  const motion::Kernel::Shapes& shapes() const { return shapes_; }

  struct OfHand {
    double acceleration_mm_s2 = 0;  ///< 0: the axis' own
    double bell_s = 0;              ///< in which the acceleration rises and falls
  };
  /// One axis moved by hand at this speed; the gentler one of speeding up and slowing down.
  OfHand of_hand(std::size_t axis, MotionKind kind, double speed_mm_s) const;

  /// Parameters that ask for what is not done, with what is done instead; empty: none.
  const std::string& not_done() const { return not_done_; }

 private:
  struct Limit {
    AxisVector axis{};    ///< of each axis [mm/s²]; 0: none
    double along = 0;     ///< along the path [mm/s²]; 0: none
    AxisVector time_s{};  ///< to the move's own feed, each axis [s]; 0: none
  };
  struct Kind {
    Limit up, down;
    motion::AccelerationShape shape;
    std::uint8_t number = 0;  ///< of `shape` in shapes_
  };
  friend struct AccelerationReader;
  static double allowed(const Limit& limit, const motion::Curve& curve, double feed_mm_s);

  static double speed_of(const motion::Move& move, double rpm);

  AxisVector rapid_mm_s_{};
  std::array<Kind, kMotionKinds> kinds_{};
  motion::Kernel::Shapes shapes_{};
  std::string not_done_;
};

}  // namespace headstock::operation

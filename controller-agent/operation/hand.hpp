// Axes moved one by one beside the program: jog, handle, steps, reference return with a dog, manual
// intervention while a program is held, axes of the ladder. Each axis has its own motion to a point that may
// change at any time; what comes out is an offset on top of where the kernel stands.
//
// Orders come from the controller's lock through a sequence lock an axis; everything else belongs to the
// real-time thread, without allocation.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "axes/drive.hpp"
#include "axes/point_motion.hpp"
#include "machine/machine.hpp"

namespace headstock::operation {

using machine::AxisVector;

struct HandOrder {
  enum class Kind : std::uint8_t {
    stop,    ///< come to rest
    go,      ///< to `target`
    home,    ///< over the dog to the zero mark behind it; then the axis stands at its reference point
    go_back  ///< to where the kernel stands: the offset becomes zero
  };
  Kind kind = Kind::stop;
  double target = 0;      ///< machine coordinates [mm, degrees]
  double speed_mm_s = 0;  ///< > 0
  bool rapid = false;     ///< the rapid override acts, otherwise the feed override
  double acceleration_mm_s2 = 0;  ///< at most; 0: the axis' own. Counts when the axis stands
  double bell_s = 0;              ///< in which the acceleration rises and falls
};

class Hand {
 public:
  Hand(const machine::Machine& machine, double period_s);

  // ---- under the controller's lock
  void order(std::size_t axis, const HandOrder& order) noexcept;
  /// Orders given so far.
  std::uint64_t orders() const noexcept { return given_.load(std::memory_order_relaxed); }

  // ---- real-time thread
  /// @param base where the kernel stands; it must not move while an axis of a hand moves, except axes of the
  /// ladder, which the kernel never moves.
  void step(const AxisVector& base, double feed_override, double rapid_override,
            const axes::Drive& drive) noexcept;
  /// RESET, emergency stop: everything brakes.
  void stop() noexcept;
  /// The kernel has been set to where these axes stand; bit: axis.
  void clear(std::uint32_t axes) noexcept;
  double offset(std::size_t axis) const noexcept { return motion_[axis].position(); }
  double velocity(std::size_t axis) const noexcept { return motion_[axis].velocity(); }
  bool moving() const noexcept { return moving_; }
  /// An order is not carried out to its end yet; also while an override of 0 % holds it.
  std::uint32_t busy() const noexcept { return busy_; }  ///< bit: axis
  /// Orders taken up so far; equal to orders() when none is on its way.
  std::uint64_t taken() const noexcept { return taken_; }
  /// Axes whose search for the zero mark has ended on it and whose coordinate is to be set.
  std::uint32_t homed() const noexcept { return homed_; }
  /// Axes that have left the dog before they were slow: it is too short for their speed, and no mark is safe.
  std::uint32_t failed() const noexcept { return failed_; }
  void homed_seen() noexcept { homed_ = failed_ = 0; }

 private:
  enum class Homing : std::uint8_t { off, search, slow_down, creep, mark };
  struct Slot {
    std::atomic<std::uint32_t> sequence{0};
    std::atomic<double> target{0}, speed{0}, acceleration{0}, bell{0};
    std::atomic<HandOrder::Kind> kind{HandOrder::Kind::stop};
    std::atomic<bool> rapid{false};
  };
  void take_orders(const AxisVector& base) noexcept;
  void step_homing(std::size_t axis, double base, const axes::Drive& drive) noexcept;

  std::size_t axes_;
  std::array<double, machine::kMaxAxes> creep_mm_s_{};
  std::array<bool, machine::kMaxAxes> negative_{};
  std::array<Slot, machine::kMaxAxes> slots_;
  std::atomic<std::uint64_t> given_{0};

  // real-time thread
  std::array<std::uint32_t, machine::kMaxAxes> seen_{};
  std::array<HandOrder, machine::kMaxAxes> orders_{};
  std::array<Homing, machine::kMaxAxes> homing_{};
  std::array<axes::PointMotion, machine::kMaxAxes> motion_;  // of the offset
  std::array<double, machine::kMaxAxes> goal_{};             // offset to reach
  std::uint64_t taken_ = 0;
  std::uint32_t homed_ = 0, failed_ = 0;
  std::uint32_t busy_ = 0;
  bool moving_ = false;
};

}  // namespace headstock::operation

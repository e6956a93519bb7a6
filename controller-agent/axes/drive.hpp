// What carries out the set-points: a servo drive of the field bus, the simulated one, or the one that only
// writes down. All calls come from the real-time thread, one `command` a period; no call may allocate, lock
// or throw.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "axes/electronic_gear.hpp"
#include "machine/machine.hpp"

namespace headstock::axes {

using machine::AxisVector;

class Drive {
 public:
  virtual ~Drive() = default;
  /// Power to the motors. Off: they brake and take no commands; the position stays measured.
  virtual void enable(bool on) noexcept = 0;
  /// Set-point of this period, machine coordinates [mm, degrees].
  virtual void command(const AxisVector& position) noexcept = 0;
  /// Measured position, machine coordinates.
  virtual AxisVector actual() const noexcept = 0;
  /// What is measured now is called this from now on (after homing, at start); nothing moves. Not while
  /// moving.
  virtual void set_position(const AxisVector& position) noexcept = 0;

  /// Gain of the axis' position loop [1/s]; 0: it follows without any lag.
  virtual double position_gain(std::size_t) const noexcept { return 0; }

  // ---- reference return of axes without an absolute encoder
  /// The deceleration switch is touched.
  virtual bool dog(std::size_t) const noexcept { return false; }
  /// Way from the measured position to the next zero mark of the encoder; `sense` 1 or -1, so is the result's
  /// sign.
  virtual double way_to_mark(std::size_t, double) const noexcept { return 0; }
  virtual double mark_distance(std::size_t) const noexcept { return 0; }
};

/// Follows without any error; for virtual time, where the commanded path itself is looked at.
class IdealDrive final : public Drive {
 public:
  void enable(bool on) noexcept override { enabled_ = on; }
  void command(const AxisVector& position) noexcept override {
    if (enabled_) position_ = position;
  }
  AxisVector actual() const noexcept override { return position_; }
  void set_position(const AxisVector& position) noexcept override { position_ = position; }

 private:
  AxisVector position_{};
  bool enabled_ = true;
};

/// Follows ideally and keeps the first `capacity` set-points it got.
class RecorderDrive final : public Drive {
 public:
  explicit RecorderDrive(std::size_t capacity) { record_.reserve(capacity); }
  void enable(bool on) noexcept override { ideal_.enable(on); }
  void command(const AxisVector& position) noexcept override {
    if (record_.size() < record_.capacity()) record_.push_back(position);
    ideal_.command(position);
  }
  AxisVector actual() const noexcept override { return ideal_.actual(); }
  void set_position(const AxisVector& position) noexcept override { ideal_.set_position(position); }
  const std::vector<AxisVector>& record() const { return record_; }

 private:
  IdealDrive ideal_;
  std::vector<AxisVector> record_;
};

/// Servo axes as a position loop over a velocity loop over an inertia with friction: they lag by speed /
/// position gain, settle without overshoot, and cannot accelerate faster than their torque allows. The
/// numbers are those of the machine file (`[axis.X] position_gain_per_s`, `torque_reserve`, …).
class SimulatedDrive final : public Drive {
 public:
  explicit SimulatedDrive(const machine::Machine& machine);
  void enable(bool on) noexcept override { enabled_ = on; }
  void command(const AxisVector& position) noexcept override;
  AxisVector actual() const noexcept override;
  void set_position(const AxisVector& position) noexcept override;
  /// Commanded minus measured [mm].
  AxisVector following_error() const noexcept;
  double position_gain(std::size_t axis) const noexcept override { return servo_[axis].position_gain_per_s; }
  bool dog(std::size_t axis) const noexcept override;
  double way_to_mark(std::size_t axis, double sense) const noexcept override;
  double mark_distance(std::size_t axis) const noexcept override { return servo_[axis].grid; }
  /// Where the slide really is, whatever the control calls it.
  double true_position(std::size_t axis) const noexcept { return servo_[axis].position + servo_[axis].zero; }
  /// Before power on somebody has moved the slide here.
  void place(std::size_t axis, double true_position_mm) noexcept;

  // ---- faults, for tests and training; the thread that calls command()
  /// The slide is jammed: no torque moves it.
  void jam(std::size_t axis, bool jammed) noexcept { servo_[axis].jammed = jammed; }
  /// Something moves the slide by this much at once [mm].
  void push(std::size_t axis, double by_mm) noexcept { servo_[axis].position += by_mm; }

 private:
  struct Servo {
    double position_gain_per_s = 50, velocity_gain_per_s = 600;
    double acceleration_limit = 0, friction = 0, encoder_mm = 0;
    ElectronicGear gear;
    double dog = 0, dog_width = 0, grid = 1;
    double command = 0, position = 0, velocity = 0;  // as the control counts
    double zero = 0;                                 // where its count is zero
    bool jammed = false;
    double measured() const noexcept;
  };

  std::size_t axes_;
  double period_s_;
  std::array<Servo, machine::kMaxAxes> servo_{};
  bool enabled_ = true;
};

/// The drive that the machine file names.
std::unique_ptr<Drive> make_drive(const machine::Machine& machine);

}  // namespace headstock::axes

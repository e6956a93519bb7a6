// What carries out the set-points: a servo drive of the field bus, the simulated one, or the one that only
// writes down. All calls come from the real-time thread, one `command` a period; no call may allocate, lock
// or throw.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

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
  /// The machine stands here (after homing, at start). Not while moving.
  virtual void set_position(const AxisVector& position) noexcept = 0;
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

/// A servo axis as a position loop over a velocity loop over an inertia: it lags by speed / position_gain,
/// settles without overshoot, and cannot accelerate faster than its torque allows.
struct ServoTuning {
  double position_gain_per_s = 50;   ///< following error [mm] = speed [mm/s] / this
  double velocity_gain_per_s = 600;  ///< 1 / time constant of the velocity loop
  double torque_reserve = 2.5;       ///< greatest acceleration, as a multiple of the axis' max_acceleration
};

class SimulatedDrive final : public Drive {
 public:
  SimulatedDrive(const machine::Machine& machine, const ServoTuning& tuning = {});
  void enable(bool on) noexcept override { enabled_ = on; }
  void command(const AxisVector& position) noexcept override;
  AxisVector actual() const noexcept override { return position_; }
  void set_position(const AxisVector& position) noexcept override;
  /// Commanded minus measured [mm].
  AxisVector following_error() const noexcept;

 private:
  ServoTuning tuning_;
  std::size_t axes_;
  double period_s_;
  AxisVector acceleration_limit_{};
  AxisVector command_{}, position_{}, velocity_{};
  bool enabled_ = true;
};

}  // namespace headstock::axes

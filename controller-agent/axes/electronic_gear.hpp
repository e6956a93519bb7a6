// Electronic gear: a drive that counts pulses gets position × numerator / denominator in pulses of 1 µm
// (0.001°). Every position is turned into its pulse count by itself, so that no rounding adds up.
#pragma once

#include <cmath>
#include <cstdint>

namespace headstock::axes {

class ElectronicGear {
 public:
  ElectronicGear() = default;
  /// @param numerator 0: no gear, positions pass as they are. @param denominator > 0
  ElectronicGear(int numerator, int denominator) : pulses_per_mm_(1000.0 * numerator / denominator) {}
  bool geared() const noexcept { return pulses_per_mm_ > 0; }
  std::int64_t pulses(double position_mm) const noexcept {
    return std::llround(position_mm * pulses_per_mm_);
  }
  /// Where the motor is at whole pulses.
  double position(double position_mm) const noexcept {
    return geared() ? static_cast<double>(pulses(position_mm)) / pulses_per_mm_ : position_mm;
  }

 private:
  double pulses_per_mm_ = 0;
};

}  // namespace headstock::axes

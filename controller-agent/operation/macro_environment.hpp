// What macros may ask of the running machine: time goes on, and what looks at the machine waits for a
// standstill. Look-ahead thread, under the controller's lock.
#pragma once

#include <atomic>
#include <cstdint>

#include "macro/environment.hpp"
#include "operation/controller.hpp"
#include "operation/realtime.hpp"

namespace headstock::operation {

class MacroEnvironment final : public macro::Environment {
 public:
  /// @param waiting threads that want the controller's lock.
  MacroEnvironment(Realtime& realtime, Retained& retained, const std::atomic<int>& waiting, double period_s)
      : realtime_(realtime), retained_(retained), waiting_(waiting), period_ms_(period_s * 1e3) {}

  bool takes_time() const override { return true; }
  bool has_signals() const override { return false; }  // the ladder engine will bring UI and UO
  bool wants_pause() override;

  double clock_ms() override;
  void set_clock_ms(double value) override;
  double clock_hours() override;
  void set_clock_hours(double value) override;
  double parts_made() override { return static_cast<double>(retained_.parts); }
  void set_parts_made(double value) override {
    retained_.parts = static_cast<decltype(retained_.parts)>(value);
  }

 private:
  double running_hours();

  Realtime& realtime_;
  Retained& retained_;
  const std::atomic<int>& waiting_;
  const double period_ms_;
  double clock_offset_ms_ = 0, hours_offset_ = 0;
  std::uint32_t asked_ = 0;
};

}  // namespace headstock::operation

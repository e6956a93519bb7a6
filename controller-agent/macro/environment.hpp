// What only the running machine knows: signals, clocks, where the axes really are. The operation layer
// implements it; the default serves the offline tools: nothing takes time, inputs are what was set, outputs are
// kept, and the clock goes on with every look at it, so that a program that waits comes to its end.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "machine/axes.hpp"

namespace headstock::macro {

/// Look-ahead thread.
class Environment {
 public:
  virtual ~Environment() = default;

  /// Operations handed out take time: before a statement that looks at the machine, Interpreter::next returns
  /// Pull::standstill, and the next call promises that everything handed out has been carried out.
  virtual bool takes_time() const { return false; }
  /// Asked about every thousand blocks of a calculation without output: true makes next() return Pull::pause,
  /// so that whoever waits for the controller's lock gets it. The calculation goes on with the next call.
  virtual bool wants_pause() { return false; }
  /// Asked as often: true ends the program at once, with the End reason `stopped`.
  virtual bool wants_stop() { return false; }

  /// Whether somebody gives the inputs and takes the outputs; otherwise they are variables that do not exist: a
  /// signal nobody connected must not be read as 0.
  virtual bool has_signals() const { return true; }
  /// Interface input UI, 0…127 (#1000-#1035).
  virtual bool input(unsigned bit) const { return inputs_[bit % kSignals]; }
  virtual void set_input(unsigned bit, bool on) { inputs_[bit % kSignals] = on; }
  /// Interface output UO, 0…127 (#1100-#1135), and what it was set to last.
  virtual bool output(unsigned bit) const { return outputs_[bit % kSignals]; }
  virtual void set_output(unsigned bit, bool on) { outputs_[bit % kSignals] = on; }

  /// #3001, ms; #3002, hours of cutting programs (kept over power-off).
  virtual double clock_ms();
  virtual void set_clock_ms(double value) { clock_ms_ = value; }
  virtual double clock_hours() { return clock_hours_; }
  virtual void set_clock_hours(double value) { clock_hours_ = value; }
  virtual std::uint32_t date();  ///< yyyymmdd
  virtual std::uint32_t time();  ///< hhmmss

  /// #3901, #3902.
  virtual double parts_made() { return parts_made_; }
  virtual void set_parts_made(double value) { parts_made_ = value; }
  virtual double parts_required() { return parts_required_; }
  virtual void set_parts_required(double value) { parts_required_ = value; }

  /// Measured or commanded machine position, slide mm; nothing: the interpreter's own end of block is right.
  virtual std::optional<machine::AxisVector> machine_position() { return std::nullopt; }
  /// Where the last G31 was met, machine position; nothing: the end of its block.
  virtual std::optional<machine::AxisVector> skip_position() { return std::nullopt; }
  virtual double servo_deviation(std::size_t /*axis*/) { return 0; }       ///< #5101, mm
  virtual double handle_interruption(std::size_t /*axis*/) { return 0; }  ///< #5121, mm
  virtual double distance_to_go(std::size_t /*axis*/) { return 0; }       ///< #5181, mm; 0 at a standstill
  virtual std::uint32_t mirror_image() { return 0; }  ///< #3007: signals and settings, bit n = axis n
  virtual bool restarting() { return false; }         ///< #3008
  virtual std::uint32_t settings() { return settings_; }  ///< #3005
  virtual void set_settings(std::uint32_t value) { settings_ = value; }

 private:
  static constexpr std::size_t kSignals = 128;
  std::array<bool, kSignals> inputs_{}, outputs_{};
  double clock_ms_ = 0, clock_hours_ = 0, parts_made_ = 0, parts_required_ = 0;
  std::uint32_t settings_ = 0;
};

}  // namespace headstock::macro

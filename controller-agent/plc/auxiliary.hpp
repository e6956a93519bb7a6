// Auxiliary functions: an M, S or T code goes to the machine as a request and the program goes on when the
// machine says "finished" (the FIN handshake). A ladder program can take the place of the built-in answer
// behind the same interface. Every call comes from the real-time thread: no allocation, lock, system call or
// exception.
#pragma once

#include <cstdint>

namespace headstock::plc {

enum class FunctionKind : std::uint8_t { m, spindle, tool };
enum class Turning : std::int8_t { stop = 0, clockwise = 1, counterclockwise = -1 };

/// One strobe.
struct Request {
  FunctionKind kind = FunctionKind::m;
  std::int32_t code = 0;            ///< M or T number
  std::int32_t offset = 0;          ///< T: offset number
  Turning turning = Turning::stop;  ///< spindle: the state it shall have
  double speed = 0;                 ///< rpm, or m/min under constant surface speed
  bool constant_surface_speed = false;
  double clamp_rpm = 0;  ///< 0: none
};

/// What the machine reports to the ladder.
struct Inputs {
  bool spindle_at_speed = true;
  double period_s = 0.001;
};

/// What the ladder switches.
struct Outputs {
  Turning turning = Turning::stop;
  double speed = 0;
  bool constant_surface_speed = false;
  double clamp_rpm = 0;
  bool coolant = false;
  bool mist = false;
  std::int32_t tool = 0;  ///< in the spindle or cutting position
};

class Auxiliary {
 public:
  virtual ~Auxiliary() = default;
  /// Starts one function. Precondition: `finished()`.
  virtual void request(const Request& request) noexcept = 0;
  /// One period; also when nothing is requested.
  virtual void step(const Inputs& inputs) noexcept = 0;
  /// The last request is done (FIN).
  virtual bool finished() const noexcept = 0;
  virtual const Outputs& outputs() const noexcept = 0;
  /// RESET or emergency stop: the running function is dropped, spindle and coolant stop.
  virtual void reset() noexcept = 0;
};

}  // namespace headstock::plc

// Auxiliary functions: an M, S or T code goes to the machine as a request and the program goes on when the
// machine says "finished" (the FIN handshake). A ladder program can take the place of the built-in answer
// behind the same interface. Every call comes from the real-time thread: no allocation, lock, system call or
// exception.
#pragma once

#include <cstdint>

namespace headstock::plc {

enum class FunctionKind : std::uint8_t { m, spindle, tool, second_auxiliary };
enum class Turning : std::int8_t { stop = 0, clockwise = 1, counterclockwise = -1 };

inline constexpr std::uint8_t kNoAxis = 0xff;

/// One strobe.
struct Request {
  FunctionKind kind = FunctionKind::m;
  std::int32_t code = 0;            ///< M or T number, or that of the second auxiliary function
  std::int32_t offset = 0;          ///< T: offset number
  Turning turning = Turning::stop;  ///< spindle: the state it shall have
  double speed = 0;                 ///< rpm, or m/min under constant surface speed
  bool constant_surface_speed = false;
  double clamp_rpm = 0;                 ///< 0: none
  std::uint8_t surface_axis = kNoAxis;  ///< whose distance from the centre makes surface speed; none: X
};

/// What the machine reports to the ladder.
struct Inputs {
  bool spindle_at_speed = true;
  bool spindle_oriented = false;  ///< stands at its angle, under position control
  bool contour_ready = false;     ///< follows the Cs axis
  double period_s = 0.001;
};

/// What the ladder switches.
struct Outputs {
  Turning turning = Turning::stop;
  double speed = 0;
  bool constant_surface_speed = false;
  double clamp_rpm = 0;
  std::uint8_t surface_axis = kNoAxis;
  std::uint32_t spindle_orders = 0;  ///< grows with every change asked of the spindle
  bool orient = false;               ///< turn to the angle of the machine file and hold it
  bool contour = false;              ///< position control by the Cs axis
  bool coolant = false;
  bool mist = false;
  std::int32_t tool = 0;  ///< in the spindle or cutting position
  std::int32_t second_auxiliary = 0;
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

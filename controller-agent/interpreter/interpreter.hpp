// One path's interpreter: pulls blocks from a program, keeps the modal state, and hands out canonical
// operations one at a time. Streaming: memory does not grow with the program. Not thread-safe; belongs to the
// look-ahead thread.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "interpreter/canonical.hpp"
#include "interpreter/machine_data.hpp"
#include "machine/machine.hpp"
#include "program/source.hpp"

namespace headstock::dialects {
struct Dialect;
}

namespace headstock::interp {

struct Executor;

/// What a number without a decimal point means.
enum class DecimalPoint : std::uint8_t {
  as_machine,  ///< as the dialect and its parameter say
  standard,    ///< X10 is 10 least increments
  pocket       ///< pocket calculator: X10 is 10 mm
};

/// Switches of the machine that change what a block means.
struct Switches {
  std::uint32_t block_skip = 0;  ///< bit n: /n is on (bit 1 also serves plain "/")
  bool optional_stop = false;    ///< M01 stops
  bool dry_run = false;
  bool lenient = false;     ///< field files: `;` comments, no O/%, bare numbers as mm
  char gcode_system = 'A';  ///< A, B or C (fanuc-0i-t)
  DecimalPoint decimal_point = DecimalPoint::as_machine;
};

enum class Pull {
  operation,  ///< `out` holds the next operation
  wait,       ///< the source has no data yet
  finished    ///< the End (or Alarm) operation has already been handed out
};

class Interpreter {
 public:
  /// @param programs may be nullptr: then M98 and macro calls find nothing.
  Interpreter(const dialects::Dialect& dialect, const machine::Machine& machine, MachineData& data,
              program::Programs* programs);
  ~Interpreter();
  Interpreter(const Interpreter&) = delete;
  Interpreter& operator=(const Interpreter&) = delete;

  void set_switches(const Switches& switches);
  void on_data_change(DataChanged callback);

  /// Starts a main program from its beginning with the modal state in force. The machine stands at
  /// `machine_position`.
  void start(std::unique_ptr<program::Source> main, const AxisVector& machine_position);

  /// Produces the next operation. Never blocks, never throws on bad input: misuse is an Alarm operation.
  Pull next(Operation& out);

  /// The controller's RESET: modal state as its parameters say; the program is left. Position: where the axes
  /// stand.
  void reset(const AxisVector& machine_position);

  /// Where the axes really stand, when a move did not end as programmed (skip, manual intervention, abort).
  void set_position(const AxisVector& machine_position);

  /// A skip move (`Feed::skip_signals`) is over: by a signal, or at its end. Called before the next operation is
  /// asked for.
  void skip_ended(const AxisVector& machine_position, bool triggered);

  /// The tool in use has cut for this long: tool life that counts time. Told by whoever carries out the moves.
  void tool_cut_for(double seconds);

  const ModalSnapshot& modal() const;
  /// Absolute position page for a machine position, under the state in `modal`: programming units, X as
  /// diameter.
  AxisVector to_work(const AxisVector& machine_position, const ModalSnapshot& modal) const;

 private:
  std::unique_ptr<Executor> executor_;
};

}  // namespace headstock::interp

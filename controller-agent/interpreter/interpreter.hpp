// One path's interpreter: pulls blocks from a program, keeps the modal state, and hands out canonical
// operations one at a time. Streaming: memory does not grow with the program. Not thread-safe; belongs to the
// look-ahead thread.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "interpreter/canonical.hpp"
#include "interpreter/machine_data.hpp"
#include "machine/machine.hpp"
#include "program/source.hpp"

namespace headstock::dialects {
struct Dialect;
}

namespace headstock::macro {
class Environment;
}

namespace headstock::interp {

struct Executor;

/// What a number without a decimal point means.
enum class DecimalPoint : std::uint8_t {
  as_machine,  ///< as the dialect and its parameter say
  standard,    ///< X10 is 10 least increments
  pocket       ///< pocket calculator: X10 is 10 mm
};

/// Where the main program comes from: some codes are not allowed everywhere.
enum class ProgramOrigin : std::uint8_t {
  memory,
  mdi,  ///< typed at the panel
  dnc   ///< over a line: cannot be searched
};

/// Switches of the machine that change what a block means.
struct Switches {
  std::uint32_t block_skip = 0;  ///< bit n: /n is on (bit 1 also serves plain "/")
  bool optional_stop = false;    ///< M01 stops
  bool dry_run = false;
  bool lenient = false;     ///< field files: `;` comments, no O/%, bare numbers as mm
  char gcode_system = 'A';  ///< A, B or C (fanuc-0i-t)
  DecimalPoint decimal_point = DecimalPoint::as_machine;
  ProgramOrigin origin = ProgramOrigin::memory;
  /// Jumps without motion, dwell, stop or M code before a program is called endless (HS0001). A loop that
  /// assigns nothing and looks at nothing is endless after a hundred thousand.
  std::uint64_t most_jumps = 20'000'000;
};

/// Where a program is taken up again (0i-D III-4.6).
struct RestartPoint {
  std::uint32_t block = 0;       ///< SourcePosition::block; 0: by sequence number
  std::uint32_t sequence = 0;    ///< N of the block; 0: by block
  std::uint32_t occurrence = 1;  ///< which time that N is reached
};

/// What the part before a restart left behind, for the operator and for the way back to the work.
struct RestartState {
  AxisVector position{};            ///< machine position where the block begins, slide mm
  std::vector<std::int32_t> m;      ///< M codes passed, the newest 35, oldest first
  std::int32_t tool = 0, offset = 0;
  double spindle = 0;               ///< S in force
  ModalSnapshot modal;
};

enum class Pull {
  operation,  ///< `out` holds the next operation
  wait,       ///< the source has no data yet
  standstill,  ///< a macro looks at the machine: carry out everything handed out, then ask again. Only with an
               ///< Environment that takes time
  pause,       ///< a long calculation lets others have their turn: ask again. Only when the Environment wants it
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
  /// Offsets or parameters were changed by hand while no program runs: positions are shown with the new ones.
  void data_edited();
  /// What macros ask of the running machine. Must outlive the interpreter; nullptr: the offline default.
  void set_environment(macro::Environment* environment);

  /// Starts a main program from its beginning with the modal state in force. The machine stands at
  /// `machine_position`.
  void start(std::unique_ptr<program::Source> main, const AxisVector& machine_position);

  /// Starts a main program at a block in its middle: the part before it is run through without anything being
  /// handed out, and what it would write to offsets and kept variables is not written again. After `wait` and
  /// `pause` it is gone on with by run_through().
  /// @return operation: the block is reached, next() begins with it; finished: there is no such block, the alarm
  /// comes with next(). Nothing has moved: the way to `restart_state().position` is the caller's.
  Pull restart(std::unique_ptr<program::Source> main, const AxisVector& machine_position,
               const RestartPoint& point);
  Pull run_through();
  const RestartState& restart_state() const;

  /// Produces the next operation. Never blocks, never throws on bad input: misuse is an Alarm operation.
  Pull next(Operation& out);

  /// The controller's RESET: modal state as its parameters say; the program is left. Position: where the axes
  /// stand.
  /// @param first_block_left number (SourcePosition::block) of the first block that has not been carried out whole:
  /// what it and all behind it have changed is taken back first (0i-D K.32.1). 0: everything was carried out.
  void reset(const AxisVector& machine_position, std::uint32_t first_block_left = 0);
  /// After a standstill: from now on no RESET takes back what blocks before this one have written.
  void carried_out(std::uint32_t first_block_left);

  /// Where the axes really stand, when a move did not end as programmed (skip, manual intervention, abort).
  void set_position(const AxisVector& machine_position);

  /// The interruption macro (M96 P): to be called between two pulls, with everything handed out carried out or
  /// dropped, when the interruption signal has come. The axes stand at `machine_position`.
  /// @return false when no interruption is enabled or one is running: nothing has happened.
  /// @param inside_block the axes stand inside a block's move, not at its end
  bool interrupt(const AxisVector& machine_position, bool inside_block = false);
  /// An interruption program runs that has commanded nothing yet: whoever broke into a block keeps the rest of it.
  /// When the program returns so, the block goes on from where it was (0i-D 14.9.3, type I).
  bool interruption_only_looks() const;
  /// The interruption program has returned without commanding anything: the block it broke into goes on. True
  /// until the next one.
  bool interruption_left_block() const;
  /// How the control's parameters say the signal is taken.
  struct InterruptionSignal {
    bool inside_blocks = false;  ///< at once; otherwise when the block is over
    bool by_level = false;       ///< as long as it is on; otherwise on its rising edge
  };
  InterruptionSignal interruption_signal() const;
  /// M96 is in force and no interruption program runs: the look-ahead takes one block at a time, so that an interruption finds the machine where
  /// the interpreter is.
  bool interruption_enabled() const;

  /// Switches of macro statements in force (#3003, and #3004 four bits higher).
  std::uint32_t macro_control() const;

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

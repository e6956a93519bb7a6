// The embedded CNC of one machine, as one object: modes, start, hold, reset, alarms, part count. `step()` is
// one interpolation period; `work()` interprets and plans ahead. An agent calls them on two threads, the
// simulator on one. README.md of this folder says how the parts work together and what the machine does when.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "axes/drive.hpp"
#include "axes/spindle.hpp"
#include "interpreter/interpreter.hpp"
#include "machine/machine.hpp"
#include "motion/kernel.hpp"
#include "operation/breakpoint.hpp"
#include "operation/run_record.hpp"
#include "plc/auxiliary.hpp"

namespace headstock::operation {

using machine::AxisVector;

enum class Mode : std::uint8_t {
  edit,
  memory,
  mdi,
  jog,
  handle,
  reference,
  remote
};  // remote: DNC/RMT drip-feed
enum class State : std::uint8_t {
  idle,
  running,
  hold,
  stopped,
  alarm,
  emergency_stop
};  // stopped: M00/single block

/// What a panel or the link asks for. Refusals come back with a reason; nothing is queued for later.
enum class Action : std::uint8_t {
  cycle_start,
  feed_hold,
  reset,
  emergency_stop,
  emergency_stop_release,
  arm_remote,
  disarm_remote,  // only from the machine's own panel
  set_mode,
  set_feed_override,
  set_rapid_override,
  set_spindle_override,
  set_single_block,
  set_optional_stop,
  set_block_skip,
  set_dry_run,
  set_machine_lock,
  set_parts_required,
  reset_parts,
  set_axis_lock,        // value: axes whose drives keep their place, bit: axis (Z lock, MLK of single axes)
  set_manual_absolute,  // off: what is moved by hand in a held program displaces the rest of it
  tap_retract           // pulls a tap out that was stopped in its hole
};
/// The network may always stop (feed_hold, emergency_stop, disarm_remote) and set what moves nothing
/// (set_parts_required, reset_parts); everything else is refused with "not_armed" unless the operator has
/// armed remote operation at the panel. Arming, releasing an emergency stop and machine lock are the panel's
/// alone ("panel_only"). Arming ends by disarm_remote, link_lost(), emergency stop, a reset that clears an
/// alarm, and a restart of the agent.
enum class Origin : std::uint8_t { panel, network };

/// `value`: 0/1 for switches, a factor (1 = 100 %) for overrides, the Mode's number, a number of parts.
struct Command {
  Action action;
  Origin origin = Origin::panel;
  double value = 0;
  std::string user = {};  ///< who, when known: named in the record of a run
};
/// `reason` is a message key (see web locales), e.g. "not_armed", "running", "alarm"; empty when accepted.
struct CommandResult {
  bool accepted = false;
  std::string reason;
};

struct ActiveAlarm {
  std::uint64_t id = 0;  ///< grows by one with each alarm of this controller
  std::string code;
  std::string text_en, text_zh;
  interp::SourcePosition at;
  std::int64_t raised_ms = 0;  ///< Unix time
  bool message = false;  ///< an operator message: does not stop a cycle start, which clears it (data ran out)
};

/// Everything a screen shows, taken at one instant.
struct Live {
  Mode mode = Mode::memory;
  State state = State::idle;
  bool remote_armed = false;
  std::string program_name;        ///< "O1001" or the file's name
  interp::SourcePosition at;       ///< of the block being executed
  std::string block;               ///< its text
  std::vector<std::string> modal;  ///< "G01", "G97", … in the order the controller's page shows them
  std::int32_t tool = 0, offset = 0;
  std::vector<std::string> axes;
  /// absolute, relative: programming units, X as a diameter where so. machine: slide position as measured by
  /// the drives [mm]. distance_to_go: of the block, X as a diameter where so.
  AxisVector absolute{}, relative{}, machine{}, distance_to_go{};
  double feed_actual_mm_min = 0, feed_commanded = 0;
  double spindle_actual_rpm = 0, spindle_commanded_rpm = 0;
  double feed_override = 1, rapid_override = 1, spindle_override = 1;
  bool single_block = false, optional_stop = false, block_skip = false, dry_run = false, machine_lock = false;
  std::uint64_t parts = 0, parts_required = 0, parts_total = 0;
  double run_time_s = 0, cutting_time_s = 0, cycle_time_s = 0, last_cycle_s = 0;
  double progress = 0;  ///< 0…1 of the program by bytes (drip-feed: of the announced length); <0 unknown
  std::vector<ActiveAlarm> alarms;
  std::uint64_t periods = 0, overruns = 0;
  std::string message;  ///< last #3006 text or comment to show
  bool coolant = false;
  std::uint32_t axis_lock = 0;  ///< bit: axis
  std::uint32_t homed = ~0u;    ///< axes whose reference point is known; bit: axis
  bool manual_absolute = true;
  bool displaced = false;           ///< a hand has moved the axes away from where the held program is
  bool tap_in_hole = false;         ///< a tap was stopped in its hole: tap_retract pulls it out
  std::uint64_t program_bytes = 0;  ///< length of the selected program; 0 unknown
  RestartReport restart;            ///< found, and waiting for cycle start
  Breakpoint breakpoint;            ///< where the last program was when it ended before its end
};

// ---- what must not be lost: handed to the storage thread, which commits before the controller goes on
struct PartCounted {
  std::uint64_t count;
  std::uint64_t total;
  std::string program;
  std::string revision_hash;
  double cycle_s;
};
struct AlarmRaised {
  ActiveAlarm alarm;
  std::string block;
};
struct AlarmCleared {
  std::uint64_t id;
};
struct RunStarted {
  std::uint64_t run;
  std::string program;
  std::string revision_hash;
  std::uint64_t total = 0;  ///< part counter (total) when it started: the second witness of the parts made
  std::string by = {};      ///< who pressed cycle start; empty: at the machine
};
struct RunEnded {
  std::uint64_t run;
  std::string outcome;  // "completed" "reset" "alarm" "interrupted": the agent ended while it ran
  double run_s, cutting_s;
  std::uint64_t total = 0;  ///< part counter when it ended
  RunRecord record = {};
};
struct StateChanged {
  State state;
  Mode mode;
};
struct OffsetChanged {
  interp::DataChange change;
  std::string origin;
  std::string by = {};             ///< the person, when it was one
  std::uint64_t request = 0;       ///< the server's number of the request, 0: none
};
using Event =
    std::variant<PartCounted, AlarmRaised, AlarmCleared, RunStarted, RunEnded, StateChanged, OffsetChanged>;
struct TimedEvent {
  std::int64_t at_ms;
  Event event;
};

/// What survives a restart of the agent.
struct Retained {
  std::uint64_t parts = 0, parts_total = 0, parts_required = 0;
  std::uint64_t last_run = 0, last_alarm = 0;
  double feed_override = 1, rapid_override = 1, spindle_override = 1;
  bool run_open = false;  ///< a run had begun and its end was not recorded
  Breakpoint breakpoint;  ///< while a program runs: the block it is at; stays when it does not come to its end
};

/// What the storage thread takes at once.
struct Taken {
  std::vector<TimedEvent> events;
  Retained retained;
  std::optional<interp::MachineData> data;  ///< when an event is about it
};

struct ControllerOptions {
  std::unique_ptr<axes::Drive> drive;         ///< none: the simulated servo drive
  std::unique_ptr<plc::Auxiliary> functions;  ///< none: plc::BuiltIn
  Retained retained;
  bool skip_input =
      false;  ///< the machine has a skip input (see set_skip_signals); without it G31 is an alarm
  interp::Switches switches;  ///< lenient, G-code system, decimal point; the rest comes from the panel
  std::function<std::int64_t()>
      now_ms;  ///< none: the system clock. Unix time; called by any but the real-time thread
};

struct EditRequest;
struct EditResult;
struct TouchRequest;

class Controller {
 public:
  /// @param data offsets, parameters and variables; from here on the controller's own: see data(),
  /// edit_data(). Throws std::invalid_argument when machine.profile is none of the six or the machine has no
  /// axes.
  Controller(machine::Machine machine, interp::MachineData data, ControllerOptions options = {});
  ~Controller();
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  // ---- any thread but the real-time one
  CommandResult command(const Command& command);
  /// Chooses the program that cycle start runs. Refused while running. `memory` also serves its sub-programs.
  /// A choice by the network while not armed is not started by the first press of cycle start at the panel
  /// ("selected_remotely"): the operator has to see it first. Arming counts as having seen it.
  CommandResult select(std::string name, std::string revision_hash, std::shared_ptr<program::Programs> memory,
                       Origin origin = Origin::panel);
  /// DNC mode: run from a stream of `total_bytes` (0: unknown). It can be run once; reset drops it.
  /// @param why_broken asked when the stream failed: a message key ("line_parity" …) that becomes the
  /// controller's own alarm (input_alarm.hpp). Called on the look-ahead thread.
  CommandResult select_stream(std::string name, std::string revision_hash,
                              std::unique_ptr<program::Source> stream, std::uint64_t total_bytes,
                              Origin origin = Origin::panel, std::function<std::string()> why_broken = {});
  // Moving by hand. The machine's own panel only: there is no way from the network to these.
  //
  // In a held or stopped program (manual intervention): choose jog or handle mode, move, choose the mode of
  // the program again, cycle start. The axes first go back to where they were, at the dry-run feed, then the
  // program goes on; with manual absolute off it goes on displaced by what the hand has moved.
  enum class JogSpeed : std::uint8_t { feed, rapid };
  /// Jog mode: moves the axis while the button is down; `direction` 1, -1, or 0 when it is let go. Several
  /// axes may move at once. Feed: parameter 1423 of the axis [mm/min] if set, times the feed override; rapid:
  /// 1424 or the rapid rate, times the rapid override. Stops at the stored stroke limit, and before a
  /// forbidden zone.
  CommandResult jog(std::size_t axis, int direction, JogSpeed speed = JogSpeed::feed);
  /// Jog mode (incremental feed) or handle mode: moves by this distance [mm, degrees]; more may be given
  /// while it moves. What does not fit inside the travel is refused.
  CommandResult step_axis(std::size_t axis, double distance_mm);
  /// Reference mode: to reference point 1 at rapid rate; an axis without an absolute encoder over its dog to
  /// the zero mark the first time.
  CommandResult reference_return(std::size_t axis);
  /// Memory mode: the selected program is run through, without anything moving, up to this block; then the
  /// machine is stopped and Live::restart says what it needs. Cycle start brings the axes there one at a time at
  /// the dry-run feed (in the order of parameter 7310), and the program goes on. M, S and T that were passed are
  /// not given again: cycle start is refused while the spindle does not turn, or another tool is in place than
  /// the program needs there ("restart_spindle", "restart_tool").
  /// @param point none: at the breakpoint of the last run; refused when another revision is selected.
  CommandResult restart(const std::optional<interp::RestartPoint>& point);
  /// Handle mode, in a held program: along the path that was traced, < 0 back, > 0 forward, but not beyond
  /// where the program was held [mm, degrees like mm]. Feed hold stops it; cycle start goes forward to the
  /// hold first.
  CommandResult retrace(double way_mm);
  /// The ladder moves one of its axes (`[axis.B] plc = true`); also while a program runs. Any thread.
  CommandResult move_plc_axis(std::size_t axis, double target_mm, double feed_mm_min);
  /// MDI mode: the block that cycle start carries out, once.
  CommandResult enter_mdi(std::string text);
  /// The skip inputs as they are now (interp::Feed::skip_signals); any thread, takes effect in the next
  /// period.
  void set_skip_signals(std::uint16_t signals) noexcept;
  /// The interruption signal of M96 (UINT) as it is now; any thread. A pulse is not lost however short.
  void set_interruption_signal(bool on) noexcept;
  /// The connection is gone: remote arming ends, nothing else.
  void link_lost();
  Live live() const;
  Retained retained() const;
  const machine::Machine& machine() const;
  interp::MachineData data() const;
  /// Changes offsets or parameters by hand. Refused while running.
  CommandResult edit_data(const std::function<void(interp::MachineData&)>& edit,
                          const interp::DataChange& change, const std::string& origin);
  /// Writes values by name, all of them or none, if the controller's rules allow it now (dialects/data_rules)
  /// and each still has the value that the person saw. See operation/data_edit.hpp.
  EditResult edit_values(const EditRequest& request);
  /// A measured place becomes an offset; see operation/data_edit.hpp.
  EditResult touch(const TouchRequest& request);
  /// The switch at the machine that lets parameters be written (EditRequest::parameter_write is its place). On: the
  /// control's alarm for it (0i-D SW0100, GSK 100), which RESET clears once the switch is off again. Refused: "running".
  CommandResult set_parameter_write(bool on);

  // ---- storage thread: take events, commit them, then say so (the part count's M30 is finished only after
  // that)
  bool take_event(TimedEvent& out);
  /// Called when there is an event to take or a retained value may have changed, on the thread that made it, under the
  /// controller's lock: it may only wake somebody. Set before the first work().
  void on_event(std::function<void()> wake);
  /// All events there are with the values that belong to them, of one instant: a value is never on the disk
  /// without the event that tells of it.
  Taken take_events();
  /// @param events how many of the events taken are on the disk now, in total since the controller was made.
  void committed(std::uint64_t events);

  // ---- look-ahead thread
  /// A bounded piece of interpreting and planning. @return false when there is nothing to do for now.
  bool work();

  // ---- real-time thread: no allocation, lock, system call or exception
  void step() noexcept;
  /// The caller's clock found this many periods too late.
  void count_overruns(std::uint64_t periods) noexcept;

  // ---- virtual time only: the thread that calls step()
  /// The period just made.
  const motion::Sample& sample() const noexcept;
  double spindle_rpm() const noexcept;
  /// Turned since the start, not reduced to one turn; with its faults (load) for tests.
  axes::SimulatedSpindle& spindle() noexcept;
  /// Is the segment being traced a cutting one?
  bool cutting() const noexcept;
  /// Block of the segment being traced.
  interp::SourcePosition traced_block() const;
  /// Called on the look-ahead thread with every canonical operation as it is taken up. Set before the first
  /// work().
  void on_operation(std::function<void(const interp::Operation&)> observer);
  /// The same with every move the kernel gets.
  void on_move(std::function<void(const motion::Move&)> observer);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace headstock::operation

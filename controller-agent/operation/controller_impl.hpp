// The controller's inside. One lock guards everything but the real-time part, which has only atomics; the
// look-ahead gives the lock away between pieces of work whenever somebody waits for it.
#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <optional>
#include <vector>

#include "axes/forbidden_zone.hpp"
#include "operation/controller.hpp"
#include "operation/data_edit.hpp"
#include "operation/interruption.hpp"
#include "operation/macro_environment.hpp"
#include "operation/motion_feed.hpp"
#include "operation/overtravel_alarm.hpp"
#include "operation/program_text.hpp"
#include "operation/realtime.hpp"
#include "operation/restart.hpp"

namespace headstock::operation {

/// What the look-ahead waits for before it takes up the next operation.
enum class Await : std::uint8_t {
  nothing,
  function,  ///< M, S, T finished
  dwell,
  tap,           ///< the tap is out again
  polygon,       ///< the tool axis is coupled to the spindle, or let go
  park,          ///< the kernel is to be given the position that a tap ended at
  skip,          ///< G31 over: by its signal or at its end
  block_stop,    ///< single block: the axes stand at the block's end
  program_stop,  ///< M00, M01
  standstill,    ///< a macro looks at the machine
  search,        ///< restart: the program is run through up to its block
  interruption,  ///< M96: the block under way is over, or broken into
  alarm,         ///< motion before the alarm's block is complete
  end,           ///< motion before M30 is complete
  commit         ///< the part count is on the disk
};

enum class Phase : std::uint8_t {
  idle,
  running,   ///< automatic operation, also in feed hold
  stopped,   ///< M00 or single block: waits for cycle start
  faulted,   ///< an alarm stopped the program
  aborting,  ///< reset or emergency stop: the axes are braking
  manual     ///< moving by hand: jog, step, reference return
};

/// What cycle start runs.
struct Selection {
  std::string name, revision_hash;
  std::shared_ptr<program::Programs> memory;
  std::unique_ptr<program::Source> stream;  // drip-feed; taken at cycle start
  bool is_stream = false;
  std::function<std::string()> why_broken;  // of the stream; see input_alarm.hpp
  std::uint64_t bytes = 0;
  bool unseen = false;  // chosen over the network, nobody at the machine has seen it
};

inline CommandResult accepted() {
  return {true, {}};
}
inline CommandResult refused(const char* reason) {
  return {false, reason};
}

/// Takes the lock from the look-ahead thread, which lets go between pieces of work when somebody waits for it.
class Access {
 public:
  Access(std::mutex& mutex, std::atomic<int>& waiting) : guard_(mutex, std::defer_lock) {
    waiting.fetch_add(1, std::memory_order_relaxed);
    guard_.lock();
    waiting.fetch_sub(1, std::memory_order_relaxed);
  }

 private:
  std::unique_lock<std::mutex> guard_;
};

struct Controller::Impl {
  Impl(machine::Machine machine_in, interp::MachineData data_in, ControllerOptions options);

  // ---- controller.cpp: what a person or the link asks for
  CommandResult command(const Command& command);
  CommandResult reset();
  CommandResult emergency_stop();
  CommandResult release_emergency_stop();
  CommandResult set_mode(double value);
  EditResult edit_values(const EditRequest& request);  // data_edit.cpp
  EditResult touch(const TouchRequest& request);       // touch.cpp
  CommandResult set_parameter_write(bool on);          // parameter_switch.cpp
  bool stays_until_switched_off(const ActiveAlarm& alarm) const;
  bool emergency_braking() const { return emergency && phase == Phase::aborting; }
  bool busy() const {
    return phase == Phase::running || phase == Phase::stopped || phase == Phase::aborting ||
           phase == Phase::manual;
  }
  bool alarmed() const;

  // ---- cycle_start.cpp: what begins a program
  CommandResult select(Selection selection, Mode mode, Origin origin);
  CommandResult cycle_start(Origin origin);
  CommandResult start_run(Selection& chosen, const interp::RestartPoint* restart_at = nullptr);
  CommandResult resume();
  bool mirror_place_unknown();
  void go_on();
  double rapid_f0() const;

  // ---- manual.cpp: moving by hand
  CommandResult mdi(std::string text);
  CommandResult jog(std::size_t axis, int direction, JogSpeed speed);
  CommandResult step(std::size_t axis, double distance_mm);
  CommandResult reference(std::size_t axis);
  CommandResult may_move_by_hand(std::size_t axis, Mode needed);
  CommandResult move_plc_axis(std::size_t axis, double target_mm, double feed_mm_min);
  CommandResult tap_retract();
  CommandResult retrace_way(double way_mm);
  double retrace_feed_mm_s() const;
  bool work_retrace();
  void end_retrace();
  void move_by_hand(std::size_t axis, const HandOrder& order);
  void shape_by_hand(std::size_t axis, MotionKind kind, HandOrder& order) const;
  void stop_hands();
  void go_back();
  bool work_manual();
  bool work_return();
  /// The axes of a hand or a ladder have done what they were told.
  bool hands_done(std::uint32_t axes);
  /// What hands have added to where the kernel stands; nothing before the real-time part has taken up a
  /// position that has just been set.
  double hand_offset(std::size_t axis);
  AxisVector standing();
  bool displaced();
  bool held() const;  ///< a program stands in feed hold or at a stop: a hand may intervene
  bool take_over_hands();
  double manual_feed(std::size_t axis) const;
  /// How far the axis may be moved in this direction before a limit or a forbidden zone.
  double reach(std::size_t axis, int direction);  // before_hand.cpp
  bool way_back_is_free();
  double hand_position(std::size_t axis);

  // ---- sequencer.cpp: from operations to moves and interludes
  bool work();
  void pull_operations();
  void take(const interp::Operation& taken);
  void post(Await what, Interlude interlude);
  void interlude_done();
  void count_due_part();
  void data_ran_out();
  void end_program();
  void finish_run(const char* outcome);
  void after_abort();
  void stop_with(const MachineAlarm& alarm, const interp::SourcePosition& at, std::string detail);
  std::optional<MachineAlarm> before_motion(const interp::Operation& taken);
  std::optional<MachineAlarm> before_tap(const interp::Tap& tap);
  void take_tap(const interp::Tap& tap);
  /// Stored stroke checks 2 and 3, as far as they are on.
  std::vector<axes::Zone> zones() const;
  bool has_third_zone() const;
  std::optional<MachineAlarm> forbidden(const AxisVector& from,
                                        const std::variant<motion::Line, motion::Arc>& geometry) const;
  void take_polygon(const interp::PolygonTurning& polygon);
  void tap_done();
  void park();
  bool work_park();
  void drop_park();
  void machine_fault(const axes::Fault& fault);
  void skip_over();
  MachineAlarm broken_input() const;

  // ---- restart.cpp: a program taken up in its middle
  CommandResult restart(std::optional<interp::RestartPoint> point);
  CommandResult may_go_to_restart();  ///< M, S, T are as the program needs them there
  void search_restart();
  void restart_found();
  bool next_approach();
  void mark_breakpoint();  ///< while a run is open
  interp::SourcePosition block_under_way();
  std::uint32_t first_block_left();

  // ---- interruption.cpp: M96
  bool wait_for_interruption();
  void work_interruption();
  void break_in();
  void run_interruption_in_block();

  // ---- report.cpp: alarms, events, live
  void raise(const std::string& code, const std::string& detail, const interp::SourcePosition& at,
             const MachineAlarm& own_text, bool is_message = false);
  void clear_alarms(bool messages_only);
  void emit(Event event);
  void state_changed();
  State state() const;
  Live live();
  std::string block_text(const interp::SourcePosition& at) const;

  const machine::Machine machine;
  interp::MachineData data;
  std::function<std::int64_t()> now_ms;
  motion::Kernel kernel;
  TagRing tags;
  Realtime realtime;
  WindowedPrograms programs;
  MacroEnvironment macro_environment;
  interp::Interpreter interpreter;
  MotionFeed feed;
  Retrace retrace;
  std::function<void(const interp::Operation&)> observer;
  std::function<void()> wake_storage;

  std::mutex lock;
  std::atomic<int> waiting{0};  // threads that want the lock from the look-ahead

  Mode mode = Mode::memory;
  Phase phase = Phase::idle;
  bool emergency = false;
  bool armed = false;
  Mode run_mode = Mode::memory;     // of the program that a hand intervenes in
  bool parking = false;             // by hand: the kernel is being given the new position
  std::uint64_t retrace_since = 0;  // period in which the way was given
  bool retracing = false;           // the axes move along what was traced
  bool returning = false;           // to where a hand has taken the axes from
  bool manual_absolute = true;
  bool mirror_unseen = false;  // the mirror setting was on when this agent began: where it stands is not known
  bool tripped = false;     // a fault has switched the drives off …
  bool trip_reset = false;  // … RESET switches them on, once the measured position is taken over
  bool releasing = false;   // the emergency stop, once the measured position is taken over
  std::uint32_t faults_seen = 0;
  std::uint64_t set_since = 0;      // period in which the kernel got its position last
  bool resume_with_go = false;      // the program stands at a stop, not in feed hold
  AxisVector hand_goal{};           // where hands have sent the axes
  std::uint32_t hand_moving = 0;    // axes that a hand has sent somewhere; bit: axis
  std::uint32_t hand_stopped = 0;   // axes that were let go and may still be moving
  const std::uint32_t plc_axes;     // bit: axis
  bool unlocked = false;            // machine lock has just been taken off
  std::uint32_t unlocked_axes = 0;  // the same for single axes
  interp::Switches switches;
  bool single_block = false, optional_stop = false, block_skip = false, dry_run = false;
  Selection selection;
  Selection mdi_block;  // typed in MDI mode
  const bool skip_input;
  std::optional<axes::Zone> zone;  // stored stroke check 2, when on
  axes::TapOrder last_tap;
  MacroInterruption interruption;
  Restart restarting;
  bool polygon_on = false, polygon_let_go = false;
  Retained retained;
  std::vector<ActiveAlarm> alarms;
  bool parameter_write = false;  // the switch of parameter_switch.cpp
  std::string message;

  // the run under way
  bool run_open = false;
  RunRecord run_record;
  std::string run_by;  // of the next or the present run
  std::string shapes_said;  // what of the acceleration modes is not done, when it was last said
  Await await = Await::nothing;
  interp::Operation operation;  // pulled, not yet taken up
  bool has_operation = false;
  int parts_due = 0;  // 1 a part, -1 the count to 0, when the M code that waits is done
  bool new_block = false;             // the operation taken up begins a block
  bool calculating = false;           // a macro goes on with its calculation as soon as others had the lock
  interp::SourcePosition last_block;  // of the last operation taken up; line 0: none
  std::uint32_t done_block = 0;       // of the last function of this run that is done
  std::uint64_t tag_before_run = 0;   // newest tag when this run began
  std::uint32_t reset_block = 0;      // what the next RESET takes back begins here; 0: nothing
  std::shared_ptr<TextWindow> main_window;
  std::uint32_t main_program = 0;
  std::uint64_t main_offset = 0;
  std::optional<axes::Overtravel> overtravel;
  interp::Alarm pending_alarm;
  MachineAlarm raised_here;  // texts for it when it does not come from the interpreter
  interp::End end;
  bool anything_moved = false;          // in this run, or since data last came
  std::uint64_t wait_since_period = 0;  // first period without data, 0: data are there
  bool brought_to_end = false;          // without data: the last block received has been planned to its end
  bool planned = true;                  // the kernel has planned everything pushed
  std::uint64_t commit_event = 0;       // number of the part's event that must be committed
  std::uint64_t run_periods_base = 0, cutting_periods_base = 0;
  std::uint64_t life_periods = 0;  // cutting periods that tool life has been told of
  double last_cycle_s = 0;
  double total_run_base_s = 0;

  // events on their way to the storage thread; the two counters run since the controller was made
  std::deque<TimedEvent> events;
  std::uint64_t events_made = 0, events_committed = 0;
  State last_state = State::idle;
  Mode last_mode = Mode::memory;

  double period_s() const { return machine.period_us * 1e-6; }
};

}  // namespace headstock::operation

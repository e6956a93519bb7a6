// The inside of one path's interpreter: its state and the steps that handlers of G codes share. Included by
// the handlers (interpreter/, dialects/, later cycles/ and compensation/), not by users of the interpreter.
//
// A block is carried out in a fixed order: planes, units, modes (Phase::setting) → F and S → T → M codes that
// start with the motion → the action or the motion → M codes after it → stop, end, call or return. Operations
// go straight into the caller's `Operation`, further ones of the same block into a queue.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "dialects/dialect.hpp"
#include "interpreter/canonical.hpp"
#include "interpreter/cycle_state.hpp"
#include "interpreter/data_input.hpp"
#include "interpreter/interpreter.hpp"
#include "interpreter/interruption.hpp"
#include "interpreter/look_ahead.hpp"
#include "interpreter/machine_data.hpp"
#include "interpreter/macro_state.hpp"
#include "interpreter/mirror_setting.hpp"
#include "interpreter/modal_memory.hpp"
#include "interpreter/normal_direction.hpp"
#include "interpreter/own_language.hpp"
#include "interpreter/pipeline.hpp"
#include "interpreter/polar_command.hpp"
#include "interpreter/restart.hpp"
#include "interpreter/skip.hpp"
#include "interpreter/surface.hpp"
#include "interpreter/tool_life.hpp"
#include "interpreter/tool_offset.hpp"
#include "interpreter/transform.hpp"
#include "machine/machine.hpp"
#include "macro/environment.hpp"
#include "program/block.hpp"
#include "program/block_reader.hpp"
#include "program/lexer.hpp"

namespace headstock::interp {

using dialects::AlarmReason;
using dialects::Dialect;
using dialects::GCode;
using dialects::Phase;
using machine::kMaxAxes;
using program::letter_bit;

/// An axis as programs see it.
struct ProgramAxis {
  char name = 'X';
  bool rotary = false;
  double diameter = 1;  ///< programmed value × diameter = slide value: 0.5 on a diameter axis
  double page_diameter =
      0;  ///< the same for the offset pages where a program changed `diameter`; 0: as `diameter`
  double mm_per_unit = 1;  ///< programming unit × diameter → slide mm (changes with G20/G21)
  std::int64_t increment =
      program::kNano / 1000;  ///< least input increment in nano units (changes with G20/G21)
  std::int64_t position = 0;  ///< programmed position in the active work system, nano units, exact
  // parts of the zero point, slide mm; their sum is ModalSnapshot::work_zero
  double zero_external = 0, zero_work = 0, zero_shift = 0, zero_local = 0, zero_tool = 0;
  double intermediate = 0;  ///< machine coordinate of the last G28/G30 intermediate point
  bool has_intermediate = false;
  double start_point = 0;  ///< machine coordinate of the last coordinate setting (start point of 200T)
  bool has_start_point = false;
  bool rolls_over = false;  ///< rotary: absolute positions count within one turn; `position` itself runs on
  bool as_written =
      false;  ///< …: an absolute command counts from the place within the turn, any number of turns
  bool centered = false;  ///< …: the page shows −180 … 180
  bool by_sign = false;  ///< …: the sign of an absolute command is the direction; otherwise the shorter way
  std::int64_t turn = 0;                           ///< one turn, nano degrees
  std::int64_t word_unit = program::kNano / 1000;  ///< what 1 without a decimal point is
  bool on_circle = false;                          ///< rotary: F counts on an imaginary circle …
  double circle_mm = 0;  ///< … of this radius; 0: the axis does not count (0i-D 5.5)
};

/// A program on the call stack.
struct Frame {
  std::unique_ptr<program::BlockReader> reader;
  program::Line line;                 ///< being carried out
  const char* rest = nullptr;         ///< of the line: where its next block starts; nullptr: read a new line
  std::uint32_t number = 0;           ///< O number
  std::int64_t repeats_left = 0;      ///< further runs of a sub-program
  bool at_start = true;               ///< nothing but tape marks and the O word so far
  std::int64_t wanted_sequence = -1;  ///< searching this N; -1: not searching
  SourcePosition wanted_by;           ///< of the jump, for the alarm
  AlarmReason not_found = AlarmReason::sequence_not_found;
  MacroFrame macro;
  std::string wanted_name;  ///< label of the jump where labels are not numbers
};

struct Executor {
  Executor(const Dialect& dialect, const machine::Machine& machine, MachineData& data,
           program::Programs* programs);

  // ---- what Interpreter offers (executor.cpp)
  void set_switches(const Switches& wanted);
  /// @param keep bit n: group n stays as it is
  void power_on(std::uint32_t keep = 0);
  void clear_modes();  // clear_state.cpp: what RESET does to modes and coordinates
  void start(std::unique_ptr<program::Source> main, const AxisVector& machine_position);
  Pull next(Operation& out);
  // restart.cpp
  Pull restart(std::unique_ptr<program::Source> main, const AxisVector& machine_position,
               const RestartPoint& point);
  Pull run_through();
  bool restart_reached(bool has_sequence, std::uint32_t sequence, bool counted);
  Pull search();
  void leave_search();
  void keep_data_of_broken_run();
  void keep_variable(std::uint32_t number);
  void sample(const Operation& passed);
  void reset(const AxisVector& machine_position, std::uint32_t first_block_left);
  void set_position(const AxisVector& machine_position);
  void cancel_compensation();
  AxisVector to_work(const AxisVector& machine_position, const ModalSnapshot& under) const;
  void skip_ended(const AxisVector& machine_position, bool triggered);  // skip.cpp
  Pull next_on_machine(Operation& out);     // surface.cpp: next(), in the machine's axes
  const ModalSnapshot& modal_on_machine();  // surface.cpp

  // ---- reading (flow.cpp)
  enum class Step : std::uint8_t { done, wait, standstill };
  Step step();
  Step read_block();
  Step search_block();
  /// A reader a program left behind, or a new one: calls in a loop allocate nothing.
  std::unique_ptr<program::BlockReader> take_reader(std::unique_ptr<program::Source> source);
  /// Of a program on the stack; opened when it is first needed. nullptr after an alarm.
  program::BlockReader* reader_of(Frame& frame);
  /// Before anybody reads on by himself: the reader stands behind the block being carried out.
  bool settle_reader();
  /// After he went elsewhere: what would have been carried out next is forgotten.
  void leave_chain();
  void run_block(bool empty, bool has_sequence, std::uint32_t sequence);
  Frame& push_program(std::unique_ptr<program::Source> source, std::uint32_t number, std::int64_t times);
  void drop_program();
  bool begin_again(Frame& frame);
  bool begin_search(std::int64_t sequence, std::uint32_t column, AlarmReason not_found);
  bool end_of_text(bool record_end);
  bool jump_to_sequence(std::int64_t sequence, std::uint32_t column);
  bool call(std::unique_ptr<program::Source> source, std::uint32_t number, std::int64_t times,
            std::uint32_t column);
  bool return_from_sub(std::int64_t to_sequence, std::uint32_t column);
  bool rewind_main();
  bool count_jump();
  bool finish(EndReason reason, bool counts_part);

  // ---- macros (macro_flow.cpp: statements, jumps; macro_call.cpp; macro_words.cpp)
  Step carry_out(CompiledBlock& compiled);
  CompiledBlock* keep_block(const program::LexResult& read, const BlockPlace& place);
  void go_on_after(const CompiledBlock& compiled);
  void go_on_at(const BlockPlace& place);
  macro::Result run_statement(CompiledBlock& compiled);
  bool stops_at_statements() const;
  macro::Result assign(const macro::Statement& statement);
  macro::Result go_to_sequence(CompiledBlock& compiled);
  macro::Result begin_loop(CompiledBlock& compiled);
  macro::Result end_loop(CompiledBlock& compiled);
  macro::Result find_loop_end(CompiledBlock& compiled);
  macro::Result print_statement(const macro::Statement& statement);
  macro::Result set_names(const macro::Statement& statement);
  macro::Result fill_computed(const CompiledBlock& compiled);
  void leave_loops_around(std::uint64_t offset);
  bool macro_alarm(double number);
  /// Looks for calls in the block. `taken`: the block was one and is done with.
  bool take_calls(bool& taken);
  bool call_macro(std::uint32_t program, std::uint32_t column, bool modal);
  bool call_modal();
  bool cancel_modal(std::uint32_t column);
  bool call_external(std::uint32_t column);
  bool run_pending_call();
  bool gather_arguments(std::uint32_t column, std::int32_t call_m, macro::LocalSet& locals);
  int argument_decimals(char letter) const;
  bool nesting_allows(CallKind kind, std::uint32_t column);
  void read_macro_parameters();
  void remember_modal_values();
  ModalValues modal_values() const;
  // interruption.cpp
  bool interrupt(const AxisVector& machine_position, bool inside_block);
  void end_interruption(const InterruptedState& before, bool keep_modal);
  bool allow_interruption(const program::Code& written, bool on);
  bool interrupting() const;  ///< an interruption program is on the stack
  void read_look_ahead_parameters();  // look_ahead.cpp
  void remember_sequence(std::uint32_t sequence, const BlockPlace& place) {
    if (frames.back().macro.passed != nullptr) frames.back().macro.passed->pass(sequence, place);
  }
  // data_input.cpp
  bool inputs_data() const;       ///< the block just read is a G10, or data of one
  bool data_input_waits() const;  ///< … that must wait until everything handed out has been carried out
  void take_back_data_input(std::uint32_t first_block_left);
  void keep_data_input(std::uint32_t first_block_left);  ///< what blocks before this one wrote stays
  /// Everything handed out must have been carried out before what follows is read (G31, M00, unbuffered M).
  void hold_look_ahead() { barrier = true; }
  void flush_changes();
  void load_variables();
  void leave_program();
  void reset_variables();

  // ---- one block (block.cpp)
  bool execute();
  bool execute_words();
  bool check_words();
  bool is_h_block() const;
  bool take_codes();
  bool run_settings();
  bool length_in_block() const;  ///< G43, G44 or G49
  bool rigid_tap_follows();
  bool calls_fit_cycle();
  bool run_m_codes(bool after_motion);
  bool run_program_flow();

  // ---- values
  /// Length, angle or seconds in nano units of the programming unit: decimal-point rule, rounding, digits
  /// checked later.
  std::int64_t nano(const program::Word& word, std::int64_t increment) const {
    if (word.point || pocket) return word.nano();
    return word.digits * increment;
  }
  /// A length word that belongs to no axis (R, I, K …) in mm, radius.
  double length_mm(const program::Word& word) const {
    return static_cast<double>(round_to(nano(word, linear_increment), linear_increment)) / 1e9 * unit_mm;
  }
  std::int64_t round_to(std::int64_t value, std::int64_t increment) const;
  double feed_value(const program::Word& word) const;
  /// An axis word in nano units of the programming unit.
  std::int64_t axis_value(const program::Word& word, const ProgramAxis& axis) const {
    return word.point || pocket ? word.nano() : word.digits * axis.word_unit;
  }
  /// A word that must be a whole number ≥ 0. @return -1 after raising an alarm.
  std::int64_t whole(char letter, AlarmReason otherwise);

  // ---- axes (motion.cpp)
  void set_units(bool inch_now);
  void update_zero(std::size_t axis);
  void update_zeros();
  double to_machine(std::size_t axis, std::int64_t position) const;
  void set_axis_machine(std::size_t axis, double machine_position);
  double shown(std::size_t axis) const;  ///< absolute position page, programming units
  double page_to_slide(std::size_t axis, double page_mm) const {
    const ProgramAxis& a = axes[axis];
    return page_mm * (a.page_diameter != 0 ? a.page_diameter : a.diameter);
  }
  /// Takes the block's axis words as targets into `axes[].position`. @return false after an alarm; `moved`
  /// gets the axes.
  bool take_targets(std::uint32_t& moved);
  bool transformed_in_range(std::uint32_t moved);
  bool settle_both_forms(std::uint32_t mask);
  std::optional<std::size_t> axis_named(char name) const;
  double slide_mm(std::size_t axis) const { return work_now[axis] * axes[axis].mm_per_unit; }
  /// Moves the machine position to `axes[].position` and fills what all moves have in common.
  void fill_motion(Motion& motion, std::uint32_t moved);
  bool emit_rapid_to_machine(const AxisVector& target, std::uint32_t moved, bool machine_coordinates,
                             bool overlap = false);
  bool rapid();
  bool feed();
  bool cutting_feed(double path_mm, double& value, FeedUnit& unit);
  bool arc(Turn turn);
  bool only_helix_axes(std::uint32_t moved, std::size_t first, std::size_t second);
  /// Where the block's targets lie, slide mm relative to the work zero point: positions, mirrored, scaled,
  /// rotated.
  AxisVector targets_mm() const;
  /// Length of the straight way there [mm, degrees as mm].
  double path_to_targets(const AxisVector& from_machine, std::uint32_t moved) const;
  static std::int64_t rolled(const ProgramAxis& axis, std::int64_t wanted);
  double within_turn(std::size_t axis, double work) const;
  /// Factor on F for moves with rotary axes that count on an imaginary circle; 0: no axis counts (0i-D 5.5).
  double imaginary_circle(const AxisVector& from, const AxisVector& to, std::uint32_t moved) const;
  bool axes_at_once(std::uint32_t moved);
  /// After `transform` changed: written positions follow from where the axes stand.
  void follow_transform();
  void take_mirror_setting();
  void keep_mirror_place(std::size_t axis);
  // ---- G07.1 and G12.1 (surface.cpp)
  void enter_surface(const Surface& wanted, double unit_in_mm);
  void leave_surface();
  /// A machine position in the coordinates of the mode; the mode goes on from there. Without a mode: itself.
  AxisVector place_in_plane(const AxisVector& machine_position);
  /// Whether the block may stand in the mode. @return false after an alarm.
  bool surface_allows();
  bool compensation_is_off() const {
    const auto& rules = dialect.modes;
    return rules.compensation_group == 0 || modal.g[rules.compensation_group] == rules.compensation_off;
  }

  /// Radius and angle words under G16 (polar_command.cpp). Takes its letters out of `mask`.
  bool take_polar(std::uint32_t& mask, std::uint32_t& moved);
  std::uint16_t assigned_skip_signals(std::int64_t number) const;  // skip.cpp

  // ---- planes and parameters (plane.cpp)
  /// The axes of the plane in force, first and second; -1 where the machine has none.
  struct PlaneIndex {
    int first = -1, second = -1;
  };
  PlaneIndex plane_axes() const { return plane_index; }
  void select_plane(Plane wanted);
  bool one_axis_a_role();
  /// What an axis is in the basic system: 1 2 3 X Y Z, 5 6 7 parallel to them, 0 neither.
  int role_of(std::size_t axis) const;
  /// Parameters that change the language take effect: at the start of a program and after G10 L52.
  void take_parameters();
  /// Least increments in a second (or revolution) of dwell.
  double dwell_units_a_second() const;

  bool thread(bool variable);
  bool thread_runout(const Thread& whole_thread, const AxisVector& from);

  // ---- words with a meaning of their own (feed_spindle.cpp, tool.cpp)
  bool take_feed();
  bool take_one_digit_feed(int digit);
  bool take_spindle();
  bool spindle_by_p() const;  ///< P beside S names the spindle
  bool spindle_fits(bool needs_p);
  bool take_tool();
  int offset_digits() const;          ///< of the T word
  std::int64_t offset_split() const;  ///< the offset number is the T word modulo this
  void emit_spindle();
  double highest_rpm() const;  // spindle.cpp
  std::uint8_t gear_of(double speed) const;
  bool digits_fit(const program::Word& word, std::string_view parameter, std::string detail);
  char second_auxiliary() const;
  char auxiliary_address() const;  ///< its letter, whether or not the function is there; 0: an axis has it
  bool take_second_auxiliary(char letter);

  // ---- chamfers, corner rounds, angles (corner_words.cpp)
  /// Reads the block's words for its corner and takes them out of `block.words`. @return false after an
  /// alarm.
  bool take_corner_words();
  /// After take_targets: the end point that the block's angle gives.
  bool take_angle(std::uint32_t& moved);
  bool take_d();
  /// Whether the block is a line with an angle.
  bool drawing_block() const {
    return block.marked != 0 && block.has_marked('A') && action == nullptr && motion_code->tenths == 10;
  }
  bool drawing_allows_codes();  ///< in the blocks of an angle: no other plane, unit, mirror, polar mode
  bool take_perpendicular(CornerRequest& request);
  void take_vector_words();              // compensation_codes.cpp
  comp::Point direction_words() const;   // …: I J K of the plane in force, slide mm
  bool open_line();
  double angle_deg(const program::Word& word) const;

  // ---- results
  template <typename T>
  T& emit() {
    if constexpr (std::is_base_of_v<Motion, T> || std::is_same_v<T, Dwell> || std::is_same_v<T, MCode> ||
                  std::is_same_v<T, Stop>) {
      jumps = idle_jumps = 0;
    }
    if constexpr (std::is_base_of_v<Motion, T>) ++motions;
    if constexpr (!std::is_same_v<T, Message> && !std::is_same_v<T, Alarm>) {
      at_standstill = false;
      interruption.acted = true;
    }
    if (!out_used) {
      out_used = true;
      return out->emplace<T>();
    }
    return std::get<T>(queue.emplace_back(std::in_place_type<T>));
  }
  /// Raises the controller's alarm; the program is over. Always returns false.
  bool alarm(AlarmReason reason, std::uint32_t column, std::string detail = {});
  bool alarm(AlarmReason reason, const program::Code& code, char letter);
  /// The same with the number itself: for subjects that keep their numbers in tables of their own.
  bool alarm_code(std::string_view number, std::uint32_t column, std::string detail);
  /// M codes and the end of a block whose cycle is over.
  bool run_deferred();
  void report_change(std::string what, double before, double after);

  // ---- fixed
  const Dialect& dialect;
  machine::Machine machine;
  MachineData& data;
  program::Programs* programs;
  DataChanged changed;
  std::unique_ptr<OwnLanguage> own;  ///< of the dialect; most have none
  macro::Environment offline;        ///< in force when nobody gives another one
  macro::Environment* environment = &offline;
  std::uint32_t steps = 0;  ///< until the environment is asked again

  // ---- settings
  Switches switches;
  const dialects::GTable* table = nullptr;
  program::LexRules lex_rules;
  bool pocket = false;
  std::uint32_t axis_like = 0;  ///< letters that name an axis or its increment on some machine
  std::uint32_t absolute_letters = 0, incremental_letters = 0, axis_letters = 0;
  std::array<std::int8_t, 26> axis_of{};  ///< axis index of a letter, -1: none
  std::uint32_t legal = 0, may_point = 0, may_minus = 0;

  // ---- modal state
  std::vector<ProgramAxis> axes;
  AxisVector machine_now{};  ///< slide positions [mm, degrees]
  AxisVector work_now{};     ///< what the absolute page shows, programming units
  ModalSnapshot modal;
  const GCode* motion_code = nullptr;  ///< group 01
  bool incremental = false;            ///< G91
  bool exact_stop_mode = false;        ///< G61
  bool linear_rapid = false;           ///< LRP: G00 on a straight line
  bool constant_surface_speed = false;
  FeedUnit feed_unit = FeedUnit::mm_per_minute;
  bool work_is_extra = false;  ///< G54.1
  std::size_t work_index = 0;  ///< of G54…G59, or of G54.1 P
  Plane plane = Plane::xy;
  PlaneIndex plane_index;
  bool roles_given = false;                         ///< G54.9: `given_roles` says which axes are Xp, Yp, Zp
  std::array<std::int8_t, kMaxAxes> given_roles{};  ///< 1 2 3; 0: none of them
  CuttingMode cutting_mode = CuttingMode::cutting;  ///< G61…G64
  Transform transform;
  MirrorSetting mirror_setting;
  PolarCommand polar;
  SkipState skip;
  DataInputMode data_input;
  std::vector<DataInputAhead> data_input_ahead;
  Interruption interruption;
  LookAhead look_ahead;
  std::int32_t part_count_m = -1;  ///< Dialect::part_count_m_parameter; -1: none
  std::int32_t rigid_m = -1;       ///< Dialect::rigid_m_parameter
  std::int32_t small_hole_m = -1;  ///< Dialect::small_hole_m_parameter, where the machine has it
  SurfaceMode surface;
  SurfacePath surface_path;
  ModalSnapshot shown_modal;  ///< see modal_on_machine
  bool any_rolls_over = false, any_on_circle = false;
  double inch_setting = -1;  ///< value of ModeRules::inch_parameter that has been taken up; -1: none
  bool polygon = false;     ///< G51.2
  char gcode_system = 'A';  ///< in force: the switch, or the parameter
  struct Codes {
    std::int16_t first = 0, last = 0;
  };
  std::vector<Codes> absent_codes;  ///< G codes [tenths] of functions that parameters say the control has not
  char auxiliary_letter = 0;        ///< of the second auxiliary function; 0: none
  bool one_digit_feed = false;      ///< F1…F9 are digits
  ToolLife life;
  ToolOffsetState tool_offset;
  bool one_digit_rapid = false;  ///< F0 of one-digit feed: cutting moves run at the rapid rate
  AxisVector increment_limit{};  ///< G91.1, programming units; 0: none
  double unit_mm = 1;            ///< mm of a programming unit
  std::int64_t linear_increment = program::kNano / 1000;
  double feed_mm = -1;  ///< mm/min or mm/rev; < 0: never commanded
  double lead_mm = 0;   ///< last thread lead; 0: none
  double rpm = 0, surface_speed = 0, clamp_rpm = 0;
  int surface_axis = -1;  ///< G96 P: axis index; -1: X
  SpindleDirection spindle_direction = SpindleDirection::stop;
  int length_sign = 0;             ///< G43: +1, G44: -1, G49: 0
  std::int64_t length_offset = 0;  ///< H number in force

  CycleState cycle;

  // ---- the block being carried out
  program::Block block;
  SourcePosition at;
  const GCode* code = nullptr;  ///< whose handler runs
  std::uint32_t code_column = 0;
  const GCode* action = nullptr;
  std::uint32_t action_column = 0;
  std::array<const GCode*, program::kMostCodes> settings{};
  std::array<std::uint32_t, program::kMostCodes> setting_columns{};
  std::size_t setting_count = 0;
  bool exact_stop_once = false;
  bool spindle_changed = false;
  std::uint32_t pending_axes = 0;  ///< axes that move because their offset changed (G43 H)

  // ---- macros
  std::unique_ptr<MacroState> macros;  ///< nullptr: the dialect has no variables
  const CodeCall* sub_call = nullptr;  ///< sub-program the block calls when it is done
  CodeCall word_call{};                ///< of a T word, another address or M198
  std::uint32_t sub_call_column = 0;
  std::uint64_t motions = 0;         ///< emitted so far
  std::uint64_t motions_before = 0;  ///< before this block
  bool at_standstill = true;         ///< nothing was handed out since everything was carried out
  bool awaits_standstill = false;    ///< told the caller so
  bool barrier = false;
  RestartRun restart_run;
  bool restarting = false;  ///< running through to where a restart begins
  bool move_calls = false;  ///< G66 was in force when this block began
  std::vector<std::unique_ptr<program::BlockReader>> spare_readers;

  // ---- the program
  std::vector<Frame> frames;
  std::uint64_t jumps = 0;       ///< since the last motion
  std::uint64_t idle_jumps = 0;  ///< since the last motion or assignment
  bool finished = true;

  NormalDirection normal_direction;  ///< G41.1/G42.1
  ModalMemory modal_memory;          ///< what RESET goes back to
  // ---- chamfers, corner rounds, G41/G42
  Pipeline pipeline;
  std::array<std::int64_t, 2>
      angle_from{};  ///< programmed position of the plane's axes before an angle block

  // ---- results of the block
  Operation* out = nullptr;
  bool out_used = false;
  std::vector<Operation> queue;
  std::size_t queue_head = 0;
};

}  // namespace headstock::interp

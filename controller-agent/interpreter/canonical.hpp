// Canonical operations: what a program means once the language is gone. The interpreter produces them in
// order, the motion side carries them out, the offline tools print them. Plain values, no allocation except
// in the rare texts.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>

#include "machine/axes.hpp"

namespace headstock::interp {

using machine::AxisVector;

/// Where in the source an operation comes from.
struct SourcePosition {
  std::uint32_t program = 0;      ///< O number; 0 when the program has none (200T names: see ProgramNames)
  std::uint32_t line = 0;         ///< 1-based line of that program's source
  std::uint32_t column = 0;       ///< 1-based column (bytes); 0 when the whole block is meant
  std::uint32_t sequence = 0;     ///< last N number passed
  std::uint32_t block = 0;        ///< blocks begun in this run, macro statements not counted: 1 is the first
  std::uint64_t byte_offset = 0;  ///< of the block's first byte, for resuming a drip-feed
  std::uint32_t part = 0;  ///< of the block: single block stops between two parts (traverses of a cycle)
};

inline constexpr std::size_t kModalGroups = 32;

/// The modal state in force when an operation was made; it rides on every segment so that what is shown is
/// what moves.
struct ModalSnapshot {
  /// Active code of each modal group, times ten (G54.1 → 541), -1 where the group has none. Index: the
  /// dialect's group.
  std::array<std::int16_t, kModalGroups> g{};
  std::int32_t tool = 0;     ///< tool number as programmed
  std::int32_t offset = 0;   ///< offset number in force
  double feed = 0;           ///< F as programmed, in the unit of the feed group
  std::uint32_t macro_control = 0;  ///< #3003, and #3004 from bit 4 on: what the operator's keys may not do
  double spindle_speed = 0;  ///< S as programmed: rpm, or m/min (ft/min) under constant surface speed
  AxisVector
      work_zero{};    ///< machine coordinate of the active workpiece zero incl. tool offset [mm], radius on X
  bool inch = false;  ///< G20: programming units are inches
  bool per_revolution = false;  ///< the feed group says feed per revolution
};

enum class Plane : std::uint8_t { xy, zx, yz };
enum class Turn : std::uint8_t { cw, ccw };
enum class FeedUnit : std::uint8_t { mm_per_minute, mm_per_revolution, inverse_time };

/// What G61…G64 say about the joints of cutting moves.
enum class CuttingMode : std::uint8_t {
  cutting,          ///< G64
  exact_stop,       ///< G61
  corner_override,  ///< G62: slower in inner corners under cutter compensation
  tapping           ///< G63: no deceleration at joints; feed override is 100 % and feed hold waits
};

/// What all moves have in common.
struct Motion {
  SourcePosition at;
  ModalSnapshot modal;
  AxisVector end_work{};  ///< end as the absolute position page shows it: programming units, X as a diameter
                          ///< where so
  AxisVector end_machine{};     ///< end in machine coordinates [mm, degrees], slide position
  std::uint32_t axes = 0;       ///< bit i: axis i was programmed or moves
  const char* cycle = nullptr;  ///< "G71" when a canned cycle made the move; static storage
  bool exact_stop = false;      ///< G09/G61: decelerate to zero and check in-position at the end
  CuttingMode cutting_mode = CuttingMode::cutting;
  bool in_plane = false;  ///< inside the interpreter only: coordinates of G07.1/G12.1, see surface.hpp
};

/// Bits of `Feed::skip_signals` and `Dwell::skip_signals`: SKIP, SKIP2 … SKIP8, then the torque limit.
inline constexpr std::uint16_t kSkipTorque = 1u << 8;
/// … and an input port named by number (`Feed::skip_input`).
inline constexpr std::uint16_t kSkipInput = 1u << 9;

/// G00: every axis at its own rapid rate, on a straight line or not as the controller's parameter says.
struct Rapid : Motion {
  bool linear = false;  ///< interpolated rapid (LRP): all axes arrive together on a straight line
  bool machine_coordinates = false;  ///< G53, G28 and the like
  bool overlap = false;              ///< G53 P1: the next rapid may begin before this one stands still
  /// Away from a thread: the share of the acceleration that the parameters give such a move (K2000TC G76, G92 J/K), > 0.
  double retreat_ratio = 1;
};

/// G01.
struct Feed : Motion {
  double feed = 0;  ///< mm/min, mm/rev, or 1/min by `unit`; already metric
  FeedUnit unit = FeedUnit::mm_per_minute;
  /// G31: any of these signals ends the move where the axes are. Whoever carries it out lets the move end,
  /// tells the interpreter by `skip_ended` where and why, and only then asks for the next operation. 0: no
  /// skip.
  std::uint16_t skip_signals = 0;
  std::int16_t skip_input = 0;    ///< with kSkipInput: the port (200T G31 L, K)
  bool skip_level = true;         ///< its level that ends the move; true: active
  bool skip_overridable = false;  ///< override, dry run and acceleration apply to a skip move (0i-D SKF)
};

/// G02/G03, helix and spiral.
struct Arc : Motion {
  double feed = 0;
  FeedUnit unit = FeedUnit::mm_per_minute;
  Plane plane = Plane::xy;
  Turn turn = Turn::cw;  ///< as seen in the plane (first axis → second axis), not as the post is mounted
  /// Axes of the plane where they are not X Y Z (parallel axes); kByPlane: those that `plane` names.
  std::uint8_t axis_1 = kByPlane, axis_2 = kByPlane;
  static constexpr std::uint8_t kByPlane = 0xff;
  bool feed_on_arc = false;  ///< helix: `feed` counts along the arc without the linear axes (0i-D HTG=0)
  AxisVector
      center_work{};  ///< programming units, X as a diameter where so; only the plane's axes are meaningful
  AxisVector center_machine{};  ///< mm
  double radius_mm = 0;         ///< at the start point
  double turns = 0;             ///< angle swept / 360°, > 0
};

/// G32/G33 family: feed synchronised with the spindle's phase.
struct Thread : Motion {
  double lead_mm = 0;          ///< along the long axis
  double lead_change_mm = 0;   ///< per revolution (G34)
  double start_angle_deg = 0;  ///< Q
  /// A chord of an arc that leads onto or off a thread: the arc's length, in which the tool comes to its speed. 0: a
  /// thread by itself, which must be long enough for it.
  double run_up_mm = 0;
};

/// G04.
struct Dwell {
  SourcePosition at;
  ModalSnapshot modal;
  double seconds = 0;
  double revolutions = 0;
  std::uint16_t skip_signals = 0;  ///< G04 Q: any of these ends it early
};

enum class SpindleDirection : std::uint8_t { stop, cw, ccw };

/// M03/M04/M05, S and G96/G97/G50 S (G92 S): the state the spindle shall have.
struct Spindle {
  SourcePosition at;
  SpindleDirection direction = SpindleDirection::stop;
  double speed = 0;  ///< rpm, or surface speed in m/min
  bool constant_surface_speed = false;
  double clamp_rpm = 0;                   ///< 0: none
  std::uint8_t surface_axis = kSurfaceX;  ///< index of the axis whose work coordinate is the radius under G96
  static constexpr std::uint8_t kSurfaceX = 0xff;  ///< the X axis
  std::uint8_t gear =
      0;  ///< selected by the control from S (M-type gear shift): 1…4; 0: the machine's affair
};

/// G08 P, G05.1 Q: look-ahead ("AI contour") control on or off.
struct ContourMode {
  SourcePosition at;
  bool on = false;
  std::int32_t level = 0;     ///< R: 1 fast … 10 precise; 0: not given
  double reference_feed = 0;  ///< F: feed the bell-shaped acceleration is tuned to [mm/min]; 0: not given
};

/// G22/G23: stored stroke check 2 on or off. The corners are in the parameters too.
struct StrokeCheck {
  SourcePosition at;
  bool on = false;
  bool outside_forbidden = false;
  std::uint32_t axes = 0;      ///< axes that have limits
  AxisVector most{}, least{};  ///< slide positions in machine coordinates [mm, degrees]
};

/// G25/G26: supervision of the spindle's speed.
struct SpindleWatch {
  SourcePosition at;
  bool on = false;
  double delay_s = 0;        ///< P: from a new S until the check begins at the latest
  double reached_ratio = 0;  ///< Q: tolerance of "speed reached", 0.15 = 15 %
  double ratio = 0;          ///< R: allowed fluctuation
  double width_rpm = 0;      ///< I: allowed fluctuation; the wider one counts
};

/// G51.2/G50.2: polygon turning, the tool axis turns with the spindle.
struct PolygonTurning {
  SourcePosition at;
  bool on = false;
  std::int32_t spindle_ratio = 1;  ///< P: 1…999
  std::int32_t tool_ratio = 1;     ///< Q: −999…999, negative: the other way
};

/// Second auxiliary function (B, or the address the parameters say): goes to the machine as MCode does.
struct SecondAuxiliary {
  SourcePosition at;
  ModalSnapshot modal;
  std::int64_t code = 0;
};

/// T word (lathe: tool and offset; mill: the tool to prepare; M06 is an MCode).
struct Tool {
  SourcePosition at;
  std::int32_t tool = 0;
  std::int32_t offset = 0;
};

/// An M code that goes to the machine (PLC handshake). M98/M99 and program ends are not sent this way.
struct MCode {
  SourcePosition at;
  ModalSnapshot modal;
  std::int32_t code = 0;
  bool after_motion = false;
  // M codes that drive output ports and wait for input ports (200T, K2000TC). The program does not wait for
  // a delay or a position.
  double delay_s = 0;        ///< carried out so long after it is given (M26.150)
  std::int8_t at_axis = -1;  ///< ≥ 0: carried out when this axis passes `at_position` (M1026.150)
  double at_position = 0;    ///< absolute position page, programming units
  std::int16_t input = 0;    ///< ≥ 1: finished when this input port has the level wanted (M01 L)
  bool input_level = true;   ///< true: active
  bool counts_part = false;  ///< the code that counts parts (0i-D No.6710)
  bool clears_parts = false;  ///< sets the part count to 0 and goes nowhere else (200T M901)
};

enum class MessageKind : std::uint8_t {
  show,   ///< for the operator: #3006, comments
  print,  ///< DPRNT, BPRNT: bytes for the output device, in the code of the program (not yet ISO or EIA)
  open,   ///< POPEN: connect, DC2
  close,  ///< PCLOS: DC4, disconnect
  statement  ///< no text: a macro statement at which single block stops (0i-D SBM No.6000#5)
};

/// #3006, comments to show, DPRNT output.
struct Message {
  SourcePosition at;
  std::string text;
  MessageKind kind = MessageKind::show;
};

/// M00/M01: wait for cycle start.
struct Stop {
  SourcePosition at;
  ModalSnapshot modal;
  bool optional = false;
};

/// A controller alarm: data, not an exception. `code` as that controller prints it.
struct Alarm {
  SourcePosition at;
  std::string code;    ///< "PS0010", "OT0500", GSK "11" …
  std::string detail;  ///< what in the block caused it (address, value); language-neutral
};

enum class EndReason : std::uint8_t { m02, m30, m99_main, end_of_file, alarm };

/// The program is over. `counts_part` as the dialect's parameters say (M02, M30, …).
struct End {
  SourcePosition at;
  EndReason reason = EndReason::m30;
  bool counts_part = false;
};

enum class TapKind : std::uint8_t {
  rigid,   ///< the control turns the spindle in step with the axis
  follows  ///< the axis follows the encoder of a spindle that is stopped and reversed at the bottom
};

/// Tapping, one way in and out: from where the tool stands to `bottom`, reversed, and back to the motion's end, axis and
/// spindle in step all the way. Feed override, feed hold and single block act only after it.
struct Tap : Motion {
  AxisVector bottom_work{};     ///< programming units, X as a diameter where so
  AxisVector bottom_machine{};  ///< mm
  TapKind kind = TapKind::rigid;
  double pitch_mm = 0;  ///< advance a revolution, > 0
  double rpm = 0;       ///< spindle speed in force; 0 under `follows` when none was commanded
  SpindleDirection direction = SpindleDirection::cw;  ///< inward; outward is the other one
  double dwell_s = 0;  ///< at the bottom
  std::uint8_t spindle = 0;  ///< 0: the main spindle; 1: a driven tool, which whoever has none must refuse
  double out_ratio = 1;      ///< spindle speed on the way out, against `rpm`; the axis stays in step with it (extraction override, 0i-D No. 5211); > 0
};

using Operation =
    std::variant<Rapid, Feed, Arc, Thread, Dwell, Spindle, Tool, MCode, Message, Stop, Alarm, End, ContourMode,
                 StrokeCheck, SpindleWatch, SecondAuxiliary, PolygonTurning, Tap>;

}  // namespace headstock::interp

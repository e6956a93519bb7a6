// A dialect: all that makes one controller's language differ from another's, as data and a few functions. The
// interpreter asks this structure, never the controller's name.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "compensation/rules.hpp"
#include "dialects/alarm_reason.hpp"
#include "dialects/interruption_rules.hpp"
#include "dialects/look_ahead_rules.hpp"
#include "dialects/mode_rules.hpp"
#include "dialects/tool_life_rules.hpp"
#include "dialects/tool_offset_rules.hpp"
#include "interpreter/own_language.hpp"
#include "machine/machine.hpp"

namespace headstock::macro {
struct Rules;
}
namespace headstock::interp {
struct Executor;
struct SystemVariable;
}  // namespace headstock::interp

namespace headstock::dialects {

/// Carries out a G code. @return false when it raised an alarm.
using Handler = bool (*)(interp::Executor&);

/// When in a block a G code is carried out.
enum class Phase : std::uint8_t {
  unavailable,  ///< known to the control, refused by this version: never skipped silently
  setting,      ///< before everything else: planes, units, feed modes, coordinate systems
  modifier,     ///< changes how the block's motion ends (G09)
  action,       ///< the block's axis words belong to it (G04, G10, G28 …)
  hole,         ///< hole cycles: every position drills until G80 or a code of group 01
  motion        ///< group 01; in force until the next one
};

/// One row of gcodes.tsv in one G-code system.
struct GCode {
  std::int16_t tenths = 0;  ///< G54.1 → 541
  std::uint8_t group = 0;   ///< 0: one-shot; index of ModalSnapshot::g
  Phase phase = Phase::unavailable;
  Handler handler = nullptr;
  std::string_view name;  ///< "G54.1", static storage: also what cycles are named by
  bool power_on = false;  ///< in force after power-on
  bool lead = false;      ///< F is the lead of a thread
  bool cycle = false;     ///< a canned cycle: letters like U and W are words of its own
};

/// The G codes of one G-code system, found by number without searching.
class GTable {
 public:
  void add(const GCode& code);
  const GCode* find(std::int32_t tenths) const {
    if (tenths < 0 || tenths >= kCodes) return nullptr;
    const std::uint8_t row = index_[static_cast<std::size_t>(tenths)];
    return row == 0 ? nullptr : &rows_[row - 1u];
  }
  std::span<const GCode> rows() const { return rows_; }

 private:
  static constexpr std::int32_t kCodes = 10'000;
  std::vector<GCode> rows_;
  std::array<std::uint8_t, kCodes> index_{};
};

/// What the interpreter itself does on an M code; all others go to the machine.
enum class MAction : std::uint8_t {
  machine,        ///< to the machine, together with the block's motion
  machine_after,  ///< to the machine, after the motion
  spindle_cw,
  spindle_ccw,
  spindle_stop,
  program_stop,
  optional_stop,
  end_m02,
  end_m30,
  call,
  return_,
  rigid_tapping,  ///< M29: the next tapping cycle is rigid; sent to the machine too
  restart,  ///< M96 of 200T: from the head again
  own,      ///< OwnLanguage::m_code
  unavailable
};
struct MRule {
  std::int32_t code = 0;
  MAction action = MAction::machine;
  std::int32_t last = 0;  ///< a range: code…last; 0: the one code
};

enum class Decimal : std::uint8_t {
  standard,  ///< without a point: least input increments
  pocket     ///< without a point: mm, inch, degree, second
};
enum class Rounding : std::uint8_t { half_up, truncate };
enum class Repeated : std::uint8_t { last_wins, alarm };
enum class BothForms : std::uint8_t { later_wins, absolute_wins, alarm };  ///< X with U in one block
enum class EndOfText : std::uint8_t { alarm, end };

/// A bit parameter that replaces a power-on code when it is 1.
struct PowerOnSwitch {
  std::string_view parameter;            ///< "3402#4"
  std::array<std::int16_t, 3> tenths{};  ///< for the G-code systems A, B, C; -1: no effect
};

struct NumberRules {
  Decimal decimal = Decimal::standard;
  std::string_view decimal_parameter = {};  ///< bit that chooses: empty when there is none
  Decimal decimal_when_set = Decimal::pocket;
  std::string_view standard_when_clear_parameter = {};  ///< bit, 1 unless set: 0 chooses standard
  Rounding rounding = Rounding::half_up;
  std::uint8_t most_digits = 9;                ///< typed in one word
  std::int64_t most_increments = 999'999'999;  ///< after conversion to least increments
  double feed_per_minute_unit_mm = 1;          ///< an F without a point under standard decimals
  double feed_per_minute_unit_inch = 0.01;
  double feed_per_revolution_unit_mm = 0.0001;
  double feed_per_revolution_unit_inch = 0.000001;
  std::string_view coarse_increment_parameter, fine_increment_parameter;  ///< bits: IS-A, IS-C
  std::string_view linear_decimals_parameter, rotary_decimals_parameter;  ///< value: decimals of mm, degrees
  double power_on_feed_mm_min = -1;  ///< F in force before the first F word; < 0: none
  std::uint32_t addresses = 0;       ///< letters a program may use (see program::letters)
  std::uint32_t pointed = 0;         ///< of these: may have a decimal point
  std::string_view pointed_counts_parameter = {};  ///< bit: P and Q may have one too (K2000TC PQDOT)
  std::uint32_t negative = 0;        ///< of these: may have a minus sign
};

struct ArcRules {
  double tolerance_mm = 0;  ///< start/end radius difference allowed; 0: not checked
  std::string_view tolerance_parameter = {};
  bool negative_r = true;
  bool r_and_center_is_alarm = false;
  bool feed_on_arc = false;                      ///< F of a helix counts along the arc, not along the path
  std::string_view feed_on_path_parameter = {};  ///< bit: along the path after all
  bool closed_by_r_is_alarm = false;             ///< start = end with R: an alarm instead of no motion
  double largest_r = 1e9;                        ///< of an R word [mm, inch]
};

struct ThreadRules {
  bool inch_word = false;  ///< I: threads per inch
  bool f_and_i_is_alarm = false;
  bool lead_along_path = false;  ///< F is the lead along the cone, not along the long axis
  bool f_is_feed_too = false;  ///< F stays in force for G01 after the thread; otherwise F must be given again
  double q_unit_deg = 0.001;   ///< of the start angle Q
  std::string_view q_parameter = {};  ///< bit: Q may be given; empty: always
  char change_word = 'K';      ///< G34: lead change a revolution
  bool first_lead_changed = false;  ///< G34: the first turn's lead is F plus the change already
  bool runout = false;              ///< J and K of G32: the tool leaves the thread before its end
  double most_lead_mm = 500;
};

struct CallRules {
  int nesting = 4;
  bool l_repeats = false;  ///< `M98 P L` besides the digits in P
  std::int64_t most_repeats = 9'999;
  bool by_name = false;  ///< `M98 Nname Pcount`
};

struct ToolRules {
  bool lathe = false;  ///< T calls tool and offset; otherwise T only names a tool
  int offset_digits = 2;
  std::string_view offset_digits_parameter = {};
  std::string_view geometry_by_tool_parameter = {};
  bool short_form = false;  ///< T with no more digits than the offset has: tool and offset of that number
  double sign = 1;          ///< +1: machine = work + zero + offset; -1: the offset is subtracted
  std::size_t most_offsets = 99;
};

struct Dialect {
  std::string_view profile;
  machine::Kind kind = machine::Kind::lathe;
  std::array<std::string_view, kAlarmReasons> alarm_codes{};  ///< by AlarmReason; none is empty
  std::array<GTable, 3> systems;  ///< A, B, C; controls with one system have it three times
  bool incremental_letters[3] = {false, false, false};  ///< U W V H are increments of X Z Y C in this system
  std::vector<MRule> m_rules;
  std::vector<PowerOnSwitch> power_on_switches;
  std::size_t most_m_codes = 1;       ///< in a block
  std::string_view more_m_parameter;  ///< bit: three of them
  NumberRules numbers;
  ArcRules arcs;
  ThreadRules threads;
  CallRules calls;
  ToolRules tools;
  comp::CornerRules corners;
  comp::CompensationRules compensation;
  std::string_view compensated_cycle =
      "G70";  ///< the cycle whose moves are compensated; others drop the vector
  ModeRules modes;
  ToolLifeRules life;
  LookAheadRules look_ahead;
  InterruptionRules interruption;
  std::string_view part_count_m_parameter;  ///< M code that counts a part ("6710")
  std::string_view small_hole_parameter;    ///< bit: G83 can be small-hole pecking ("8132#4")
  std::string_view small_hole_m_parameter;  ///< … behind this M code ("5163")
  std::string_view rigid_m_parameter;       ///< M code of rigid tapping beside M29 ("5210")
  ToolOffsetRules tool_offsets;
  MeasureRules measure;
  Repeated repeated_words = Repeated::last_wins;
  std::string_view repeated_alarm_parameter;  ///< bit: alarm after all
  std::uint32_t may_repeat = 0;               ///< letters that may repeat in spite of `alarm`
  Repeated same_group = Repeated::last_wins;
  bool one_shot_with_motion_is_alarm = false;
  BothForms both_forms = BothForms::later_wins;
  EndOfText end_of_text = EndOfText::alarm;
  std::size_t longest_block = 8'192;
  std::uint32_t corner_words = 0;  ///< letters of chamfers and corner rounds in G01; see take_corner_words
  bool reversal_needs_stop = false;  ///< M03 after M04 without M05 between them is an alarm
  bool inner_slash_is_alarm = false;
  bool sub_program_needs_return = false;  ///< a sub-program that ends without M99 is the alarm of nesting
  bool t_refused_with_actions = false;    ///< T may not share a block with G04 G10 G28 G30 G50 G53
  bool reset_clears = false;              ///< RESET brings the power-on codes back
  std::string_view reset_clears_parameter;
  bool local_per_system = false;          ///< G52 belongs to the coordinate system it was given in
  int first_g10_work = 1;                 ///< G10 L2 P of G54
  bool reference_refused_in_cycle = false;  ///< G27-G30 while a hole cycle is in force
  bool reference_cancels_offset = false;  ///< G28/G30 cancel the tool offset of their axes
  bool setting_ignores_offset = false;    ///< G50: the tool offset is not part of the position that is set
  bool m99_main_counts_part = false;
  bool m02_counts_part = true;
  std::string_view no_count_parameter;         ///< bit: M02/M30 do not count
  bool machine_incremental_is_alarm = false;   ///< G53 U: alarm; otherwise the word is ignored
  std::string_view setting_refused_parameter;  ///< bit: G50/G92 coordinate setting is an improper G code
  std::string_view dwell_turns_parameter;      ///< bit: G04 counts revolutions under feed per revolution
  std::string_view linear_rapid_parameter;     ///< bit: G00 runs on a straight line
  std::string_view hole_clamp_parameter;  ///< M code that clamps the rotary axis inside hole cycles
  bool g28_alone_moves_all = false;            ///< G28 without axes sends every axis home
  /// The controller's macro language, or at least its variables; nullptr: it has none. Static storage.
  const macro::Rules* macros = nullptr;
  std::span<const interp::SystemVariable> system_variables;  ///< numbers from 1000 up, any order
  /// A text that starts like a macro statement, when the dialect has a form of its own (200T names). May be
  /// nullptr.
  bool (*statement)(interp::Executor&, std::string_view text, std::uint32_t column) = nullptr;
  /// The dialect's own memory and text rules. May be nullptr.
  std::unique_ptr<interp::OwnLanguage> (*make_own)(interp::Executor&) = nullptr;

  std::string_view alarm_code(AlarmReason reason) const {
    return alarm_codes[static_cast<std::size_t>(reason)];
  }
  void set_alarm_code(AlarmReason reason, std::string_view code) {
    alarm_codes[static_cast<std::size_t>(reason)] = code;
  }
  const GTable& table(char system) const { return systems[system == 'C' ? 2 : system == 'B' ? 1 : 0]; }
  MAction m_action(std::int32_t code) const {
    for (const MRule& rule : m_rules) {
      if (rule.code == code || (code > rule.code && code <= rule.last)) return rule.action;
    }
    return MAction::machine;
  }
};

/// @return nullptr when the profile is not one of the six. Any thread; the dialects are constants.
const Dialect* find(std::string_view profile);

/// The names of the six dialects.
std::span<const std::string_view> dialect_names();

}  // namespace headstock::dialects

// The 200T's own language: blocks are text with string labels, #-variables, port M codes and block loops.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "interpreter/executor.hpp"
#include "program/lexer.hpp"

namespace headstock::dialects::lathe_200t {

using interp::AlarmReason;
using interp::Executor;
using interp::Frame;

/// User variables #200…#229; #200…#209 outlive power-off (L9004).
inline constexpr std::uint32_t kFirstUser = 200, kLastUser = 229, kLastRetained = 209;

/// A label is a string: N0010 is not N10 (L4971). @return the number the search for it goes by, -1 when it is
/// not made of digits.
std::int64_t label_key(std::string_view label);

/// Is there such an input port or input function (signals.tsv)?
bool is_input(std::int64_t port);

/// `#201`, `-#201`, `##200` behind an address (L9019). There is no null: an unset variable is 0.
class Variables final : public program::ExpressionReader {
 public:
  explicit Variables(Executor& executor) : ex_(executor) {}
  program::LexError read(const char*& at, const char* end, double& value, bool& is_null) override;
  /// @return false when there is no such variable.
  bool get(std::int64_t number, double& value) const;
  bool set(std::int64_t number, double value);
  /// The number of the variable that `#…` at `at` names, -1 when it is not a variable.
  std::int64_t number_at(const char*& at, const char* end) const;

 private:
  Executor& ex_;
};

class Language final : public interp::OwnLanguage {
 public:
  explicit Language(Executor& ex) : variables(ex) {}

  void power_on(Executor& ex) override;
  void start(Executor& ex) override;
  void reset(Executor& ex) override;
  std::unique_ptr<interp::OwnModes> make_modes() const override;
  void keep_modes(interp::OwnModes& into) const override;
  void restore_modes(const interp::OwnModes& from) override;
  Taken before_block(Executor& ex, Frame& frame) override;
  Taken take_text(Executor& ex, Frame& frame) override;
  Taken take_spindle(Executor& ex) override;
  bool m_code(Executor& ex, const program::Code& code) override;

  /// Carries out `G65 H… P… Q… R…` (macro.cpp). @param at behind "G65".
  bool macro(Executor& ex, std::string_view line, const char* at);
  /// G170 and G171 (loops.cpp). @param at behind the code.
  bool loop(Executor& ex, Frame& frame, const char* at, bool counted);
  bool call_name(Executor& ex, std::string_view name, std::int64_t times, std::uint32_t column);
  bool jump(Executor& ex, std::string_view label, std::uint32_t column);

  Variables variables;
  /// What G52, G59 and G60 added to the Reference component, per axis, slide mm; it is part of zero_shift
  /// too.
  std::vector<double> reference_shift;
  /// zero_shift and zero_local at the last G50, per axis.
  struct StartPoint {
    double shift = 0, local = 0;
  };
  std::vector<StartPoint> start_points;

 private:
  struct Loop {
    std::size_t depth = 0;  // of the program on the call stack
    std::int64_t begin = 0, end = 0;
    std::int64_t own_label = -1;  // of the G171 block
    std::string begin_name, end_name;
    std::int64_t left = 0;          // runs to go, this one included; < 0: for ever
    std::uint64_t code_offset = 0;  // of the G171 block
    std::uint64_t next_offset = 0;  // of the block behind it
    std::uint32_t next_line = 0;
    std::uint32_t column = 0;
    bool left_by_jump = false;  // a jump went somewhere since: the loop may have been left
  };
  struct Level {  // of the call stack
    std::string text;
    std::string name;
    std::int64_t last_label = -1;  // of the block carried out last
  };
  Level& level(Executor& ex);
  bool take_label(Executor& ex, Frame& frame, std::string& text, std::size_t& at);
  bool take_m_codes(Executor& ex, std::string& text);
  bool port_code(Executor& ex, std::string_view word, std::uint32_t column);

  std::deque<Level> levels_;  // addresses stay: lines of callers live on in here
  std::vector<Loop> loops_;
  std::string call_name_;
  std::int64_t call_times_ = 1;
  std::uint32_t call_column_ = 0;
};

Language& language(Executor& ex);

// Coordinate components (components.cpp).
bool modify_offset(Executor& ex);     // G10
bool start_point(Executor& ex);       // G26 G27 G29
bool home(Executor& ex);              // G28
bool set_start(Executor& ex);         // G50
bool clear_reference(Executor& ex);   // G52
bool cancel_shift(Executor& ex);      // G53
bool shift(Executor& ex);             // G58
bool system_component(Executor& ex);  // G59
bool modify_component(Executor& ex);  // G60
bool user_macro(Executor& ex);        // G160…G169 (macro.cpp)
bool skip(Executor& ex);              // G31
bool dwell(Executor& ex);             // G04

}  // namespace headstock::dialects::lathe_200t

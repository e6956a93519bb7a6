// The K2000TC's own language: macro statements as in C, calls, conditional jumps, curves made of many moves.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "dialects/k2000tc/curves.hpp"
#include "dialects/k2000tc/spindle_thread_cycle.hpp"
#include "interpreter/executor.hpp"
#include "macro/k2000-language/expression.hpp"
#include "program/lexer.hpp"

namespace headstock::dialects::k2000tc {

using interp::AlarmReason;
using interp::Executor;
using interp::Frame;
using k2000::Value;

/// An argument of CALL: one value, or those of an array.
using Argument = std::vector<Value>;

/// G07.2: a rotary axis that follows a linear one.
struct SpindleThread {
  bool on = false;
  std::size_t linear = 0, spindle = 0;
  double lead_mm = 0;     ///< at the start of the next block; 0: the spindle stands still
  bool reversed = false;  ///< NP1
  double turns(double way, double distance, double lead_end) const;
};

class Language final : public interp::OwnLanguage, public k2000::Variables {
 public:
  explicit Language(Executor& ex) : ex_(ex), reader_(*this) {}

  void power_on(Executor& ex) override;
  void start(Executor& ex) override;
  void reset(Executor& ex) override;
  std::unique_ptr<interp::OwnModes> make_modes() const override;
  void keep_modes(interp::OwnModes& into) const override;
  void restore_modes(const interp::OwnModes& from) override;
  Taken before_block(Executor& ex, Frame& frame) override;
  Taken take_text(Executor& ex, Frame& frame) override;
  Taken take_block(Executor& ex) override;
  Taken statement(Executor& ex, std::string_view text, std::uint32_t column) override;
  bool end_of_text(Executor& ex, Frame& frame) override;
  bool m_code(Executor& ex, const program::Code& code) override;
  void moved(Executor& ex, interp::Motion& motion) override;

  k2000::Error read(std::uint32_t number, Value& value) override;
  k2000::Error write(std::uint32_t number, const Value& value) override;

  /// Calls a program with locals of its own. @param locals what they start with.
  bool call_macro(Executor& ex, std::int64_t number, std::int64_t times,
                  const std::array<Value, k2000::kLocals>& locals, std::uint32_t column);
  /// The words of the block as arguments (L20150); they are gone from the block afterwards.
  bool take_arguments(Executor& ex, std::array<Value, k2000::kLocals>& locals);
  /// An alarm that only this control has. Always returns false.
  bool raise(Executor& ex, std::string_view code, std::uint32_t column, std::string detail);

  std::int32_t last_m = 0;  ///< #4112

  // ---- curves and modes
  std::unique_ptr<RunningCurve> curve;  ///< being cut into chords
  interp::Point3 normal{};              ///< NI NJ NK
  std::uint32_t hypothetical = 0;       ///< G07: axes that only exist in the program …
  interp::AxisVector frozen{};          ///< … and where their slides stand
  SpindleThread thread;
  SpindleThreadWords thread_words;  ///< G78.1
  double fast_feed = -1;  ///< NF of G153; < 0: none
  /// Indices of Xp, Yp, Zp, kNoAxis where the machine has none. @return false when there are less than two.
  bool cartesian_axes(const Executor& ex, std::uint8_t (&axes)[3]) const;
  void set_diameter(Executor& ex, std::size_t axis, bool diameter);
  void cancel_tool_offset(Executor& ex);

 private:
  // Works out `#1` and `[…]` behind an address while the block is read.
  class Reader final : public program::ExpressionReader {
   public:
    explicit Reader(Language& language) : language_(language) {}
    program::LexError read(const char*& at, const char* end, double& value, bool& is_null) override;

   private:
    Language& language_;
  };
  struct Loop {
    std::int64_t label = 0;
    std::uint64_t offset = 0;  // of the WHILE or DO block
    std::uint32_t line = 0;
    bool left_by_jump = false;
  };
  struct Level {       // of the call stack
    std::string text;  // the line in the form of COMP=1
    std::array<Value, k2000::kLocals> locals;
    bool own_locals = false;
    std::vector<Argument> arguments;
    std::vector<Loop> loops;
    std::int64_t skip_to_end = -1;  // WHILE is false: reading on to END n
    interp::SourcePosition skip_from;
  };
  struct Statement {  // being carried out
    Executor& ex;
    k2000::Parser parser;
    std::uint32_t column;
    std::uint32_t here() const { return column + static_cast<std::uint32_t>(parser.offset()); }
  };

  Level& level(Executor& ex);
  std::array<Value, k2000::kLocals>& locals();
  bool wrong(Statement& s, k2000::Error otherwise = k2000::Error::syntax);
  bool wrong_value(Executor& ex, k2000::Error error, std::uint32_t column);
  bool run_statement(Statement& s);
  bool assignment(Statement& s);
  bool assign_array(Statement& s, const k2000::Place& target);
  bool whole(Statement& s, std::int64_t& value);
  bool condition(Statement& s, bool& yes);
  bool do_if(Statement& s);
  bool do_goto(Statement& s);
  bool do_loop(Statement& s, bool is_while);
  bool do_end(Statement& s);
  bool do_message(Statement& s);
  bool do_error(Statement& s);
  bool do_write(Statement& s);
  bool do_handle(Statement& s, bool open);
  bool do_call(Statement& s);
  bool do_params(Statement& s);
  bool message_text(Statement& s, std::string& text);
  void leave_modes(Executor& ex);
  bool check_words(Executor& ex);
  bool jump(Executor& ex, std::int64_t target, std::uint32_t column);
  Taken skip_block(Executor& ex, Frame& frame);
  Taken search_block(Executor& ex, Frame& frame);
  bool write_out(Executor& ex, std::string text);
  bool jump_input(int which) const;  // M91I, M93I
  k2000::Error machine_variable(std::uint32_t number, Value& value);
  k2000::Error set_machine_variable(std::uint32_t number, const Value& value);
  k2000::Error read_system(std::uint32_t number, Value& value);
  k2000::Error write_system(std::uint32_t number, const Value& value);

  Executor& ex_;
  Reader reader_;
  k2000::Options options_;
  bool other_brackets_ = false;  // COMP=0
  bool write_open_ = false;
  std::deque<Level> levels_;                // addresses stay
  std::map<std::uint32_t, Value> commons_;  // with their types; MachineData has the numbers
  std::map<std::int64_t, std::uint32_t> user_g_, user_m_, user_t_;  // code → program, from the parameters
};

Language& language(Executor& ex);

bool macro_call(Executor& ex);  // G65

}  // namespace headstock::dialects::k2000tc

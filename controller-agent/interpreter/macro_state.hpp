// What the interpreter keeps for macros: variables, compiled programs, calls by code, the modal calls of each
// program on the stack. Executor holds one MacroState when its dialect has variables at all.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "interpreter/canonical.hpp"
#include "interpreter/compiled_program.hpp"
#include "interpreter/sequence_memory.hpp"
#include "macro/environment.hpp"
#include "macro/rules.hpp"
#include "macro/variables.hpp"
#include "program/lexer.hpp"

namespace headstock::interp {

struct Executor;
struct MachineData;

/// How a program came onto the stack.
enum class CallKind : std::uint8_t {
  main,
  sub,          ///< M98, or a code that calls like it: same locals
  macro,        ///< G65, or a code that calls like it: own locals
  modal,        ///< G66: own locals that stay from call to call
  interruption  ///< M96 P
};

/// A G66 in force.
struct ModalCall {
  std::uint32_t program = 0;
  std::int64_t times = 1;
  bool every_block = false;  ///< G66.1
  std::shared_ptr<macro::LocalSet> locals;
};
using ModalCalls = std::vector<std::shared_ptr<ModalCall>>;

struct Loop {
  CompiledBlock* begin = nullptr;
};

/// What M99 of an interruption program brings back.
struct InterruptedState;

/// What the macro side keeps of a program on the stack (a member of Frame).
struct MacroFrame {
  std::shared_ptr<CompiledProgram> code;
  CompiledBlock* next = nullptr;  ///< carried out next, without reading
  CompiledBlock* last = nullptr;  ///< carried out last, when what follows it is not linked yet
  bool displaced = false;         ///< the reader is elsewhere: go to `place` before reading
  BlockPlace place;
  std::vector<Loop> loops;
  // ---- looking for a sequence number
  CompiledBlock* jump_from = nullptr;  ///< remembers what it finds
  BlockPlace search_from;              ///< where the search began: it ends there after the turn
  bool search_turned = false;          ///< it has gone on from the head
  // ---- how it was called
  CallKind kind = CallKind::main;
  bool by_code = false;              ///< called by a G, M or T code, or from such a program
  bool external = false;             ///< M198
  std::int64_t start_sequence = -1;  ///< M98 P Q
  std::shared_ptr<macro::LocalSet> locals;
  std::unique_ptr<macro::LocalSet> arguments;  ///< of a macro called more than once: set again each time
  // ---- modal calls
  ModalCalls modal_calls;
  bool returns_after_call = false;  ///< M99 stood in the block whose move made the call
  std::int64_t returns_to = -1;
  std::unique_ptr<SequenceMemory> passed;  ///< sequence numbers, for GOTO
  // ---- an interruption
  std::shared_ptr<InterruptedState> interrupted;
};

/// A code that calls a program.
struct CodeCall {
  std::int32_t tenths = 0;  ///< the code, times ten
  std::uint32_t program = 0;
  bool modal = false;
  bool macro = false;  ///< arguments and own locals; otherwise like M98
};

/// Modal values of a block, for #4001…, #4201…, #4401….
struct ModalValues {
  ModalSnapshot modal;
  double b = 0, d = 0, e = 0, h = 0, m = 0;
  std::uint32_t sequence = 0, program = 0, extra_work = 0;
};

/// Compiles the expressions of the block being read.
class WordCompiler final : public program::ExpressionReader {
 public:
  WordCompiler(const macro::Rules& rules, bool lathe) : rules_(rules), lathe_(lathe) {}
  bool compiles() const override { return true; }
  program::LexError compile(const char*& at, const char* end, std::uint16_t& expression) override;
  std::vector<macro::Expression> expressions;  ///< of the block; emptied by who reads the next one
  macro::Fault fault = macro::Fault::count_;   ///< why `compile` failed

 private:
  const macro::Rules& rules_;
  bool lathe_;
};

class SystemAccess final : public macro::SystemVariables {
 public:
  explicit SystemAccess(Executor& executor) : executor_(executor) {}
  macro::Result read_system(std::uint32_t number, double& value) override;
  macro::Result write_system(std::uint32_t number, double value) override;

 private:
  Executor& executor_;
};

struct MacroState {
  MacroState(Executor& executor, const macro::Rules& macro_rules, bool lathe);

  /// The main program's locals outlive reset and the program's end (2000TC S173.1 CLV).
  bool keeps_locals(const MachineData& data) const;

  const macro::Rules& rules;
  macro::Environment* environment;  ///< Executor::environment
  SystemAccess system;
  macro::CommonVariables common;
  std::uint64_t common_version = 0;  ///< MachineData::version they were loaded at
  macro::Variables variables;
  WordCompiler words;
  std::map<std::uint32_t, std::shared_ptr<CompiledProgram>> programs;  ///< of this run, by O number
  CompiledBlock scratch;                                               ///< a block that is not kept

  // ---- calls by code, from the parameters at the start of the run
  std::vector<CodeCall> g_calls, m_calls;
  std::array<char, 2> call_letters{};  ///< '\0': none
  bool t_calls = false;
  std::int32_t external_m = 198;
  bool calls_by_code = false;  ///< any of the first four: blocks are looked through

  // ---- what blocks before this one left behind
  std::array<ModalValues, 2> history;  ///< of the last two blocks
  std::size_t newest = 0;              ///< of the two
  ModalValues interrupted;
  std::uint32_t control = 0;                              ///< #3003, and #3004 from bit 4 on
  std::array<double, program::kMostComputed> computed{};  ///< values of Block::computed, not rounded
  std::string comment;  ///< of the statement being carried out: #3000, #3006
  const std::vector<macro::Expression>* filled = nullptr;  ///< the block's, by ComputedWord::expression
  macro::LocalSet kept_locals;  ///< of the main program, see Rules::clear_locals_parameter
  std::uint64_t writes_at_jump = 0;
};

}  // namespace headstock::interp

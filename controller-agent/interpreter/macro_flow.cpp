// Macro statements: keeping blocks compiled, carrying them out, jumps and loops.
#include <cmath>
#include <utility>

#include "interpreter/executor.hpp"
#include "macro/print.hpp"

namespace headstock::interp {

using macro::Result;
using macro::Status;

namespace {

// The text of a block before its `;`.
std::string_view without_end(std::string_view text) {
  bool comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == ';' && !comment) return text.substr(0, i);
    if (text[i] == '(' || text[i] == ')') comment = text[i] == '(';
  }
  return text;
}

double eight_digits(double value) {
  if (value == 0 || macro::is_null(value)) return value;
  const double scale = std::pow(10, 7 - std::floor(std::log10(std::fabs(value))));
  return std::isfinite(scale) && scale != 0 ? std::round(value * scale) / scale : value;
}

bool truth(const macro::Expression& condition, macro::Variables& variables, Result& result) {
  double value = 0;
  result = macro::evaluate(condition, variables, 1, value);
  return result.ok() && macro::or_zero(value) != 0;
}

}  // namespace

program::LexError WordCompiler::compile(const char*& at, const char* end, std::uint16_t& expression) {
  const char* begin = at;
  macro::Expression compiled;
  const macro::TextFault wrong = macro::compile_word(at, end, rules_, lathe_, compiled);
  if (wrong) {
    fault = wrong.reason;
    at = wrong.at != nullptr ? wrong.at : begin;
    return program::LexError::expression;
  }
  expression = static_cast<std::uint16_t>(expressions.size());
  expressions.push_back(std::move(compiled));
  return program::LexError::none;
}

// @return nullptr after an alarm: the statement's text is wrong.
CompiledBlock* Executor::keep_block(const program::LexResult& read, const BlockPlace& place) {
  Frame& frame = frames.back();
  MacroFrame& macro = frame.macro;
  const bool loops = !macro.loops.empty();
  bool room = macro.code->size() < CompiledProgram::kMost;
  if (!room && !loops) {  // nothing on the stack points into it: what is met again is compiled again
    bool used = false;
    for (const Frame& other : frames) used = used || (&other != &frame && other.macro.code == macro.code);
    if (!used) {
      macro.code->clear();
      macro.last = nullptr;
      room = true;
    }
  }
  auto made = std::make_unique<CompiledBlock>();
  CompiledBlock& c = *made;
  c.place = place;
  c.next_line = frame.reader->place();
  c.ends_line = frame.rest == nullptr;
  c.after = c.ends_line
                ? BlockPlace{c.next_line, 0}
                : BlockPlace{place.line, static_cast<std::uint32_t>(frame.rest - frame.line.text.data())};
  c.has_sequence = block.has_sequence;
  c.sequence = block.sequence;
  c.has_number = block.has_number;
  c.number = block.number;
  c.skip = block.skip;
  c.is_statement = read.status == program::LexStatus::statement;
  c.column = read.column;
  c.is_empty = !c.is_statement && (block.words | block.marked | block.g_count | block.m_count) == 0;
  if (c.is_statement) {
    const macro::TextFault wrong =
        macro::compile_statement(read.statement, macros->rules, dialect.tools.lathe, c.statement);
    if (wrong) {
      alarm(wrong.reason, wrong.at == nullptr
                              ? read.column
                              : static_cast<std::uint32_t>(wrong.at - frame.line.text.data()) + 1);
      return nullptr;
    }
  } else {
    c.block.pack(block);
    c.expressions = std::move(macros->words.expressions);
    macros->words.expressions.clear();
  }
  const bool loop = c.is_statement && (c.statement.kind == macro::StatementKind::while_do ||
                                       c.statement.kind == macro::StatementKind::end);
  CompiledBlock* kept = nullptr;
  if (room || loop) {
    kept = macro.code->keep(std::move(made));
    if (macro.last != nullptr) macro.last->next = kept;
  } else {
    macros->scratch = std::move(*made);
    kept = &macros->scratch;
  }
  return kept;
}

void Executor::go_on_after(const CompiledBlock& compiled) {
  MacroFrame& macro = frames.back().macro;
  macro.next = compiled.next;
  macro.last = nullptr;
  if (compiled.next != nullptr) macro.displaced = true;  // the reader stays behind
  if (macro.displaced) macro.place = compiled.after;
  if (compiled.next == nullptr && &compiled != &macros->scratch)
    macro.last = const_cast<CompiledBlock*>(&compiled);
}

void Executor::go_on_at(const BlockPlace& place) {
  Frame& frame = frames.back();
  frame.rest = nullptr;
  frame.macro.next = frame.macro.code->find(place.offset());
  frame.macro.last = nullptr;
  frame.macro.displaced = true;
  frame.macro.place = place;
}

// One compiled block. When a value in it is only true at a standstill nothing has happened yet and the block
// is carried out again.
Executor::Step Executor::carry_out(CompiledBlock& c) {
  Frame& frame = frames.back();
  at.program = frame.number;
  at.line = c.place.line.number;
  at.column = 0;
  at.byte_offset = c.place.offset();
  if (interruption.enabled && frame.macro.kind != CallKind::interruption) interruption.block = c.place;
  if (c.has_number) {
    if (!frame.at_start && c.number != frame.number) {
      end_of_text(true);
      return Step::done;
    }
    if (frame.at_start) frame.number = at.program = c.number;
  }
  if (c.has_sequence) {
    at.sequence = c.sequence;
    remember_sequence(c.sequence, c.place);
  }
  if (c.skip != 0 && (c.skip & switches.block_skip) != 0) {
    go_on_at({c.next_line, 0});
    return Step::done;
  }
  const bool bare = c.is_empty && (c.has_number || c.has_sequence);  // O or N alone is a block (0i-D L31468)
  if (restarting && restart_reached(c.has_sequence, c.sequence, (!c.is_empty && !c.is_statement) || bare)) {
    frame.macro.next = &c;
    return Step::done;
  }
  if (!c.is_empty || c.has_sequence) frame.at_start = false;

  Result result;
  if (c.is_statement) {
    pipeline.block_read();  // counts as a block without movement (0i-D M, K2000TC L19782)
    result = run_statement(c);
  } else if (!c.is_empty) {
    c.block.unpack(block);
    block.has_sequence = c.has_sequence;
    block.sequence = c.sequence;
    block.has_number = c.has_number;
    result = data_input_waits() ? Result::later() : fill_computed(c);
  }
  if (result.status == Status::standstill || result.status == Status::wait) {
    frame.macro.next = &c;
    return result.status == Status::wait ? Step::wait : Step::standstill;
  }
  if (result.status == Status::fault) {
    if (!finished) alarm(result.fault, c.is_statement ? c.column : at.column);
    return Step::done;
  }
  if (!c.is_empty) pipeline.block_read();
  if (c.is_statement) {
    if (!finished && stops_at_statements()) {
      auto& passed = emit<Message>();
      passed.at = at;
      passed.kind = MessageKind::statement;
    }
    return Step::done;
  }
  go_on_after(c);
  if (!c.is_empty) modal_memory.before_block(*this);
  if (bare && data_input.line == nullptr) ++at.block;
  if (!c.is_empty && own && own->take_block(*this) == OwnLanguage::Taken::done) return Step::done;
  run_block(c.is_empty, c.has_sequence, c.sequence);
  return Step::done;
}

// SBM stops always; SBV unless #3003 says not to (0i-D L20275).
bool Executor::stops_at_statements() const {
  const macro::Rules& rules = macros->rules;
  return data.bit(rules.single_block_parameter) ||
         (data.bit(rules.switched_single_block_parameter) && (macros->control & 1u) == 0);
}

Result Executor::run_statement(CompiledBlock& c) {
  using macro::StatementKind;
  const macro::Statement& statement = c.statement;
  Result result;
  if (statement.kind == StatementKind::while_do) return begin_loop(c);
  if (statement.kind == StatementKind::end) return end_loop(c);
  if (statement.conditional && !truth(statement.condition, macros->variables, result)) {
    if (result.ok()) go_on_after(c);
    return result;
  }
  switch (statement.kind) {
    case StatementKind::assign:
      result = assign(statement);
      break;
    case StatementKind::go_to:
      return go_to_sequence(c);
    case StatementKind::print_text:
    case StatementKind::print_words:
    case StatementKind::open:
    case StatementKind::close:
      result = print_statement(statement);
      break;
    case StatementKind::set_names:
      result = set_names(statement);
      break;
    case StatementKind::while_do:
    case StatementKind::end:
      break;
  }
  if (result.ok() && !finished) go_on_after(c);
  return result;
}

Result Executor::assign(const macro::Statement& statement) {
  macro::Variables& variables = macros->variables;
  double value = 0;
  Result result = macro::evaluate(statement.value, variables, 1, value);
  if (!result.ok()) return result;
  if (variables.eight_digits) value = eight_digits(value);
  std::uint32_t number = 0;
  result = macro::locate(statement.place, variables, number);
  if (!result.ok()) return result;
  if (statement.place.how.op == macro::Op::bit) {
    double word = 0;
    result = variables.read(number, word);
    if (!result.ok()) return result;
    const auto bit = 1u << statement.place.how.step;
    const auto bits = static_cast<std::uint32_t>(macro::or_zero(word));
    value = macro::or_zero(value) != 0 ? bits | bit : bits & ~bit;
  }
  macros->comment = statement.comment;
  at.column = 0;
  return variables.write(number, value);
}

Result Executor::print_statement(const macro::Statement& statement) {
  using macro::StatementKind;
  std::string text;
  MessageKind kind = MessageKind::print;
  if (statement.kind == StatementKind::open || statement.kind == StatementKind::close) {
    kind = statement.kind == StatementKind::open ? MessageKind::open : MessageKind::close;
  } else {
    const macro::PrintFormat format{data.bit(macros->rules.print_plain_parameter),
                                    data.bit(macros->rules.print_cr_parameter)};
    const Result result = macro::print(statement, macros->variables, format, text);
    if (!result.ok()) return result;
  }
  auto& message = emit<Message>();
  message.at = at;
  message.kind = kind;
  message.text = std::move(text);
  return {};
}

Result Executor::set_names(const macro::Statement& statement) {
  std::uint32_t number = statement.number;
  for (const std::string& name : statement.names) {
    if (number < 500 || number > 549) return Result::failed(AlarmReason::macro_names_form);
    macros->variables.name(number, name);
    if (std::string& kept = data.variable_names[number]; kept != name) {  // outlives power-off (L17203)
      kept = name;
      const double value = macros->common.get(number);
      report_change("variable/" + std::to_string(number), value, value);
    }
    ++number;
  }
  return {};
}

// A jump ends the loops it leaves (0i-D 14.4: out of a loop is allowed, into one is not).
void Executor::leave_loops_around(std::uint64_t offset) {
  auto& loops = frames.back().macro.loops;
  while (!loops.empty()) {
    const CompiledBlock& begin = *loops.back().begin;
    if (offset > begin.place.offset() && offset <= begin.loop_end.offset()) return;
    loops.pop_back();
  }
}

Result Executor::go_to_sequence(CompiledBlock& c) {
  double value = 0;
  const Result result = macro::evaluate(c.statement.value, macros->variables, 1, value);
  if (!result.ok()) return result;
  value = std::floor(macro::or_zero(value) + 0.5);
  if (!(value >= 1 && value <= macros->rules.most_goto)) return Result::failed(AlarmReason::macro_goto_range);
  const auto sequence = static_cast<std::uint32_t>(value);
  Frame& frame = frames.back();
  if (frames.size() == 1 && switches.origin != ProgramOrigin::memory)
    return Result::failed(switches.origin == ProgramOrigin::mdi ? AlarmReason::mdi_jump : AlarmReason::macro_dnc);
  if (frame.macro.passed != nullptr) {
    if (const BlockPlace* place = frame.macro.passed->find(sequence)) {
      const BlockPlace there = *place;
      if (!count_jump()) return {};
      frame.macro.passed->found(sequence, there);
      leave_loops_around(there.offset());
      go_on_at(there);
      return {};
    }
  }
  for (const auto& [known, place] : c.targets) {
    if (known != sequence) continue;
    if (!count_jump()) return {};
    leave_loops_around(place.offset());
    go_on_at(place);
    return {};
  }
  program::BlockReader* reader = reader_of(frame);
  if (reader == nullptr) return {};
  if (!reader->can_seek()) return Result::failed(AlarmReason::macro_dnc);
  const bool kept = &c != &macros->scratch;
  if (frame.macro.displaced) frame.macro.place = c.after;
  if (begin_search(sequence, c.column, AlarmReason::macro_goto_target) && kept) frame.macro.jump_from = &c;
  return {};
}

Result Executor::begin_loop(CompiledBlock& c) {
  MacroFrame& macro = frames.back().macro;
  const bool inside = !macro.loops.empty() && macro.loops.back().begin == &c;
  if (frames.size() == 1 && switches.origin != ProgramOrigin::memory)
    return Result::failed(switches.origin == ProgramOrigin::mdi ? AlarmReason::mdi_jump : AlarmReason::macro_dnc);
  if (!c.loop_known) {
    const Result result = find_loop_end(c);
    if (!result.ok()) return result;
    if (!c.loop_known) return {};  // an alarm
  }
  Result result;
  const bool goes_in = !c.statement.conditional || truth(c.statement.condition, macros->variables, result);
  if (!result.ok()) return result;
  if (!goes_in) {
    if (inside) macro.loops.pop_back();
    go_on_at(c.loop_after);
    return {};
  }
  if (!inside) {
    leave_loops_around(c.place.offset());
    for (const Loop& loop : macro.loops) {
      if (loop.begin->statement.number == c.statement.number)
        return Result::failed(AlarmReason::macro_loop_end);
    }
    macro.loops.push_back({&c});
  }
  go_on_after(c);
  return {};
}

Result Executor::end_loop(CompiledBlock& c) {
  MacroFrame& macro = frames.back().macro;
  if (macro.loops.empty() || macro.loops.back().begin->statement.number != c.statement.number)
    return Result::failed(AlarmReason::macro_loop_begin);
  if (!count_jump()) return {};
  CompiledBlock* begin = macro.loops.back().begin;
  frames.back().rest = nullptr;
  macro.next = begin;
  macro.last = nullptr;
  macro.displaced = true;
  macro.place = begin->place;
  return {};
}

// Reads ahead for the END of a DO; ranges may be nested but must not cross (PS0124).
Result Executor::find_loop_end(CompiledBlock& c) {
  Frame& frame = frames.back();
  program::BlockReader* reader = reader_of(frame);
  if (reader == nullptr) return {};
  if (!reader->can_seek()) return Result::failed(AlarmReason::macro_dnc);
  frame.macro.displaced = true;
  frame.macro.place = c.after;
  frame.rest = nullptr;
  if (!reader->seek(c.after.line)) return Result::failed(AlarmReason::input_failed);
  std::uint32_t within = c.after.within;
  std::vector<int> open;
  program::Line line;
  for (;;) {
    const program::LineStatus status = reader->next(line);
    if (status == program::LineStatus::wait) return {Status::wait, AlarmReason::count_};
    if (status != program::LineStatus::line) return Result::failed(AlarmReason::macro_loop_end);
    const char* begin = line.text.data();
    const char* end = begin + line.text.size();
    const char* at_block = begin + std::min<std::size_t>(within, line.text.size());
    within = 0;
    do {
      const program::BlockHead head = program::read_head(line.text, at_block, lex_rules);
      if (head.record_end || (head.has_number && head.number != frame.number))
        return Result::failed(AlarmReason::macro_loop_end);
      const bool skipped = (head.skip & switches.block_skip) != 0;
      const int mark =
          skipped
              ? 0
              : macro::loop_mark(without_end({head.body, static_cast<std::size_t>(head.rest - head.body)}));
      if (mark > 0) {
        open.push_back(mark);
        if (open.size() > 64) return Result::failed(AlarmReason::macro_loop_end);
      } else if (mark < 0 && open.empty()) {
        if (-mark != static_cast<int>(c.statement.number)) return Result::failed(AlarmReason::macro_loop_end);
        c.loop_end = {line.place, static_cast<std::uint32_t>(at_block - begin)};
        c.loop_after = head.rest == end
                           ? BlockPlace{reader->place(), 0}
                           : BlockPlace{line.place, static_cast<std::uint32_t>(head.rest - begin)};
        c.loop_known = true;
        return {};
      } else if (mark < 0) {
        if (open.back() != -mark) return Result::failed(AlarmReason::macro_loop_end);
        open.pop_back();
      }
      at_block = head.rest;
    } while (at_block < end);
  }
}

}  // namespace headstock::interp

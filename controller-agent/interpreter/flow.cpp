// How blocks follow each other: reading, skipping, calls, jumps, ends.
#include <algorithm>
#include <utility>

#include "interpreter/executor.hpp"

namespace headstock::interp {
namespace {

// Jumps that follow each other without motion, dwell, stop or M code and without any assignment between them:
// nothing can end such a loop.
constexpr std::uint64_t kIdleJumps = 100'000;

AlarmReason reason_of(program::LexError error) {
  using program::LexError;
  switch (error) {
    case LexError::no_address:
      return AlarmReason::no_address;
    case LexError::no_data:
      return AlarmReason::no_data;
    case LexError::illegal_minus:
      return AlarmReason::minus_sign;
    case LexError::illegal_point:
      return AlarmReason::decimal_point;
    case LexError::too_many_digits:
      return AlarmReason::too_many_digits;
    case LexError::illegal_character:
      return AlarmReason::illegal_address;
    case LexError::too_many_codes:
      return AlarmReason::too_many_m;
    case LexError::too_many_words:
      return AlarmReason::too_many_words;
    case LexError::mixed_statement:
      return AlarmReason::macro_with_words;
    case LexError::computed_number:
      return AlarmReason::computed_number;
    case LexError::sequence_format:
      return AlarmReason::program_number;
    case LexError::expression:
    case LexError::none:
      break;
  }
  return AlarmReason::expression;
}

}  // namespace

// A reader that a program left behind, or a new one: calls in a loop allocate nothing.
std::unique_ptr<program::BlockReader> Executor::take_reader(std::unique_ptr<program::Source> source) {
  if (spare_readers.empty())
    return std::make_unique<program::BlockReader>(std::move(source), dialect.longest_block);
  auto reader = std::move(spare_readers.back());
  spare_readers.pop_back();
  reader->restart(std::move(source));
  return reader;
}

program::BlockReader* Executor::reader_of(Frame& frame) {
  if (frame.reader != nullptr) return frame.reader.get();
  auto source = programs == nullptr    ? nullptr
                : frame.macro.external ? programs->open_external(frame.number)
                                       : programs->open_number(frame.number);
  if (source == nullptr) {
    alarm(AlarmReason::program_not_found, 0, "O" + std::to_string(frame.number));
    return nullptr;
  }
  frame.reader = take_reader(std::move(source));
  return frame.reader.get();
}

bool Executor::settle_reader() {
  Frame& frame = frames.back();
  program::BlockReader* reader = reader_of(frame);
  if (reader == nullptr) return false;
  frame.macro.next = frame.macro.last = nullptr;
  if (!frame.macro.displaced) return true;
  const BlockPlace place = frame.macro.place;
  leave_chain();
  frame.rest = nullptr;
  if (!reader->seek(place.line)) return alarm(AlarmReason::input_failed, 0);
  if (place.within != 0 && reader->next(frame.line) == program::LineStatus::line)
    frame.rest = frame.line.text.data() + std::min<std::size_t>(place.within, frame.line.text.size());
  return true;
}

void Executor::leave_chain() {
  MacroFrame& macro = frames.back().macro;
  macro.next = macro.last = nullptr;
  macro.displaced = false;
  macro.place = {};
}

Executor::Step Executor::step() {
  Frame& frame = frames.back();
  modal_memory.block_done();
  if (barrier) {
    barrier = false;
    if (!at_standstill && environment->takes_time()) return Step::standstill;
  }
  if (own && own->before_block(*this, frame) == OwnLanguage::Taken::done) return Step::done;
  if (frame.macro.next != nullptr) return carry_out(*std::exchange(frame.macro.next, nullptr));
  if (reader_of(frame) == nullptr) return Step::done;
  if (frame.macro.displaced) {
    frame.rest = nullptr;
    if (!frame.reader->seek(frame.macro.place.line)) {
      alarm(AlarmReason::input_failed, 0);
      return Step::done;
    }
    frame.macro.displaced = false;
  }
  if (frame.rest == nullptr) {
    switch (frame.reader->next(frame.line)) {
      case program::LineStatus::line:
        break;
      case program::LineStatus::wait:
        return Step::wait;
      case program::LineStatus::end:
        end_of_text(false);
        return Step::done;
      case program::LineStatus::too_long:
        at.line = frame.reader->line_number();
        at.byte_offset = frame.reader->byte_offset();
        alarm(AlarmReason::block_too_long, 1);
        return Step::done;
      case program::LineStatus::failed:
        at.line = frame.reader->line_number();
        alarm(AlarmReason::input_failed, 0);
        return Step::done;
    }
    frame.rest = frame.line.text.data();
    if (frame.macro.place.within != 0) {  // back in the middle of a line
      const auto within = std::min<std::size_t>(frame.macro.place.within, frame.line.text.size());
      frame.macro.place.within = 0;
      frame.rest += within;
    }
  }
  // A language of its own may have labels of its own.
  return frame.wanted_sequence >= 0 && own == nullptr ? search_block() : read_block();
}

Executor::Step Executor::read_block() {
  Frame& frame = frames.back();
  const char* line_begin = frame.line.text.data();
  const char* line_end = nullptr;
  const BlockPlace place{frame.line.place, static_cast<std::uint32_t>(frame.rest - line_begin)};
  at.program = frame.number;
  at.line = frame.line.number;
  at.column = 0;
  at.byte_offset = place.offset();
  if (interruption.enabled && frame.macro.kind != CallKind::interruption) interruption.block = place;
  const program::Line as_read = frame.line;
  if (own && own->take_text(*this, frame) == OwnLanguage::Taken::done) return Step::done;
  if (frame.wanted_sequence >= 0) return search_block();
  line_end = frame.line.text.data() + frame.line.text.size();

  if (frame.macro.code != nullptr && !frame.macro.code->empty()) {
    if (CompiledBlock* known = frame.macro.code->find(at.byte_offset)) {
      frame.rest = known->ends_line ? nullptr : line_begin + known->after.within;
      if (frame.macro.last != nullptr) frame.macro.last->next = known;
      return carry_out(*known);
    }
  }
  if (macros != nullptr && !macros->words.expressions.empty()) macros->words.expressions.clear();
  const program::LexResult read = program::lex_block(frame.line.text, frame.rest, lex_rules, block);
  frame.rest = read.rest == line_end ? nullptr : read.rest;

  if (read.status == program::LexStatus::record_end) {
    if (frame.at_start) {  // the tape mark before the program; its line is the leader
      frame.rest = nullptr;
      return Step::done;
    }
    end_of_text(true);
    return Step::done;
  }
  if (block.has_sequence) {
    at.sequence = block.sequence;
    remember_sequence(block.sequence, place);
  }

  if (block.skip != 0 && (block.skip & switches.block_skip) != 0) {
    frame.rest =
        nullptr;  // to the end of the line: what was typed after EOB on one line is read again with it
    frame.macro.last = nullptr;
    return Step::done;
  }
  if (read.status == program::LexStatus::error) {
    const bool by_macro = read.error == program::LexError::expression && macros != nullptr &&
                          macros->words.fault != AlarmReason::count_;
    alarm(by_macro ? macros->words.fault : reason_of(read.error), read.column);
    return Step::done;
  }
  const bool statement = read.status == program::LexStatus::statement;
  if (statement && (macros == nullptr || !macros->rules.statements)) {
    pipeline.block_read();
    const std::size_t depth = frames.size();
    if (own && own->statement(*this, read.statement, read.column) == OwnLanguage::Taken::done) {
      if (frames.size() >= depth) frames[depth - 1].at_start = false;  // a call has moved `frame` elsewhere
      return Step::done;
    }
    if (dialect.statement == nullptr || !dialect.statement(*this, read.statement, read.column)) {
      alarm(AlarmReason::statement_unavailable, read.column,
            std::string(read.statement.substr(0, read.statement.find_first_of(" [=("))));
    }
    return Step::done;
  }
  if (macros != nullptr && (statement || block.computed_count != 0 || !frame.macro.loops.empty() ||
                            frame.macro.kind != CallKind::main)) {
    CompiledBlock* compiled = keep_block(read, place);
    return compiled == nullptr ? Step::done : carry_out(*compiled);
  }

  if (block.has_number) {
    if (!frame.at_start && block.number != frame.number) {  // the next program of the file begins
      end_of_text(true);
      return Step::done;
    }
    if (frame.at_start) frame.number = at.program = block.number;
  }
  const bool empty = (block.words | block.marked | block.g_count | block.m_count) == 0;
  const bool bare =
      empty && (block.has_number || block.has_sequence);  // O or N alone is a block (0i-D L31468)
  if (restarting && restart_reached(block.has_sequence, block.sequence, !empty || bare)) {
    frame.line = as_read;  // read again by the next pull, by a language of its own too
    frame.rest = line_begin + place.within;
    return Step::done;
  }
  if (data_input_waits()) {
    frame.line = as_read;
    frame.rest = line_begin + place.within;
    return Step::standstill;
  }
  if (!empty || block.has_sequence) frame.at_start = false;
  frame.macro.last = nullptr;
  if (!empty) modal_memory.before_block(*this);
  if (bare && data_input.line == nullptr) ++at.block;
  if (!empty && own && own->take_block(*this) == OwnLanguage::Taken::done) return Step::done;
  run_block(empty, block.has_sequence, block.sequence);
  return Step::done;
}

void Executor::run_block(bool empty, bool has_sequence, std::uint32_t sequence) {
  if (empty && has_sequence && data_input.line != nullptr) empty = false;  // G10 L52: N without R is an alarm
  if (!empty) pipeline.block_read();
  if (cycle.watch != nullptr) {  // a block of a profile
    if (!empty && (!cycle.watch->admit(*this) || !execute())) return;
    if (!finished) cycle.watch->done(*this, has_sequence, sequence);
    return;
  }
  if (!empty) execute();
}

// Only the N word counts, and it must be the first of its block.
Executor::Step Executor::search_block() {
  Frame& frame = frames.back();
  const char* line_begin = frame.line.text.data();
  const BlockPlace place{frame.line.place, static_cast<std::uint32_t>(frame.rest - line_begin)};
  const program::BlockHead head = program::read_head(frame.line.text, frame.rest, lex_rules);
  const auto over = [&] {
    end_of_text(true);
    return Step::done;
  };
  if (head.record_end) {
    if (!frame.at_start) return over();
    frame.rest = nullptr;  // the leader
    return Step::done;
  }
  if (head.has_number) {
    if (!frame.at_start && head.number != frame.number) return over();
    frame.number = head.number;
  }
  const char* line_end = line_begin + frame.line.text.size();
  if (head.has_sequence || head.body < line_end) frame.at_start = false;
  if (frame.macro.search_turned && place.offset() > frame.macro.search_from.offset()) return over();
  if (!head.has_sequence || head.sequence != frame.wanted_sequence) {
    frame.rest = head.rest == line_end ? nullptr : head.rest;
    return Step::done;
  }
  frame.wanted_sequence = -1;
  if (CompiledBlock* from = std::exchange(frame.macro.jump_from, nullptr)) {
    constexpr std::size_t kMostTargets = 64;
    if (from->targets.size() < kMostTargets) from->targets.emplace_back(head.sequence, place);
  }
  leave_loops_around(place.offset());
  return Step::done;  // the block is read by the next step
}

bool Executor::end_of_text(bool record_end) {
  Frame& frame = frames.back();
  at.column = 0;
  if (frame.wanted_sequence >= 0) {
    if (!std::exchange(frame.macro.search_turned, true)) {  // from the jump to the end, then from the head
      frame.macro.displaced = true;
      frame.macro.place = {};
      frame.at_start = true;
      return true;
    }
    const std::string wanted =
        frame.wanted_name.empty() ? std::to_string(frame.wanted_sequence) : frame.wanted_name;
    at = frame.wanted_by;
    return alarm(frame.not_found, at.column, "N" + wanted);
  }
  if (own && !own->end_of_text(*this, frame)) return false;
  if (!record_end) at.line = frame.reader->line_number();
  const bool typed = switches.origin == ProgramOrigin::mdi && frames.size() == 1;  // MDI: over with its last block
  if (!switches.lenient && !typed && dialect.end_of_text == dialects::EndOfText::alarm) {
    return alarm(AlarmReason::end_of_record, 0);
  }
  if (frames.size() > 1) {
    if (dialect.sub_program_needs_return && !switches.lenient) return alarm(AlarmReason::nesting, 0, "M99");
    return return_from_sub(-1, 0);
  }
  return finish(EndReason::end_of_file, false);
}

bool Executor::finish(EndReason reason, bool counts_part) {
  auto& end = emit<End>();
  end.at = at;
  end.reason = reason;
  end.counts_part = counts_part;
  finished = true;
  return true;
}

bool Executor::count_jump() {
  ++jumps;
  if (macros != nullptr && macros->variables.writes != macros->writes_at_jump) {
    macros->writes_at_jump = macros->variables.writes;
    idle_jumps = 0;
  }
  if (++idle_jumps <= kIdleJumps && jumps <= switches.most_jumps) return true;
  return alarm(AlarmReason::endless_loop, 0);
}

bool Executor::begin_search(std::int64_t sequence, std::uint32_t column, AlarmReason not_found) {
  if (!count_jump()) return false;
  Frame& frame = frames.back();
  program::BlockReader* reader = reader_of(frame);
  if (reader == nullptr) return false;
  frame.wanted_by = at;
  frame.wanted_by.column = column;
  frame.not_found = not_found;
  if (!reader->can_seek()) {  // a stream cannot be searched
    return alarm(not_found, column, "N" + std::to_string(sequence));
  }
  frame.wanted_sequence = sequence;
  frame.macro.search_turned = false;
  frame.macro.jump_from = nullptr;
  frame.macro.next = frame.macro.last = nullptr;
  if (own != nullptr) {
    frame.macro.search_turned = frame.macro.displaced = true;
    frame.macro.place = {};
    frame.macro.search_from = {{UINT64_MAX / 2, 1, false, false}, 0};  // all of it
    frame.at_start = true;
  } else if (frame.macro.displaced) {
    frame.macro.search_from = frame.macro.place;
  } else if (frame.rest != nullptr) {
    frame.macro.search_from = {frame.line.place,
                               static_cast<std::uint32_t>(frame.rest - frame.line.text.data())};
  } else {
    frame.macro.search_from = {reader->place(), 0};
  }
  return true;
}

bool Executor::jump_to_sequence(std::int64_t sequence, std::uint32_t column) {
  return begin_search(sequence, column, AlarmReason::sequence_not_found);
}

Frame& Executor::push_program(std::unique_ptr<program::Source> source, std::uint32_t number,
                              std::int64_t times) {
  Frame frame;
  if (source != nullptr) frame.reader = take_reader(std::move(source));
  frame.number = number;
  frame.repeats_left = times - 1;
  frame.macro.kind = frames.empty() ? CallKind::main : CallKind::sub;
  if (macros != nullptr) {
    if (!frames.empty()) {
      frame.macro.locals = frames.back().macro.locals;
      frame.macro.modal_calls = frames.back().macro.modal_calls;
      frame.macro.by_code = frames.back().macro.by_code;
      frame.macro.external = frames.back().macro.external;
    }
    frame.macro.code = std::make_shared<CompiledProgram>();
    const bool first = data.bit(macros->rules.fast_goto_first_parameter);
    const bool recent = data.bit(macros->rules.fast_goto_recent_parameter);
    if (first || recent) frame.macro.passed = std::make_unique<SequenceMemory>(first, recent);
  }
  frames.push_back(std::move(frame));
  return frames.back();
}

void Executor::drop_program() {
  constexpr std::size_t kMostSpare = 8;
  Frame& frame = frames.back();
  if (frame.reader != nullptr && spare_readers.size() < kMostSpare) {
    frame.reader->restart(nullptr);  // the source is closed now
    spare_readers.push_back(std::move(frame.reader));
  }
  frames.pop_back();
  if (macros != nullptr && !frames.empty() && frames.back().macro.locals != nullptr)
    macros->variables.locals = frames.back().macro.locals.get();
}

bool Executor::call(std::unique_ptr<program::Source> source, std::uint32_t number, std::int64_t times,
                    std::uint32_t column) {
  if (source == nullptr) {
    return alarm(AlarmReason::program_not_found, column, number == 0 ? "" : "O" + std::to_string(number));
  }
  if (!nesting_allows(CallKind::sub, column)) return false;
  if (!count_jump()) return false;
  if (times <= 0) return true;
  push_program(std::move(source), number, times);
  return true;
}

bool Executor::begin_again(Frame& frame) {
  MacroFrame& macro = frame.macro;
  macro.loops.clear();
  if (macro.arguments != nullptr) *macro.locals = *macro.arguments;
  frame.rest = nullptr;
  frame.at_start = true;
  macro.last = nullptr;
  macro.next = macro.code != nullptr ? macro.code->find(0) : nullptr;
  macro.displaced = true;
  macro.place = {};
  if (frame.reader != nullptr && !frame.reader->can_seek()) {
    if (!macro.external) return alarm(AlarmReason::input_failed, 0);
    frame.reader.reset();  // the external device is asked for it again
    macro.displaced = false;
  }
  if (macro.start_sequence >= 0)
    return begin_search(macro.start_sequence, 0, AlarmReason::sequence_not_found);
  return true;
}

bool Executor::return_from_sub(std::int64_t to_sequence, std::uint32_t column) {
  Frame& frame = frames.back();
  if (frame.repeats_left > 0) {
    --frame.repeats_left;
    return count_jump() && begin_again(frame);
  }
  const auto interrupted = std::move(frame.macro.interrupted);
  drop_program();
  at.program = frames.back().number;
  if (interrupted != nullptr) end_interruption(*interrupted, to_sequence >= 0);
  if (to_sequence >= 0) return jump_to_sequence(to_sequence, column);
  MacroFrame& caller = frames.back().macro;
  if (std::exchange(caller.returns_after_call, false)) {  // M99 stood beside the move that made the call
    if (frames.size() > 1) return return_from_sub(caller.returns_to, column);
    if (caller.returns_to >= 0) return jump_to_sequence(caller.returns_to, column);
    return finish(EndReason::m99_main, dialect.m99_main_counts_part);
  }
  return true;
}

bool Executor::rewind_main() {
  if (!count_jump()) return false;
  while (frames.size() > 1) drop_program();
  if (!frames.back().reader->can_seek()) return alarm(AlarmReason::sequence_not_found, 0);
  return begin_again(frames.back());
}

}  // namespace headstock::interp

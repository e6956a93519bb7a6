// How blocks follow each other: reading, skipping, calls, jumps, ends.
#include <utility>

#include "interpreter/executor.hpp"

namespace headstock::interp {
namespace {

// Jumps backwards without any motion, dwell, stop or M code between them before the program is called
// endless.
constexpr std::uint64_t kJumpBudget = 100'000;

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
    case LexError::sequence_format:
      return AlarmReason::program_number;
    case LexError::expression:
    case LexError::none:
      break;
  }
  return AlarmReason::expression;
}

}  // namespace

Executor::Step Executor::step() {
  Frame& frame = frames.back();
  if (own && own->before_block(*this, frame) == OwnLanguage::Taken::done) return Step::done;
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
  }
  at.program = frame.number;
  at.line = frame.line.number;
  at.column = 0;
  at.byte_offset = frame.line.byte_offset + static_cast<std::uint64_t>(frame.rest - frame.line.text.data());
  if (own && own->take_text(*this, frame) == OwnLanguage::Taken::done) return Step::done;

  const char* line_end = frame.line.text.data() + frame.line.text.size();
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
  if (frame.wanted_sequence >= 0) {  // searching: only the N word counts
    if (!block.has_sequence || block.sequence != frame.wanted_sequence) return Step::done;
    frame.wanted_sequence = -1;
  }
  if (block.has_sequence) at.sequence = block.sequence;

  if (block.skip != 0 && (block.skip & switches.block_skip) != 0) {
    frame.rest =
        nullptr;  // to the end of the line: what was typed after EOB on one line is read again with it
    return Step::done;
  }
  if (read.status == program::LexStatus::error) {
    alarm(reason_of(read.error), read.column);
    return Step::done;
  }
  if (read.status == program::LexStatus::statement) {
    pipeline.block_read();  // a macro statement counts as a block without movement (0i-D M, K2000TC L19782)
    if (own && own->statement(*this, read.statement, read.column) == OwnLanguage::Taken::done) {
      frame.at_start = false;
      return Step::done;
    }
    if (dialect.statement == nullptr || !dialect.statement(*this, read.statement, read.column)) {
      alarm(AlarmReason::statement_unavailable, read.column,
            std::string(read.statement.substr(0, read.statement.find_first_of(" [=("))));
    }
    return Step::done;
  }

  if (block.has_number) {
    if (!frame.at_start && block.number != frame.number) {  // the next program of the file begins
      end_of_text(true);
      return Step::done;
    }
    if (frame.at_start) frame.number = at.program = block.number;
  }
  const bool empty = (block.words | block.marked | block.g_count | block.m_count) == 0;
  if (!empty || block.has_sequence) frame.at_start = false;
  if (!empty) pipeline.block_read();
  if (!empty && own && own->take_block(*this) == OwnLanguage::Taken::done) return Step::done;
  if (cycle.watch != nullptr) {  // a block of a profile
    const bool has_sequence = block.has_sequence;
    const std::uint32_t sequence = block.sequence;
    if (!empty && (!cycle.watch->admit(*this) || !execute())) return Step::done;
    if (!finished) cycle.watch->done(*this, has_sequence, sequence);
    return Step::done;
  }
  if (!empty) execute();
  return Step::done;
}

bool Executor::end_of_text(bool record_end) {
  Frame& frame = frames.back();
  at.column = 0;
  if (frame.wanted_sequence >= 0) {
    const SourcePosition from = frame.wanted_by;
    const std::string wanted =
        frame.wanted_name.empty() ? std::to_string(frame.wanted_sequence) : frame.wanted_name;
    at = from;
    return alarm(AlarmReason::sequence_not_found, from.column, "N" + wanted);
  }
  if (own && !own->end_of_text(*this, frame)) return false;
  if (!record_end) at.line = frame.reader->line_number();
  if (!switches.lenient && dialect.end_of_text == dialects::EndOfText::alarm) {
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
  if (++jumps <= kJumpBudget) return true;
  return alarm(AlarmReason::endless_loop, 0);
}

bool Executor::jump_to_sequence(std::int64_t sequence, std::uint32_t column) {
  if (!count_jump()) return false;
  Frame& frame = frames.back();
  if (!frame.reader->seek(0, 1)) {  // a stream cannot go back
    return alarm(AlarmReason::sequence_not_found, column, "N" + std::to_string(sequence));
  }
  frame.rest = nullptr;
  frame.at_start = true;
  frame.wanted_sequence = sequence;
  frame.wanted_by = at;
  frame.wanted_by.column = column;
  return true;
}

bool Executor::call(std::unique_ptr<program::Source> source, std::uint32_t number, std::int64_t times,
                    std::uint32_t column) {
  if (source == nullptr) {
    return alarm(AlarmReason::program_not_found, column, number == 0 ? "" : "O" + std::to_string(number));
  }
  if (static_cast<int>(frames.size()) > dialect.calls.nesting) return alarm(AlarmReason::nesting, column);
  if (!count_jump()) return false;
  if (times <= 0) return true;
  Frame frame;
  frame.reader = std::make_unique<program::BlockReader>(std::move(source), dialect.longest_block);
  frame.number = number;
  frame.repeats_left = times - 1;
  frames.push_back(std::move(frame));
  return true;
}

bool Executor::return_from_sub(std::int64_t to_sequence, std::uint32_t column) {
  Frame& frame = frames.back();
  if (frame.repeats_left > 0) {
    --frame.repeats_left;
    if (!count_jump()) return false;
    if (!frame.reader->seek(0, 1)) return alarm(AlarmReason::input_failed, column);
    frame.rest = nullptr;
    frame.at_start = true;
    return true;
  }
  frames.pop_back();
  at.program = frames.back().number;
  if (to_sequence >= 0) return jump_to_sequence(to_sequence, column);
  return true;
}

bool Executor::rewind_main() {
  if (!count_jump()) return false;
  while (frames.size() > 1) frames.pop_back();
  if (!frames.back().reader->seek(0, 1)) return alarm(AlarmReason::sequence_not_found, 0);
  frames.back().rest = nullptr;
  frames.back().at_start = true;
  return true;
}

}  // namespace headstock::interp

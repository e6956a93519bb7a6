// Labels, jumps, calls by name and the block loops G170 and G171 (L4330).
#include "dialects/lathe-200t/language.hpp"

namespace headstock::dialects::lathe_200t {
namespace {

constexpr std::size_t kMostLoops = 4;
constexpr std::int64_t kMostRuns = 65'534;

}  // namespace

std::int64_t label_key(std::string_view label) {
  // A one before the digits keeps N0010 and N10 apart.
  if (label.empty() || label.size() > 17) return -1;
  std::int64_t key = 1;
  for (const char c : label) {
    if (c < '0' || c > '9') return -1;
    key = key * 10 + (c - '0');
  }
  return key;
}

bool Language::jump(Executor& ex, std::string_view label, std::uint32_t column) {
  const std::int64_t key = label_key(label);
  if (key < 0) return ex.alarm(AlarmReason::sequence_not_found, column, "N" + std::string(label));
  level(ex).last_label = -1;
  for (Loop& loop : loops_) {
    if (loop.depth == ex.frames.size()) loop.left_by_jump = true;
  }
  ex.frames.back().wanted_name = label;
  return ex.jump_to_sequence(key, column);
}

bool Language::call_name(Executor& ex, std::string_view name, std::int64_t times, std::uint32_t column) {
  if (times > ex.dialect.calls.most_repeats) return ex.alarm(AlarmReason::call_count, column, "P");
  for (std::size_t i = 1; i < ex.frames.size() && i < levels_.size(); ++i) {  // nobody calls himself (L4577)
    if (levels_[i].name == name) return ex.alarm(AlarmReason::nesting, column, std::string(name));
  }
  auto source = ex.programs == nullptr ? nullptr : ex.programs->open_name(name);
  if (source == nullptr) return ex.alarm(AlarmReason::program_not_found, column, std::string(name));
  if (!ex.call(std::move(source), 0, times, column)) return false;
  if (times > 0) {
    Level& called = level(ex);
    called.name = name;
    called.last_label = -1;
  }
  return true;
}

bool Language::loop(Executor& ex, Frame& frame, const char* at, bool counted) {
  const std::string_view line = frame.line.text;
  const char* const end = line.data() + line.size();
  std::string_view p, q, l;
  Loop wanted;
  while (at < end) {
    if (*at == ' ' || *at == '\t') {
      ++at;
      continue;
    }
    const char letter = static_cast<char>(*at & ~0x20);
    const auto column = static_cast<std::uint32_t>(at - line.data()) + 1;
    std::string_view* into = letter == 'P'              ? &p
                             : letter == 'Q'            ? &q
                             : letter == 'L' && counted ? &l
                                                        : nullptr;
    if (into == nullptr) return ex.alarm(AlarmReason::illegal_address, column, std::string(1, *at));
    if (letter == 'P') wanted.column = column;
    const char* from = ++at;
    while (at < end && *at != ' ' && *at != '\t') ++at;
    *into = {from, static_cast<std::size_t>(at - from)};
  }
  wanted.begin = label_key(p);
  wanted.end = label_key(q);
  if (wanted.begin < 0) return ex.alarm(AlarmReason::sequence_not_found, wanted.column, "N" + std::string(p));
  if (wanted.end < 0) return ex.alarm(AlarmReason::sequence_not_found, wanted.column, "N" + std::string(q));
  wanted.left = -1;
  if (counted) {
    const std::int64_t runs = label_key(l);  // 1 and the digits
    std::int64_t power = 1;
    for (std::size_t i = 0; runs >= 0 && i < l.size(); ++i) power *= 10;
    wanted.left = runs < 0 ? 0 : runs - power;
    if (wanted.left < 1 || wanted.left > kMostRuns)
      return ex.alarm(AlarmReason::data_value, wanted.column, "L" + std::string(l));
  }
  wanted.depth = ex.frames.size();
  wanted.own_label = level(ex).last_label;
  wanted.begin_name = p;
  wanted.end_name = q;
  wanted.code_offset = frame.line.byte_offset;
  wanted.next_offset = frame.reader->byte_offset();
  wanted.next_line = frame.reader->line_number();

  for (std::size_t i = 0; i < loops_.size(); ++i) {  // here again
    if (loops_[i].depth != wanted.depth || loops_[i].code_offset != wanted.code_offset) continue;
    // Without a jump only a Q label that does not exist leads back here: the loop would never end.
    if (!loops_[i].left_by_jump)
      return ex.alarm(AlarmReason::sequence_not_found, wanted.column, "N" + wanted.end_name);
    loops_.resize(i);
    break;
  }
  if (loops_.size() == kMostLoops) return ex.alarm(AlarmReason::nesting, wanted.column, "G170/G171");
  const std::int64_t begin = wanted.begin;
  frame.wanted_name = wanted.begin_name;
  level(ex).last_label = -1;
  const std::uint32_t column = wanted.column;
  loops_.push_back(std::move(wanted));
  return ex.jump_to_sequence(begin, column);
}

// The block labelled Q has been carried out: once more, or on behind the G171 block.
interp::OwnLanguage::Taken Language::before_block(Executor& ex, Frame& frame) {
  while (!loops_.empty() && loops_.back().depth > ex.frames.size()) loops_.pop_back();
  if (loops_.empty() || frame.wanted_sequence >= 0) return Taken::plain;
  Loop& loop = loops_.back();
  Level& here = level(ex);
  if (loop.depth != ex.frames.size() || here.last_label != loop.end) return Taken::plain;
  here.last_label = -1;
  if (loop.left > 0 && --loop.left == 0) {
    const std::uint64_t offset = loop.next_offset;
    const std::uint32_t line = loop.next_line;
    here.last_label = loop.own_label;  // the loop block is done: an outer loop may end with it
    loops_.pop_back();
    if (!frame.reader->seek(offset, line)) {
      ex.alarm(AlarmReason::sequence_not_found, 0);
      return Taken::done;
    }
    frame.rest = nullptr;
    return Taken::done;
  }
  loop.left_by_jump = false;
  frame.wanted_name = loop.begin_name;
  ex.jump_to_sequence(loop.begin, loop.column);
  return Taken::done;
}

}  // namespace headstock::dialects::lathe_200t

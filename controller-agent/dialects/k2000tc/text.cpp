// Blocks of the K2000TC as text: what is read before the lexer, searched, and left out.
#include "dialects/k2000tc/language.hpp"
#include "program/characters.hpp"

namespace headstock::dialects::k2000tc {
namespace {

using program::is_digit;
using program::upper;

// Behind blanks, `/n` and N: where a block's own text begins.
const char* behind_head(const char* at, const char* end, bool& skipped, std::uint32_t skip_switches) {
  for (;;) {
    while (at < end && (*at == ' ' || *at == '\t')) ++at;
    if (at < end && *at == '/') {
      ++at;
      std::uint32_t which = 1;
      if (at < end && is_digit(*at)) which = static_cast<std::uint32_t>(*at++ - '0');
      skipped = skipped || (skip_switches >> which & 1u) != 0;
    } else if (at + 1 < end && upper(*at) == 'N' && is_digit(at[1])) {
      ++at;
      while (at < end && is_digit(*at)) ++at;
    } else {
      return at;
    }
  }
}

// The end of the block that begins at `at`: `;` outside strings and comments, or the line's end.
const char* block_end(const char* at, const char* end) {
  bool in_string = false, in_comment = false;
  for (; at < end; ++at) {
    if (*at == '"') in_string = !in_string;
    if (in_string) continue;
    if (*at == '(') in_comment = true;
    if (*at == ')') in_comment = false;
    if (*at == ';' && !in_comment) break;
  }
  return at;
}

// CT AD AC DC (L5690): acceleration of the move. The machine's own limits stay in force, so they are read and
// left.
std::size_t acceleration_word(std::string_view text, std::size_t from) {
  for (std::size_t i = from; i + 2 < text.size(); ++i) {
    const char a = upper(text[i]), b = upper(text[i + 1]);
    const bool pair =
        (a == 'C' && b == 'T') || (a == 'A' && (b == 'D' || b == 'C')) || (a == 'D' && b == 'C');
    const bool number = is_digit(text[i + 2]) || text[i + 2] == '.';
    const bool word = i == 0 || upper(text[i - 1]) < 'A' || upper(text[i - 1]) > 'Z';
    if (pair && number && word) return i;
  }
  return std::string_view::npos;
}

// Signals, positions, clocks, and numbers that are only known when they are worked out; M91…M94.
bool looks_at_machine(const Frame& frame) {
  const char* end = frame.line.text.data() + frame.line.text.size();
  for (const char* at = frame.rest; at + 1 < end; ++at) {
    const char c = upper(*at);
    if (c == 'M' && end - at > 2 && at[1] == '9' && at[2] >= '1' && at[2] <= '4') return true;
    if (c != '#') continue;
    int digits = 0;
    while (at + 1 + digits < end && is_digit(at[1 + digits])) ++digits;
    if (digits == 0 || digits == 4) return true;
  }
  return false;
}

bool has_acceleration_words(std::string_view text) {
  return acceleration_word(text, 0) != std::string_view::npos &&
         text.find_first_of("\"(") == std::string_view::npos;
}

void blank_acceleration_words(std::string& text) {
  for (std::size_t i = acceleration_word(text, 0); i != std::string_view::npos;
       i = acceleration_word(text, i)) {
    text[i] = text[i + 1] = ' ';
    for (i += 2; i < text.size() && (is_digit(text[i]) || text[i] == '.'); ++i) text[i] = ' ';
  }
}

}  // namespace

// WHILE was false: every block is only looked at for its END.
interp::OwnLanguage::Taken Language::skip_block(Executor& ex, Frame& frame) {
  Level& here = level(ex);
  const char* end = frame.line.text.data() + frame.line.text.size();
  const char* stop = block_end(frame.rest, end);
  bool skipped = false;
  const char* at = behind_head(frame.rest, stop, skipped, 0);
  k2000::Parser parser({at, static_cast<std::size_t>(stop - at)}, *this, options_);
  Value label;
  if (parser.take("END") && parser.expression(label) && label.integer() == here.skip_to_end)
    here.skip_to_end = -1;
  frame.rest = stop == end ? nullptr : stop + 1;
  return Taken::done;
}

// A jump looks for its N: nothing else of a block counts.
interp::OwnLanguage::Taken Language::search_block(Executor& ex, Frame& frame) {
  const char* end = frame.line.text.data() + frame.line.text.size();
  const char* stop = block_end(frame.rest, end);
  std::int64_t sequence = -1, number = -1;
  const char* at = frame.rest;
  for (;;) {
    while (at < stop && (*at == ' ' || *at == '\t')) ++at;
    if (at == stop) break;
    if (*at == '%') return Taken::plain;
    const char letter = *at == ':' ? 'O' : upper(*at);
    if (letter == '/') {
      ++at;
      if (at < stop && is_digit(*at)) ++at;
      continue;
    }
    if ((letter != 'N' && letter != 'O') || at + 1 == stop || !is_digit(at[1])) break;
    std::int64_t value = 0;
    for (++at; at < stop && is_digit(*at); ++at)
      value = value > 99'999'999 ? value : value * 10 + (*at - '0');
    (letter == 'N' ? sequence : number) = value;
  }
  if (number >= 0) {
    if (!frame.at_start && number != static_cast<std::int64_t>(frame.number)) {  // the file's next program
      ex.end_of_text(true);
      return Taken::done;
    }
    frame.number = static_cast<std::uint32_t>(number);
  }
  if (at < stop || sequence >= 0) frame.at_start = false;
  if (sequence == frame.wanted_sequence) {
    frame.wanted_sequence = -1;
    return Taken::plain;
  }
  frame.rest = stop == end ? nullptr : stop + 1;
  return Taken::done;
}

interp::OwnLanguage::Taken Language::take_text(Executor& ex, Frame& frame) {
  Level& here = level(ex);
  const bool new_line = frame.rest == frame.line.text.data() && frame.rest != here.text.data();
  if (new_line && (other_brackets_ || has_acceleration_words(frame.line.text))) {
    here.text.assign(frame.line.text);
    if (other_brackets_) k2000::rewrite(here.text);
    blank_acceleration_words(here.text);
    frame.line.text = here.text;
    frame.rest = here.text.data();
  }
  if (ex.environment->takes_time() && !ex.at_standstill && frame.wanted_sequence < 0 && here.skip_to_end < 0 &&
      looks_at_machine(frame)) {  // read when it is true
    ex.hold_look_ahead();
    return Taken::done;
  }
  if (frame.wanted_sequence >= 0 && search_block(ex, frame) == Taken::done) return Taken::done;
  if (frame.wanted_sequence >= 0) return Taken::plain;  // the end of the text
  if (here.skip_to_end >= 0) return skip_block(ex, frame);

  // `r1 = 5`: the lexer would take it for the word R1.
  const char* end = frame.line.text.data() + frame.line.text.size();
  bool skipped = false;
  const char* at = behind_head(frame.rest, end, skipped, ex.switches.block_skip);
  if (skipped || at + 1 >= end || upper(*at) != 'R' || !is_digit(at[1])) return Taken::plain;
  const char* behind = at + 1;
  while (behind < end && is_digit(*behind)) ++behind;
  while (behind < end && *behind == ' ') ++behind;
  if (behind == end || std::string_view("=+-*/&^|<>[{").find(*behind) == std::string_view::npos)
    return Taken::plain;
  const char* stop = block_end(at, end);
  frame.rest = stop == end ? nullptr : stop + 1;
  frame.at_start = false;
  return statement(ex, {at, static_cast<std::size_t>(stop - at)},
                   static_cast<std::uint32_t>(at - frame.line.text.data()) + 1);
}

bool Language::end_of_text(Executor& ex, Frame&) {
  Level& here = level(ex);
  if (here.skip_to_end < 0) return true;
  ex.at = here.skip_from;
  return raise(ex, "PS9006", here.skip_from.column, "END " + std::to_string(here.skip_to_end));
}

}  // namespace headstock::dialects::k2000tc

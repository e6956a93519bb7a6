// Statements: assignment, IF, GOTO, WHILE, END, output, SETVN.
#include "macro/parser.hpp"

namespace headstock::macro {
namespace {

// A closing bracket too many, or anything else behind a finished statement.
bool at_end(Parser& parser, Fault otherwise = Fault::macro_expression) {
  if (parser.ended()) return true;
  if (parser.peek() == 'O' || parser.peek() == 'N') return parser.fail(Fault::number_place);
  return parser.fail(parser.peek() == ']' ? Fault::macro_open_bracket : otherwise);
}

bool assignment(Parser& parser, Statement& out) {
  out.kind = StatementKind::assign;
  if (!parser.place(out.place)) return false;
  if (!parser.take('=')) return parser.fail(Fault::macro_equals);
  if (!parser.expression(out.value)) return false;
  if (!at_end(parser)) return false;
  out.comment = parser.comment();
  return true;
}

bool go_to(Parser& parser, Statement& out) {
  out.kind = StatementKind::go_to;
  return parser.operand(out.value) && at_end(parser);
}

bool bracketed_condition(Parser& parser, Statement& out, Fault form) {
  if (!parser.take('[')) return parser.fail(form);
  if (!parser.condition(out.condition)) return false;
  if (!parser.take(']')) return parser.fail(Fault::macro_close_bracket);
  if (!parser.compared()) return parser.fail(form);
  out.conditional = true;
  return true;
}

bool loop_number(Parser& parser, Statement& out, const Rules& rules) {
  if (!parser.whole(out.number, 9'999'999) || out.number < 1 ||
      out.number > static_cast<std::uint32_t>(rules.most_loops)) {
    return parser.fail(Fault::macro_loop_number);
  }
  return at_end(parser);
}

bool printable(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string_view("*/+-?@&_.,=").find(c) != std::string_view::npos;
}

// DPRNT[ a #b[cd] … ], BPRNT[ a #b[c] … ].
bool print(Parser& parser, Statement& out, bool text) {
  out.kind = text ? StatementKind::print_text : StatementKind::print_words;
  if (!parser.take('[')) return parser.fail(Fault::macro_print_form);
  out.items.emplace_back();
  for (;;) {
    const char c = parser.peek();
    if (c == ']') break;
    if (c == '#') {
      PrintItem& item = out.items.back();
      item.has_value = true;
      std::uint32_t format = 0;
      if (!parser.operand(item.value)) return false;
      if (!parser.take('[') || !parser.whole(format, 99) || !parser.take(']'))
        return parser.fail(Fault::macro_print_form);
      item.whole_digits = static_cast<std::uint8_t>(text ? format / 10 : 9);
      item.decimals = static_cast<std::uint8_t>(text ? format % 10 : format);
      if ((text && (item.whole_digits + item.decimals > 9 || format == 0)) || item.decimals > 9)
        return parser.fail(Fault::macro_print_form);
      out.items.emplace_back();
    } else if (printable(c)) {
      out.items.back().text += c == '*' ? ' ' : c;
      parser.take(c);
    } else {
      return parser.fail(Fault::macro_print_form);
    }
  }
  parser.take(']');
  return at_end(parser);
}

// SETVN n[NAME,…].
bool set_names(Parser& parser, Statement& out) {
  out.kind = StatementKind::set_names;
  if (!parser.whole(out.number, 99'999) || !parser.take('[')) return parser.fail(Fault::macro_names_form);
  for (;;) {
    std::string name;
    for (char c = parser.peek(); c != ',' && c != ']'; c = parser.peek()) {
      if (c == '\0') return parser.fail(Fault::macro_names_form);
      if (c == '[' || c == ')' || c == ':' || c == '#' || c == '=')
        return parser.fail(Fault::macro_name_character);
      name += c;
      if (name.size() > 8) return parser.fail(Fault::macro_set_name_long);
      parser.take(c);
    }
    if (name.empty() || name[0] < 'A' || name[0] > 'Z') return parser.fail(Fault::macro_name_character);
    out.names.push_back(std::move(name));
    if (parser.take(']')) return at_end(parser);
    parser.take(',');
  }
}

bool statement(Parser& parser, const Rules& rules, Statement& out) {
  if (parser.take_word("IF")) {
    if (!bracketed_condition(parser, out, Fault::macro_if_form)) return false;
    if (parser.take_word("THEN")) {
      if (parser.peek() != '#' && parser.peek() != '[') return parser.fail(Fault::macro_if_form);
      return assignment(parser, out);
    }
    if (parser.take_word("GOTO")) return go_to(parser, out);
    return parser.fail(Fault::macro_if_form);
  }
  if (parser.take_word("WHILE")) {
    out.kind = StatementKind::while_do;
    if (!bracketed_condition(parser, out, Fault::macro_while_form)) return false;
    if (!parser.take_word("DO")) return parser.fail(Fault::macro_while_form);
    return loop_number(parser, out, rules);
  }
  if (parser.take_word("DO")) {
    out.kind = StatementKind::while_do;
    return loop_number(parser, out, rules);
  }
  if (parser.take_word("END")) {
    out.kind = StatementKind::end;
    return loop_number(parser, out, rules);
  }
  if (parser.take_word("GOTO")) return go_to(parser, out);
  if (rules.printing && parser.take_word("DPRNT")) return print(parser, out, true);
  if (rules.printing && parser.take_word("BPRNT")) return print(parser, out, false);
  if (rules.printing && parser.take_word("POPEN")) {
    out.kind = StatementKind::open;
    return at_end(parser, Fault::macro_syntax);
  }
  if (rules.printing && parser.take_word("PCLOS")) {
    out.kind = StatementKind::close;
    return at_end(parser, Fault::macro_syntax);
  }
  if (rules.names && parser.take_word("SETVN")) return set_names(parser, out);
  if (parser.peek() == '#' || parser.peek() == '[') return assignment(parser, out);
  const char c = parser.peek();
  return parser.fail(c >= 'A' && c <= 'Z' ? Fault::macro_word_unknown : Fault::macro_syntax);
}

}  // namespace

TextFault compile_statement(std::string_view text, const Rules& rules, bool lathe, Statement& out) {
  Parser parser(text.data(), text.data() + text.size(), rules, lathe);
  statement(parser, rules, out);
  return parser.fault();
}

int loop_mark(std::string_view text) {
  static const Rules wide = [] {
    Rules rules;
    rules.names = true;
    rules.most_loops = 9'999;
    return rules;
  }();
  Parser parser(text.data(), text.data() + text.size(), wide, false);
  Statement found;
  const std::string_view word = parser.word();
  if (!word.starts_with("WHILE") && !word.starts_with("DO") && !word.starts_with("END")) return 0;
  if (!statement(parser, wide, found)) return 0;
  return found.kind == StatementKind::end ? -static_cast<int>(found.number) : static_cast<int>(found.number);
}

}  // namespace headstock::macro

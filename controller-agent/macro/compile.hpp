// Text to compiled expressions and statements. Compiling needs no values: a statement is compiled once and
// carried out as often as it is reached.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "macro/expression.hpp"
#include "macro/rules.hpp"

namespace headstock::macro {

/// What is wrong with the text, and where.
struct TextFault {
  Fault reason = Fault::count_;
  const char* at = nullptr;
  explicit operator bool() const { return reason != Fault::count_; }
};

/// A piece of a DPRNT or BPRNT: characters, then perhaps a variable.
struct PrintItem {
  std::string text;
  bool has_value = false;
  Expression value;
  std::uint8_t whole_digits = 0;  ///< DPRNT
  std::uint8_t decimals = 0;
};

enum class StatementKind : std::uint8_t {
  assign,
  go_to,
  while_do,    ///< WHILE[…]DO m; without a condition: DO m
  end,         ///< END m
  print_text,  ///< DPRNT
  print_words,  ///< BPRNT
  open,        ///< POPEN
  close,       ///< PCLOS
  set_names    ///< SETVN
};

struct Statement {
  StatementKind kind = StatementKind::assign;
  bool conditional = false;   ///< IF[…] before it, or the WHILE's
  Expression condition;
  Place place;                ///< assign
  Expression value;           ///< assign: what; go_to: where
  std::uint32_t number = 0;   ///< DO/END: m; set_names: the first variable
  std::string comment;        ///< of #3000=n(…) and #3006=1(…)
  std::vector<PrintItem> items;
  std::vector<std::string> names;
};

/// @param lathe which series' system names [#_…] exist.
TextFault compile_statement(std::string_view text, const Rules& rules, bool lathe, Statement& out);

/// The expression behind an address: `#…`, `[…]`, with a minus sign or without. `at` is left behind it.
TextFault compile_word(const char*& at, const char* end, const Rules& rules, bool lathe, Expression& out);

/// `DO m` or `END m` in a statement's text without compiling it all: for finding a loop's end.
/// @return 0: neither; m: DO m; −m: END m.
int loop_mark(std::string_view text);

}  // namespace headstock::macro

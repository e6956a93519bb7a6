// Recursive descent over the text of one statement or one address' expression. Inside of the compiler.
#pragma once

#include <cstdint>
#include <string_view>

#include "macro/compile.hpp"

namespace headstock::macro {

class Parser {
 public:
  Parser(const char* at, const char* end, const Rules& rules, bool lathe)
      : at_(at), end_(end), rules_(rules), lathe_(lathe) {}

  const char* at() const { return at_; }
  const TextFault& fault() const { return fault_; }
  bool fail(Fault reason) { return fail(reason, at_); }
  bool fail(Fault reason, const char* where) {
    if (!fault_) fault_ = {reason, where};
    return false;
  }

  /// Next character that means something, '\0' at the end. Blanks and comments are passed over.
  char peek();
  bool take(char wanted);
  bool ended() { return peek() == '\0'; }
  /// The word (letters) that stands here, upper case, without taking it; at most 8 letters.
  std::string_view word();
  /// Takes a reserved word when it stands here.
  bool take_word(std::string_view wanted);

  bool expression(Expression& out);
  /// `a EQ b`, `[…]AND[…]` …: an expression in which comparisons may stand.
  bool condition(Expression& out);
  /// An operand: number, variable, function, bracket.
  bool operand(Expression& out);
  bool place(Place& out);
  bool number(double& out);
  bool whole(std::uint32_t& out, std::uint32_t most);

  std::string_view comment() const { return comment_; }
  bool compared() const { return compared_; }

 private:
  struct Nest;
  bool comparison(Expression& out);
  bool sum(Expression& out);
  bool product(Expression& out);
  bool function(Expression& out);
  bool bracketed(Expression& out);
  bool system_or_named(Expression& out, Instruction& how, std::string& name);
  bool emit(Expression& out, const Instruction& instruction, int change);
  bool binary(Expression& out, Op op) { return emit(out, Instruction{.op = op}, -1); }
  bool open_bracket();

  const char* at_;
  const char* end_;
  const Rules& rules_;
  bool lathe_;
  TextFault fault_;
  std::string_view comment_;
  char word_[9] = {};
  unsigned depth_ = 0;       // brackets
  unsigned signs_ = 0;
  int stack_ = 0;
  bool comparing_ = false;   // comparisons may stand here
  bool compared_ = false;
};

}  // namespace headstock::macro

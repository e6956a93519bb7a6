// K2000TC macro expressions (chapter 16): read and worked out in one go, character by character. The text is
// in the form of COMP=1: `[` `]` are brackets and index, and `{` `}` stand for the arrays of COMP=0 (see
// rewrite).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "macro/k2000-language/value.hpp"

namespace headstock::k2000 {

/// Where variables live. Numbers 0…63 are the locals of the call level in force.
class Variables {
 public:
  virtual ~Variables() = default;
  /// @return none, no_variable or later. NULL is a value.
  virtual Error read(std::uint32_t number, Value& value) = 0;
  virtual Error write(std::uint32_t number, const Value& value) = 0;
};

inline constexpr std::uint32_t kLocals = 64;

struct Options {
  bool degrees = true;        ///< DEG, P4100.6
  bool signed_atan = false;   ///< NAT, P4100.0: ATAN[]/[] −180…180 instead of 0…360
  bool zero_is_null = false;  ///< ZVRBN, P4100.1: #0 means NULL
};

/// A variable, or a row of them, that a statement names: `#1`, `#100[#1]`, `r5{2}`.
struct Place {
  std::uint32_t number = 0;
  std::uint32_t count = 0;  ///< of an array; 0: a single variable
};

class Parser {
 public:
  Parser(std::string_view text, Variables& variables, const Options& options)
      : begin_(text.data()),
        at_(text.data()),
        end_(text.data() + text.size()),
        variables_(variables),
        options_(options) {}

  /// A whole expression. @return false after an error.
  bool expression(Value& value);
  /// What stands behind an address: `#1`, `-#1`, `[…]`, `#100[…]`.
  bool behind_address(Value& value);
  /// A bracket as conditions and arguments have it.
  bool bracket(Value& value);
  /// NULL, or an expression whose value may be NULL when it is a variable alone. For assignments and
  /// arguments.
  bool value_or_null(Value& value);
  /// `#…` or `r…`. @return false and no error when there is none here.
  bool place(Place& place);
  bool is_place();

  /// Takes `text` when it comes next (letters: any case, not followed by a letter).
  bool take(std::string_view text);
  bool take(char c);
  char peek();
  bool at_end() { return peek() == '\0'; }
  /// `"…"`. @return false and no error when there is none here.
  bool string(std::string& text);
  bool fail(Error error);

  Error error() const { return error_; }
  const char* position() const { return at_; }
  void skip_rest() { at_ = end_; }
  void set_position(const char* at) { at_ = at; }
  std::size_t offset() const { return static_cast<std::size_t>(at_ - begin_); }
  Variables& variables() { return variables_; }

 private:
  void skip_blanks();
  bool binary(int level, Value& value);
  bool next_operator(int level, Operator& op);
  bool unary(Value& value);
  bool cast(Value& value, bool& was_cast);
  bool primary(Value& value);
  bool constant(Value& value);
  bool named(Value& value);
  bool function(std::string_view name, bool single, Value& value);
  bool arguments(std::vector<Value>& values, std::size_t most);
  bool read(std::uint32_t number, Value& value);

  const char* begin_;
  const char* at_;
  const char* end_;
  Variables& variables_;
  const Options& options_;
  Error error_ = Error::none;
  bool empty_read_ = false;  // a variable that was read had no value
  int depth_ = 0;
};

/// A value as MSG and WRITE print it.
std::string text_of(const Value& value);

/// Text of COMP=0 in the form of COMP=1: `(` `)` become `[` `]`, `[` `]` become `{` `}`, `//` and `/* */`
/// become blanks. Places stay.
void rewrite(std::string& text);

}  // namespace headstock::k2000

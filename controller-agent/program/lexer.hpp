// Characters to words: one block of a line, without allocation. Knows number syntax and comments, not what
// words mean.
#pragma once

#include <cstdint>
#include <string_view>

#include "program/block.hpp"

namespace headstock::program {

/// What is wrong with the text of a block. The dialect has a number for each.
enum class LexError : std::uint8_t {
  none,
  no_address,         ///< a number without a letter before it
  no_data,            ///< a letter without a number behind it
  illegal_minus,      ///< a sign inside a number, or two
  illegal_point,      ///< two points
  too_many_digits,    ///< more digits than the control reads
  illegal_character,  ///< a character that no program may have outside a comment
  too_many_codes,     ///< more G or M codes than a block can hold
  too_many_words,     ///< more repeated or computed words than a block can hold
  computed_number,    ///< O#1, N[#1]: not allowed
  mixed_statement,    ///< a macro statement behind words
  sequence_format,    ///< N or O with a sign, a point or too many digits
  expression          ///< the macro expression behind an address is wrong
};

/// Takes a macro expression behind an address: `#100`, `[#1+2]`, `-#5`. Absent in a dialect without macros.
/// Either it compiles and the value is asked for when the block is carried out, or it gives the value at
/// once.
class ExpressionReader {
 public:
  virtual ~ExpressionReader() = default;
  virtual bool compiles() const { return false; }
  /// @param at first character of the expression; left behind its last one.
  /// @param expression its number, for Block::computed.
  virtual LexError compile(const char*& /*at*/, const char* /*end*/, std::uint16_t& /*expression*/) {
    return LexError::expression;
  }
  /// @param is_null the expression is a variable without a value: the word counts as not written.
  virtual LexError read(const char*& /*at*/, const char* /*end*/, double& /*value*/, bool& /*is_null*/) {
    return LexError::expression;
  }
};

struct LexRules {
  bool semicolon_is_comment = false;  ///< `;` starts a comment (field files) instead of ending the block
  std::uint8_t most_digits = 9;       ///< in one word, leading zeros counted; at most 17
  std::uint32_t comma_letters = 0;    ///< letters that may stand behind a comma (`,C` `,R` `,A`)
  std::uint32_t named_letters = 0;    ///< letters that N may mark in the same way (`NC` `NR` `NA`)
  ExpressionReader* expressions = nullptr;
};

enum class LexStatus : std::uint8_t {
  block,       ///< a block (perhaps an empty one)
  statement,   ///< a macro statement: starts with `#`, or two letters stand together (IF, WHILE, GOTO, DPRNT
               ///< …)
  record_end,  ///< `%`
  error
};

struct LexResult {
  LexStatus status = LexStatus::block;
  LexError error = LexError::none;
  std::uint32_t column = 0;  ///< of the error or the statement, 1-based
  const char* rest =
      nullptr;  ///< where the next block of this line begins; the line's end when there is none
  std::string_view statement;  ///< text of the macro statement
};

/// Reads one block.
/// @param at where to begin inside `line`; block numbers and columns refer to the line.
LexResult lex_block(std::string_view line, const char* at, const LexRules& rules, Block& out);

/// What a search looks at: the head of a block and where it ends.
struct BlockHead {
  bool record_end = false;
  bool has_sequence = false, has_number = false;
  std::uint32_t sequence = 0, number = 0, skip = 0;
  const char* body = nullptr;  ///< first character behind the head
  const char* rest = nullptr;  ///< as LexResult::rest
};
BlockHead read_head(std::string_view line, const char* at, const LexRules& rules);

}  // namespace headstock::program

#include "program/lexer.hpp"

#include <gtest/gtest.h>

#include <string>

namespace headstock::program {
namespace {

struct Lexed {
  LexResult result;
  Block block;
};

Lexed lex(std::string_view line, LexRules rules = {}) {
  Lexed lexed;
  lexed.result = lex_block(line, line.data(), rules, lexed.block);
  return lexed;
}

TEST(Lexer, WordsWithTheirColumns) {
  const Lexed l = lex("N10 G01X-12.5 Y.25Z+3. F0100;");
  ASSERT_EQ(l.result.status, LexStatus::block);
  EXPECT_TRUE(l.block.has_sequence);
  EXPECT_EQ(l.block.sequence, 10u);
  ASSERT_EQ(l.block.g_count, 1);
  EXPECT_EQ(l.block.g[0].tenths, 10);
  EXPECT_EQ(l.block.g[0].column, 5u);
  EXPECT_EQ(l.block.words, letters("XYZF"));
  EXPECT_EQ(l.block['X'].nano(), -12'500'000'000);
  EXPECT_EQ(l.block['X'].column, 8u);
  EXPECT_EQ(l.block['Y'].nano(), 250'000'000);
  EXPECT_EQ(l.block['Z'].nano(), 3'000'000'000);
  EXPECT_EQ(l.block['F'].integer(), 100);
  EXPECT_EQ(l.block.negative, letters("X"));
  EXPECT_EQ(l.block.pointed, letters("XYZ"));
}

TEST(Lexer, DecimalsAreExact) {
  EXPECT_EQ(lex("X0.1").block['X'].nano(), 100'000'000);
  EXPECT_EQ(lex("X0.00000001").block['X'].digit_count, 9);
  EXPECT_EQ(lex("X1.0005").block['X'].value(), 1.0005);
  LexRules generous;
  generous.most_digits = 17;
  EXPECT_EQ(lex("X0.0000000019", generous).block['X'].nano(), 1);  // below nano is cut
}

TEST(Lexer, TooManyDigits) {
  EXPECT_EQ(lex("X123456789").result.status, LexStatus::block);
  const Lexed l = lex("G1 X0.123456789");
  EXPECT_EQ(l.result.status, LexStatus::error);
  EXPECT_EQ(l.result.error, LexError::too_many_digits);
  EXPECT_EQ(l.result.column, 4u);
}

struct Wrong {
  std::string_view text;
  LexError error;
  std::uint32_t column;
};
class LexerErrors : public testing::TestWithParam<Wrong> {};
// A number that its exact form cannot hold must not come out as another one.
TEST(Lexer, MoreThanNineDigitsBeforeThePointAreRefusedHoweverManyAreAllowed) {
  LexRules rules;
  rules.most_digits = 17;
  Block block;
  const std::string_view text = "X36666666666.5";
  EXPECT_EQ(lex_block(text, text.data(), rules, block).error, LexError::too_many_digits);
}

TEST_P(LexerErrors, HaveTheirColumn) {
  const Lexed l = lex(GetParam().text);
  EXPECT_EQ(l.result.status, LexStatus::error);
  EXPECT_EQ(l.result.error, GetParam().error);
  EXPECT_EQ(l.result.column, GetParam().column);
}
INSTANTIATE_TEST_SUITE_P(
    Text, LexerErrors,
    testing::Values(Wrong{"G1 10.5", LexError::no_address, 4}, Wrong{"X", LexError::no_data, 1},
                    Wrong{"G1 X Y1", LexError::no_data, 4}, Wrong{"X1.2.3", LexError::illegal_point, 1},
                    Wrong{"X1-2", LexError::illegal_minus, 1}, Wrong{"X--2", LexError::no_data, 1},
                    Wrong{"G1 $X1", LexError::illegal_character, 4},
                    Wrong{"G1 \xd5", LexError::illegal_character, 4},
                    Wrong{"N-5", LexError::sequence_format, 1}, Wrong{"X#1", LexError::expression, 1},
                    Wrong{"M-3", LexError::illegal_minus, 1}));

TEST(Lexer, CommentsInAnyEncoding) {
  EXPECT_EQ(lex("G1 (\xe4\xb8\xad\xe6\x96\x87 UTF-8) X1").block['X'].integer(), 1);
  EXPECT_EQ(lex("G1 (\xd6\xd0\xce\xc4 GBK) X1").block['X'].integer(), 1);
  EXPECT_EQ(lex("X1 (never closed Y2").block.words, letters("X"));
  EXPECT_EQ(lex("X1) Y2").block.words, letters("XY"));
  EXPECT_EQ(lex("X1 (a;b) Y2").block.words, letters("XY"));
}

TEST(Lexer, SemicolonEndsTheBlockOrStartsAComment) {
  const std::string line = "G1 X1; X2 ;";
  Block block;
  LexRules rules;
  LexResult first = lex_block(line, line.data(), rules, block);
  EXPECT_EQ(block['X'].integer(), 1);
  ASSERT_NE(first.rest, line.data() + line.size());
  lex_block(line, first.rest, rules, block);
  EXPECT_EQ(block['X'].integer(), 2);
  EXPECT_EQ(block['X'].column, 8u);
  rules.semicolon_is_comment = true;
  first = lex_block(line, line.data(), rules, block);
  EXPECT_EQ(first.rest, line.data() + line.size());
  EXPECT_EQ(block['X'].integer(), 1);
}

TEST(Lexer, BlankTapeIsSkipped) {
  const std::string line(
      "\0\0G1 \x7f"
      "X\t5\0",
      9);
  EXPECT_EQ(lex(line).block['X'].integer(), 5);
}

TEST(Lexer, BlockSkip) {
  EXPECT_EQ(lex("/ N1 X1").block.skip, 1u << 1);
  EXPECT_EQ(lex("/1 /3 N1 X1").block.skip, (1u << 1) | (1u << 3));
  EXPECT_EQ(lex("//3 X1").result.error, LexError::illegal_character);
  const Lexed inner = lex("X1 /2 Y2");
  EXPECT_EQ(inner.block.skip, 0u);
  EXPECT_EQ(inner.block.inner_slash, 4u);
}

TEST(Lexer, CodesWithTenths) {
  const Lexed l = lex("G54.1 G5.11 M03");
  EXPECT_EQ(l.block.g[0].tenths, 541);
  EXPECT_EQ(l.block.g[1].tenths, -1);  // hundredths belong to no control
  EXPECT_EQ(l.block.m[0].tenths, 30);
}

TEST(Lexer, RepeatedWordsAreMarkedAndTheLastOneStays) {
  const Lexed l = lex("X1 X-2");
  EXPECT_EQ(l.block.repeated, letters("X"));
  EXPECT_EQ(l.block['X'].integer(), -2);
  EXPECT_EQ(l.block.negative, letters("X"));
}

TEST(Lexer, StatementsAndTapeMarks) {
  EXPECT_EQ(lex("#100 = 5").result.status, LexStatus::statement);
  const Lexed l = lex("N5 IF [#1 EQ 2] GOTO 10");
  EXPECT_EQ(l.result.status, LexStatus::statement);
  EXPECT_EQ(l.result.column, 4u);
  EXPECT_TRUE(l.block.has_sequence);
  EXPECT_EQ(lex("%").result.status, LexStatus::record_end);
  EXPECT_EQ(lex(":1234").block.number, 1234u);
}

TEST(Lexer, MarkedWordsStandBesideTheirLetters) {
  LexRules rules;
  rules.comma_letters = letters("ACR");
  rules.named_letters = letters("CR");
  const Lexed l = lex("X10. C5. ,C2.5 NR-3", rules);
  ASSERT_EQ(l.result.status, LexStatus::block);
  EXPECT_EQ(l.block.words, letters("XC"));
  EXPECT_EQ(l.block.marked, letters("CR"));
  EXPECT_EQ(l.block['C'].nano(), 5'000'000'000);
  EXPECT_EQ(l.block.marked_at('C').nano(), 2'500'000'000);
  EXPECT_EQ(l.block.marked_at('C').column, 10u);
  EXPECT_EQ(l.block.marked_at('R').digits, -3);
  EXPECT_FALSE(l.block.has_sequence);
  EXPECT_EQ(lex("X10. ,B1", rules).result.error, LexError::illegal_character);
  EXPECT_EQ(lex("X10. NA1", rules).result.status, LexStatus::statement);
  EXPECT_EQ(lex("X10. ,C").result.error, LexError::illegal_character);
}

}  // namespace
}  // namespace headstock::program

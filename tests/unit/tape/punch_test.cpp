#include "protocol/tape/punch.hpp"

#include <gtest/gtest.h>

namespace headstock::tape {
namespace {

std::vector<PunchedPiece> split(std::string_view text, bool* closed = nullptr) {
  PunchSplitter splitter;
  splitter.put(text);
  splitter.finish();
  if (closed != nullptr) *closed = splitter.closed();
  return splitter.pieces();
}

PunchKind kind_of(std::string_view text) {
  const auto pieces = split(text);
  EXPECT_EQ(pieces.size(), 1u) << text;
  return pieces.empty() ? PunchKind::unknown : pieces[0].kind;
}

TEST(Punch, SplitsSeveralPrograms) {
  const std::string text = "%\nO0001(BOLT M8)\nG0\nM30\nO0012\nM99\n:77(NUT)\nM30\n%\n";
  bool closed = false;
  const auto pieces = split(text, &closed);
  EXPECT_TRUE(closed);
  ASSERT_EQ(pieces.size(), 3u);
  EXPECT_EQ(text.substr(pieces[0].begin, pieces[0].end - pieces[0].begin), "O0001(BOLT M8)\nG0\nM30\n");
  EXPECT_EQ(text.substr(pieces[1].begin, pieces[1].end - pieces[1].begin), "O0012\nM99\n");
  EXPECT_EQ(text.substr(pieces[2].begin, pieces[2].end - pieces[2].begin), ":77(NUT)\nM30\n");
  EXPECT_EQ(pieces[0].comment, "BOLT M8");
  EXPECT_EQ(punched_name(pieces[0], NameRule::number, "x"), "O0001");
  EXPECT_EQ(punched_name(pieces[0], NameRule::comment, "x"), "BOLT M8");
  EXPECT_EQ(punched_name(pieces[1], NameRule::comment, "x"), "O0012");
  EXPECT_EQ(punched_name(pieces[2], NameRule::number, "x"), "O0077");
  for (const auto& piece : pieces) EXPECT_EQ(piece.kind, PunchKind::program);
}

TEST(Punch, AnOpenEndIsSeen) {
  bool closed = true;
  const auto pieces = split("%\nO1\nG0X1\nG1", &closed);
  EXPECT_FALSE(closed);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].end, 12u);
}

TEST(Punch, RecognisesMachineData) {
  EXPECT_EQ(kind_of("%\nG10 P01 X0.0 Z-1.25 R0.4 Q3 Y0\nG10 P10001 X1.0 Z2.0 R0 Y0\n%\n"),
            PunchKind::tool_offsets);
  EXPECT_EQ(kind_of("%\nG10 G90 L10 P1 R12.5\nG10 G90 L11 P1 R0\n%\n"), PunchKind::tool_offsets);
  EXPECT_EQ(kind_of("%\nG10 L2 P1 X-200. Y-100. Z0\nG10 L20 P3 X1.\n%\n"), PunchKind::work_offsets);
  EXPECT_EQ(kind_of("%\nG10 L85 P500(4028000000000000)\nSETVN500[DEPTH,WIDTH]\nM02\n%\n"),
            PunchKind::macro_variables);
  EXPECT_EQ(kind_of("%\nN00000 Q1 P00000010\nN01020 Q1 A1 P88 A2 P90\n%\n"), PunchKind::parameters);
  EXPECT_EQ(kind_of("%\nN10000 Q0 P0\nN10001 Q0 P-12\n%\n"), PunchKind::pitch_error);
  EXPECT_EQ(kind_of("001 00011000\n017 2\n\n\n"), PunchKind::parameters);
  EXPECT_EQ(kind_of("%\nG10 L3\nP1 L30 Q2\nT11 H11 D11\nG11\n%\n"), PunchKind::tool_life);
}

TEST(Punch, AProgramThatSetsOffsetsIsAProgram) {
  EXPECT_EQ(kind_of("%\nO5\nG10 L2 P1 X0 Y0\n%\n"), PunchKind::program);
  EXPECT_EQ(kind_of("%\nG10 L2 P1 X0 Y0\nG0 X1\n%\n"), PunchKind::program);
  EXPECT_EQ(kind_of("%\nG0 X1\nM30\n%\n"), PunchKind::program);
}

TEST(Punch, NamesCannotLeaveTheirFolder) {
  PunchedPiece piece;
  for (const auto& [comment, name] :
       std::vector<std::pair<std::string, std::string>>{{"../../etc/passwd", "_.._etc_passwd"},
                                                        {"..", "O0009"},
                                                        {" A\x01"
                                                         "B ",
                                                         "A_B"},
                                                        {"a\\b", "a_b"},
                                                        {"", "O0009"}}) {
    piece.comment = comment;
    piece.number = 9;
    piece.has_number = true;
    EXPECT_EQ(punched_name(piece, NameRule::comment, "x"), name);
  }
  piece = {};
  EXPECT_EQ(punched_name(piece, NameRule::number, "received"), "received");
}

TEST(Punch, PiecesOfTheTextDoNotMatter) {
  const std::string text = "%\nO0001(A)\nG0\nM30\nO0002(B)\nM99\n%\n";
  const auto whole = split(text);
  PunchSplitter splitter;
  for (const char c : text) splitter.put({&c, 1});
  splitter.finish();
  ASSERT_EQ(splitter.pieces().size(), whole.size());
  for (std::size_t at = 0; at < whole.size(); ++at) EXPECT_EQ(splitter.pieces()[at].end, whole[at].end);
}

TEST(Punch, EndlessNoiseStaysBounded) {
  PunchSplitter splitter;
  for (int i = 0; i < 20'000; ++i) splitter.put("O1\n");
  EXPECT_TRUE(splitter.too_many());
  EXPECT_EQ(splitter.pieces().size(), PunchSplitter::most_pieces);
}

}  // namespace
}  // namespace headstock::tape

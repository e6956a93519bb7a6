#include "server/library/difference.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/db/shop_database.hpp"

namespace headstock::library {
namespace {

using test::text_of;

struct ClassCase {
  const char* left;
  const char* right;
  ChangeClass change;
};

class Classes : public testing::TestWithParam<ClassCase> {};

TEST_P(Classes, AreWhatTheChangeDoes) {
  const ClassCase& one = GetParam();
  EXPECT_EQ(to_string(classify(one.left, one.right)), to_string(one.change))
      << one.left << " -> " << one.right;
  EXPECT_EQ(classify(one.right, one.left), one.change) << "the other way round";
}

INSTANTIATE_TEST_SUITE_P(
    Blocks, Classes,
    testing::Values(ClassCase{"G01 X10.", "G01 X10.", ChangeClass::none},
                    ClassCase{"G01 X10. (ROUGH)", "G01 X10. (FINISH)", ChangeClass::comment},
                    ClassCase{"G01X10.", "G01 X10.", ChangeClass::comment},
                    ClassCase{"", "(NEW)", ChangeClass::comment},
                    ClassCase{"g01 x10.", "G01 X10.", ChangeClass::comment},
                    ClassCase{"G01 X10. F0.2", "G01 X10. F0.15", ChangeClass::feed_speed},
                    ClassCase{"G96 S180 M03", "G96 S200 M03", ChangeClass::feed_speed},
                    ClassCase{"G96 S180 M03", "G97 S1000 M03", ChangeClass::feed_speed},
                    ClassCase{"G04 X1.", "G04 X2.", ChangeClass::feed_speed},
                    ClassCase{"T0101", "T0102", ChangeClass::offset},
                    ClassCase{"G43 H1 Z5.", "G43 H2 Z5.", ChangeClass::offset},
                    ClassCase{"G54", "G55", ChangeClass::offset},
                    ClassCase{"G10 P1 X0.1", "G10 P1 X0.2", ChangeClass::offset},
                    ClassCase{"G50 X100.", "G50 X120.", ChangeClass::offset},
                    ClassCase{"G01 X10. F0.2", "G01 X11. F0.3", ChangeClass::geometry},
                    ClassCase{"G00 X10.", "G01 X10.", ChangeClass::geometry},
                    ClassCase{"G01 X10.", "G01 X10", ChangeClass::geometry},  // 10 mm or 10 least increments
                    ClassCase{"G02 X10. R5.", "G02 X10. R6.", ChangeClass::geometry},
                    ClassCase{"G32 Z-20. F1.5", "G32 Z-20. F2.", ChangeClass::geometry},  // a lead is no pace
                    ClassCase{"", "G01 X5.", ChangeClass::geometry},
                    ClassCase{"", "N10 G01 X5.", ChangeClass::geometry},
                    ClassCase{"N10 G01 X5.", "N20 G01 X5.", ChangeClass::structure},
                    ClassCase{"M98 P1000", "M98 P1001", ChangeClass::structure},
                    ClassCase{"M08", "M09", ChangeClass::structure},
                    ClassCase{"#100=1", "#100=2", ChangeClass::structure},
                    ClassCase{"IF[#1EQ0]GOTO10", "IF[#1EQ0]GOTO20", ChangeClass::structure},
                    ClassCase{"/G01 X1.", "G01 X1.", ChangeClass::structure},
                    ClassCase{"O1000", "O1001", ChangeClass::structure},
                    ClassCase{"G01 X#1 F100", "G01 X#1 F200", ChangeClass::feed_speed},
                    ClassCase{"G01 X[#1+1.] F100", "G01 X[#1+2.] F100", ChangeClass::geometry}));

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

/// What a reader sees on each side, in order.
void expect_faithful(const Difference& difference, const std::vector<std::string>& left,
                     const std::vector<std::string>& right) {
  std::vector<std::string> seen_left, seen_right;
  for (const DiffRow& row : difference.rows) {
    if (row.left_line > 0) {
      EXPECT_EQ(row.left_line, static_cast<std::int64_t>(seen_left.size()) + 1);
      seen_left.push_back(row.left);
    }
    if (row.right_line > 0) {
      EXPECT_EQ(row.right_line, static_cast<std::int64_t>(seen_right.size()) + 1);
      seen_right.push_back(row.right);
    }
    if (row.kind == RowKind::same) {
      EXPECT_EQ(row.left, row.right);
    }
    if (row.kind == RowKind::changed) {
      EXPECT_NE(row.left, row.right);
    }
  }
  EXPECT_EQ(seen_left, left);
  EXPECT_EQ(seen_right, right);
}

/// Length of the longest common subsequence, the slow and certain way.
std::size_t common(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  std::vector<std::size_t> row(b.size() + 1, 0);
  for (const auto& x : a) {
    std::size_t diagonal = 0;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = x == b[j] ? diagonal + 1 : std::max(row[j], above);
      diagonal = above;
    }
  }
  return row.back();
}

TEST(Difference, IsFaithfulAndShortestForRandomTexts) {
  std::mt19937 random(1);
  for (int round = 0; round < 2'000; ++round) {
    const auto text = [&] {
      std::vector<std::string> lines(random() % 14);
      for (auto& line : lines) line = text_of({"X", std::to_string(random() % 5)});
      return lines;
    };
    const auto left = text(), right = text();
    const Difference difference = compare(joined(left), "ascii", joined(right), "ascii");
    expect_faithful(difference, left, right);
    std::size_t same = 0;
    for (const DiffRow& row : difference.rows) same += row.kind == RowKind::same;
    EXPECT_EQ(same, common(left, right)) << joined(left) << "---\n" << joined(right);
    EXPECT_EQ(difference.classes.empty(), left == right);
  }
}

TEST(Difference, SaysWhatKindsOfChangeThereAre) {
  const auto difference =
      compare("O1\r\nG01 X1. F0.2\r\nM30\r\n", "ascii", "O1\nG01 X1. F0.3\n(NEW)\nM30\n", "ascii");
  EXPECT_EQ(difference.classes, (std::vector{ChangeClass::comment, ChangeClass::feed_speed}));
  EXPECT_EQ(difference.changed, 1);
  EXPECT_EQ(difference.added, 1);
  EXPECT_EQ(difference.removed, 0);
}

TEST(Difference, OfBigTextsIsBoundedAndShowsTheChange) {
  std::string left, right;
  for (int i = 0; i < 300'000; ++i) {
    const std::string line = text_of({"G01 X", std::to_string(i), ". Y1.\n"});
    left += line;
    right += i == 250'000 ? "G01 X7. Y2.\n" : line;
  }
  const auto difference = compare(left, "ascii", right, "ascii");
  EXPECT_EQ(difference.changed, 1);
  EXPECT_EQ(difference.added + difference.removed, 0);
  EXPECT_FALSE(difference.truncated);
  ASSERT_LT(difference.rows.size(), 100u);
  std::int64_t lines = 0;
  for (const DiffRow& row : difference.rows) {
    if (row.kind == RowKind::changed) {
      EXPECT_EQ(row.left_line, 250'001);
    }
    lines += row.kind == RowKind::skipped ? row.skipped : 1;
  }
  EXPECT_EQ(lines, 300'000);
}

TEST(Difference, OfUnrelatedTextsEnds) {
  std::string left, right;
  std::mt19937 random(2);
  for (int i = 0; i < 60'000; ++i) {
    left += text_of({"X", std::to_string(random() % 50), "\n"});
    right += text_of({"Y", std::to_string(random() % 50), "\n"});
  }
  DiffOptions options;
  options.effort = 200'000;
  const auto difference = compare(left, "ascii", right, "ascii", options);
  EXPECT_TRUE(difference.coarse);
  EXPECT_TRUE(difference.truncated);
  EXPECT_EQ(difference.rows.size(), 20'000u);
  EXPECT_EQ(difference.removed + difference.changed, 60'000);
  EXPECT_EQ(difference.added + difference.changed, 60'000);
}

TEST(Difference, KeepsTheContextAskedFor) {
  std::string left, right;
  for (int i = 0; i < 20; ++i) left += text_of({"X", std::to_string(i), "\n"});
  right = left;
  right.replace(right.find("X10\n"), 4, "X99\n");
  DiffOptions options;
  options.context = 2;
  const auto rows = compare(left, "ascii", right, "ascii", options).rows;
  ASSERT_EQ(rows.size(), 7u);  // gap, 8, 9, change, 11, 12, gap
  EXPECT_EQ(rows[0].skipped, 8);
  EXPECT_EQ(rows[3].kind, RowKind::changed);
  EXPECT_EQ(rows[6].skipped, 7);
}

}  // namespace
}  // namespace headstock::library

#include "protocol/tape/filter.hpp"

#include <gtest/gtest.h>

namespace headstock::tape {
namespace {

std::string filtered(const FilterOptions& options, std::string_view text, std::size_t piece = 1'000) {
  Filter filter(options);
  std::string out;
  for (; !text.empty(); text.remove_prefix(std::min(piece, text.size())))
    filter.put(text.substr(0, piece), out);
  filter.finish(out);
  return out;
}

TEST(Filter, NothingChangesNothing) {
  const std::string text = "%\r\nO1 (A)\r\nN10 G0 X1\n\n%";
  EXPECT_TRUE(FilterOptions{}.nothing());
  EXPECT_EQ(filtered({}, text), text);
  EXPECT_EQ(filtered({}, text, 1), text);
}

TEST(Filter, SpacesAndComments) {
  FilterOptions options;
  options.strip_spaces = true;
  EXPECT_EQ(filtered(options, "N10 G0 X1 (A B) Y2\n"), "N10G0X1(A B)Y2\n");
  options.strip_comments = true;
  options.strip_empty = true;
  EXPECT_EQ(filtered(options, "O1 (A)\n(ONLY)\n\nG0 X1 (B)\n"), "O1\nG0X1\n");
}

TEST(Filter, NumbersBlocksButNotProgramsNorPercent) {
  FilterOptions options;
  options.number_from = 10;
  options.number_step = 10;
  EXPECT_EQ(filtered(options, "%\nO1\nN7 G0 X1\n/G1 Z2\n\n/2N9M3\nM30\n%\n", 3),
            "%\nO1\nN10 G0 X1\n/N20 G1 Z2\n\n/2N30 M3\nN40 M30\n%\n");
}

TEST(Filter, HeaderGoesBehindTheProgramNumber) {
  FilterOptions options;
  options.header = "(SENT BY THE SHOP)\nG21";
  EXPECT_EQ(filtered(options, "%\nO1(A)\nG0\n%\n"), "%\nO1(A)\n(SENT BY THE SHOP)\nG21\nG0\n%\n");
  EXPECT_EQ(filtered(options, "%\nG0\n%\n"), "%\n(SENT BY THE SHOP)\nG21\nG0\n%\n");
}

std::uint64_t reference(std::string_view text) {
  ReferenceSearch search;
  search.put(text);
  search.finish();
  return search.line();
}

TEST(Filter, FindsWhatRefersToNumbers) {
  EXPECT_EQ(reference("O1\nG0X1\nM98P1000\nM30\n"), 0u);
  EXPECT_EQ(reference("O1\nGOTO 10"), 2u);
  EXPECT_EQ(reference("IF [#1 EQ 2] goto 20\n"), 1u);
  EXPECT_EQ(reference("M99 P20\n"), 1u);
  EXPECT_EQ(reference("M99\n"), 0u);
  EXPECT_EQ(reference("G71 P10 Q20 U.5 W.1\n"), 1u);
  EXPECT_EQ(reference("G71 U2 R1\n"), 0u);
  EXPECT_EQ(reference("(GOTO 10)\n"), 0u);
}

}  // namespace
}  // namespace headstock::tape

#include <gtest/gtest.h>

#include "server/library/lines.hpp"
#include "server/library/text_facts.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::library {
namespace {

using namespace std::string_literals;

/// In pieces of every size, because a piece may end anywhere.
db::BlobRow facts_of(const std::string& text, std::size_t piece = 1) {
  TextFacts facts;
  for (std::size_t at = 0; at < text.size(); at += piece) facts.add(std::string_view(text).substr(at, piece));
  return facts.finish();
}

TEST(TextFacts, Encodings) {
  EXPECT_EQ(facts_of("O1\nM30\n").encoding, "ascii");
  EXPECT_EQ(facts_of("(粗车)\n").encoding, "utf-8");
  EXPECT_EQ(facts_of("(\xB4\xD6\xB3\xB5)\n").encoding, "gbk");
  EXPECT_EQ(facts_of("(\xFF\xFE)\n").encoding, "other");
  EXPECT_EQ(facts_of("(\xE7\xB2").encoding, "gbk");   // a cut UTF-8 sequence is none
  EXPECT_EQ(facts_of("\xC0\x80\n").encoding, "gbk");  // overlong: no UTF-8
  EXPECT_EQ(facts_of("").encoding, "ascii");
}

TEST(TextFacts, LinesInAnyPieces) {
  const std::string text = "%\r\nO1\r\nG01 X1.\r\nM30";
  for (const std::size_t piece : {1u, 2u, 3u, 100u}) {
    const auto facts = facts_of(text, piece);
    EXPECT_EQ(facts.lines, 4);
    EXPECT_EQ(facts.longest_line, 7);
    EXPECT_EQ(facts.line_ends, "crlf");
    EXPECT_TRUE(facts.has_percent);
    EXPECT_EQ(facts.bytes, static_cast<std::int64_t>(text.size()));
  }
  EXPECT_EQ(facts_of("a\rb\r").line_ends, "cr");
  EXPECT_EQ(facts_of("a\rb\r").lines, 2);
  EXPECT_EQ(facts_of("a\nb\r\n").line_ends, "mixed");
  EXPECT_EQ(facts_of("a").line_ends, "none");
  EXPECT_FALSE(facts_of("O1\n%\n").has_percent);
  EXPECT_EQ(facts_of("a\0b\0"s).nul_bytes, 2);
  EXPECT_EQ(facts_of(std::string(10'000'000, 'X'), 65'536).longest_line, 10'000'000);
}

TEST(Utf8, ShowsEverySortOfBytes) {
  EXPECT_EQ(to_utf8("\xB4\xD6\xB3\xB5", "gbk"), "粗车");
  EXPECT_EQ(to_utf8("粗车", "utf-8"), "粗车");
  EXPECT_EQ(to_utf8("a\xFFz", "other"), "a\xEF\xBF\xBDz");
  EXPECT_EQ(to_utf8("a\0z"s, "ascii"), "a\xE2\x90\x80z");
  EXPECT_EQ(to_utf8("\xE7\xB2", "utf-8"), "\xEF\xBF\xBD\xEF\xBF\xBD");
}

struct Lines : testing::Test {
  test::TemporaryFolder folder;
  db::Blobs blobs{folder.path()};
  LineReader reader{blobs};

  std::string put(const std::string& text) {
    auto writer = blobs.begin();
    writer.append(text);
    return writer.finish();
  }
};

TEST_F(Lines, WindowsAnywhereInALongText) {
  std::string text;
  for (int i = 1; i <= 100'000; ++i)
    text += test::text_of({"N", std::to_string(i), i % 3 == 0 ? "\r\n" : i % 3 == 1 ? "\n" : "\r"});
  const std::string sha256 = put(text);
  for (const std::int64_t from : {1, 2, 1023, 1024, 1025, 1026, 2049, 50'000, 99'999}) {
    const LineWindow window = reader.window(sha256, "ascii", from, 3);
    EXPECT_EQ(window.total, 100'000);
    ASSERT_FALSE(window.lines.empty());
    for (std::size_t i = 0; i < window.lines.size(); ++i) {
      EXPECT_EQ(window.lines[i].number, from + static_cast<std::int64_t>(i));
      EXPECT_EQ(window.lines[i].text, test::text_of({"N", std::to_string(window.lines[i].number)}));
    }
  }
  EXPECT_EQ(reader.window(sha256, "ascii", 99'999, 10).lines.size(), 2u);
  EXPECT_TRUE(reader.window(sha256, "ascii", 100'001, 10).lines.empty());
}

TEST_F(Lines, ALineOfTenMegabytesIsCut) {
  const std::string sha256 = put(test::text_of({"O1\n", std::string(10'000'000, 'X'), "\nM30\n"}));
  const LineWindow window = reader.window(sha256, "ascii", 1, 10);
  ASSERT_EQ(window.lines.size(), 3u);
  EXPECT_TRUE(window.lines[1].cut);
  EXPECT_EQ(window.lines[1].text.size(), 4096u);
  EXPECT_EQ(window.lines[2].text, "M30");
  EXPECT_FALSE(window.lines[2].cut);
}

TEST_F(Lines, AnEndBetweenTwoReadsIsOneEnd) {
  // CR is the last byte of the first chunk, LF the first of the next.
  const std::string sha256 = put(test::text_of({std::string((1u << 18) - 1, 'X'), "\r\nM30\r\n"}));
  EXPECT_EQ(reader.window(sha256, "ascii", 2, 5).lines.at(0).text, "M30");
  EXPECT_EQ(reader.window(sha256, "ascii", 1, 1).total, 2);
}

}  // namespace
}  // namespace headstock::library

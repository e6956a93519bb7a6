#include "program/block_reader.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace headstock::program {
namespace {

// Delivers a few bytes at a time, with a wait before each piece, and ends as told.
class Dripping final : public Source {
 public:
  Dripping(std::string text, std::size_t piece, ReadStatus last = ReadStatus::end)
      : text_(std::move(text)), piece_(piece), last_(last) {}
  ReadResult read(std::span<char> buffer) override {
    if (waiting_ = !waiting_; waiting_) return {ReadStatus::wait, 0};
    if (at_ == text_.size()) return {last_, 0};
    const std::size_t bytes = std::min({piece_, text_.size() - at_, buffer.size()});
    std::copy_n(text_.data() + at_, bytes, buffer.data());
    at_ += bytes;
    return {ReadStatus::data, bytes};
  }
  bool seek(std::uint64_t) override { return false; }

 private:
  std::string text_;
  std::size_t piece_, at_ = 0;
  ReadStatus last_;
  bool waiting_ = false;
};

struct Read {
  std::string text;
  std::uint32_t number;
  std::uint64_t offset;
  bool operator==(const Read&) const = default;
};

std::vector<Read> all(BlockReader& reader, LineStatus& last) {
  std::vector<Read> lines;
  Line line;
  for (;;) {
    last = reader.next(line);
    if (last == LineStatus::wait) continue;
    if (last != LineStatus::line) return lines;
    lines.push_back({std::string(line.text), line.number, line.byte_offset});
  }
}

TEST(BlockReader, EveryLineEndInEveryPieceSize) {
  const std::string text = "A\nBB\r\nCCC\rD\n\r\rE\r\n\r\nF";
  const std::vector<Read> expected = {{"A", 1, 0},  {"BB", 2, 2}, {"CCC", 3, 6}, {"D", 4, 10},
                                      {"E", 5, 14}, {"", 6, 18},  {"F", 7, 19}};
  for (std::size_t piece = 1; piece <= text.size(); ++piece) {
    BlockReader reader(std::make_unique<Dripping>(text, piece));
    LineStatus last{};
    EXPECT_EQ(all(reader, last), expected) << "pieces of " << piece;
    EXPECT_EQ(last, LineStatus::end);
  }
}

TEST(BlockReader, EmptySourceHasNoLine) {
  BlockReader reader(source_from_text(""));
  Line line;
  EXPECT_EQ(reader.next(line), LineStatus::end);
  EXPECT_EQ(reader.next(line), LineStatus::end);
}

TEST(BlockReader, LineLongerThanTheLimitIsRefusedWithoutReadingItAll) {
  const std::string hundred = std::string(100, 'X') + "\n";
  BlockReader reader(source_from_text(hundred), 99);
  Line line;
  EXPECT_EQ(reader.next(line), LineStatus::too_long);
  const std::string ninety_nine = std::string(99, 'X') + "\n";
  BlockReader fits(source_from_text(ninety_nine), 99);
  EXPECT_EQ(fits.next(line), LineStatus::line);
  EXPECT_EQ(line.text.size(), 99u);

  const std::string ten_megabytes(10'000'000, 'X');
  BlockReader huge(source_from_text(ten_megabytes), 8'192);
  EXPECT_EQ(huge.next(line), LineStatus::too_long);
}

TEST(BlockReader, BrokenSourceIsTold) {
  BlockReader reader(std::make_unique<Dripping>("A\nB", 1, ReadStatus::failed));
  LineStatus last{};
  EXPECT_EQ(all(reader, last).size(), 1u);
  EXPECT_EQ(last, LineStatus::failed);
}

TEST(BlockReader, SeeksInsideAndOutsideItsBuffer) {
  std::string text;
  for (int i = 0; i < 100'000; ++i) text += "N" + std::to_string(i) + "\n";
  BlockReader reader(source_from_text(text));
  Line line;
  ASSERT_EQ(reader.next(line), LineStatus::line);
  const std::uint64_t second = reader.byte_offset();
  for (int i = 0; i < 90'000; ++i) ASSERT_EQ(reader.next(line), LineStatus::line);
  EXPECT_EQ(line.text, "N90000");
  EXPECT_EQ(line.number, 90'001u);
  ASSERT_TRUE(reader.seek(second, 2));  // long gone from the buffer
  ASSERT_EQ(reader.next(line), LineStatus::line);
  EXPECT_EQ(line.text, "N1");
  EXPECT_EQ(line.number, 2u);
  ASSERT_TRUE(reader.seek(0, 1));  // still in it
  ASSERT_EQ(reader.next(line), LineStatus::line);
  EXPECT_EQ(line.text, "N0");
}

}  // namespace
}  // namespace headstock::program

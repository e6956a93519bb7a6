#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "protocol/tape/decoder.hpp"
#include "protocol/tape/encoder.hpp"

namespace headstock::tape {
namespace {

std::string encoded(std::string_view text, const PunchFormat& format, Findings* findings = nullptr) {
  Encoder encoder(format);
  std::string out;
  encoder.put(text, out);
  encoder.finish(out);
  if (findings != nullptr) *findings = encoder.findings();
  return out;
}

Symbols all_symbols() {
  Symbols symbols;
  // Codes of odd parity that mean nothing in RS-244.
  EXPECT_EQ(symbols.read("*=0D,==1C,#=4C,[=2C,]=2F,?=5B,@=5D,_=5E,:=6E,{=1F,}=3D,'=4F,\"=6D"), "");
  return symbols;
}

PunchFormat format_of(Code code) {
  PunchFormat format;
  format.code = code;
  format.symbols = all_symbols();
  return format;
}

ReadFormat reading(Code code) {
  ReadFormat format;
  format.code = code;
  format.symbols = all_symbols();
  return format;
}

TEST(Convert, TheManualsPunchedLine) {
  // L20100 ff: DPRNT's bytes in ISO: C=C3, space=A0, X=D8, Y=59, M=4D, T=D4.
  EXPECT_EQ(encoded("C X1.\n", format_of(Code::iso)), "\xC3\xA0\xD8\xB1\x2E\x0A");
}

TEST(Convert, EndOfBlockForms) {
  auto format = format_of(Code::iso);
  format.end_of_block = EndOfBlock::lf_cr_cr;
  EXPECT_EQ(encoded("M\n", format), "\x4D\x0A\x8D\x8D");
  format.end_of_block = EndOfBlock::cr_lf;
  EXPECT_EQ(encoded("M\r\n", format), "\x4D\x8D\x0A");
  format.end_of_block = EndOfBlock::cr;
  EXPECT_EQ(encoded("M\n", format), "\x4D\x8D");
  EXPECT_EQ(encoded("M\n", format_of(Code::eia)), "\x54\x80");
  for (const char* text : {"M\x0A\x8D\x8DM\x0A\x8D\x8D", "M\x8D\x0AM\x8D\x0A", "M\x8DM\x8D", "M\x0AM\x0A"}) {
    std::string bytes(text);
    for (char& c : bytes)
      if (c == 'M') c = 0x4D;
    EXPECT_EQ(decoded(bytes, reading(Code::iso)), "M\nM\n");
  }
}

TEST(Convert, EmptyLinesSurviveEveryForm) {
  const std::string text = "%\n\nG0\n\n\nM30\n%\n";
  for (const EndOfBlock form : {EndOfBlock::lf, EndOfBlock::cr_lf, EndOfBlock::lf_cr_cr}) {
    auto format = format_of(Code::iso);
    format.end_of_block = form;
    EXPECT_EQ(decoded(encoded(text, format), reading(Code::iso)), text) << name_of(form);
  }
}

TEST(Convert, LeaderFrameAndTrailer) {
  auto format = format_of(Code::ascii);
  format.leader = 2;
  format.trailer = 3;
  format.frame = true;
  EXPECT_EQ(encoded("O1\nM30", format), std::string("\0\0%\nO1\nM30\n%\n\0\0\0", 16));
  EXPECT_EQ(encoded("%\nO1\nM30\n%", format), std::string("\0\0%\nO1\nM30\n%\0\0\0", 15));
  EXPECT_EQ(encoded("%\nO1\nM30\n", format), std::string("\0\0%\nO1\nM30\n%\n\0\0\0", 16));
  EXPECT_EQ(encoded("", format), std::string("\0\0%\n%\n\0\0\0", 9));
}

TEST(Convert, TvPaddingPassesTheTvCheck) {
  auto format = format_of(Code::iso);
  format.frame = true;
  format.pad_for_tv = true;
  auto check = reading(Code::iso);
  check.tv_check = true;
  Findings findings;
  const auto text = decoded(encoded("O1\nG0X1\nG00 X1\n\nM30\n", format), check, &findings);
  EXPECT_TRUE(findings.none());
  EXPECT_EQ(text, "%\nO1 \nG0X1 \nG00 X1 \n \nM30\n%\n");
  format.pad_for_tv = false;
  decoded(encoded("O1\nG0X1\n", format), check, &findings);
  ASSERT_FALSE(findings.none());
  EXPECT_EQ(findings.kept()[0].kind, Finding::tv);
}

TEST(Convert, TvDoesNotCountTheSkippedLabelNorCommentsWhenTold) {
  auto check = reading(Code::ascii);
  check.tv_check = true;
  Findings findings;
  decoded("LABEL1\nG01\n", check, &findings);  // label of 7 characters with its end
  EXPECT_TRUE(findings.none());
  decoded("%\nG01(ABC)\n", check, &findings);
  EXPECT_EQ(findings.count(), 1u);
  check.tv_counts_comments = false;  // from ( to )
  decoded("%\nG01(ABC)\n", check, &findings);
  EXPECT_TRUE(findings.none());
}

TEST(Convert, WrongParityIsFoundWithItsPlace) {
  std::string bytes = encoded("O1\nG01X5\n", format_of(Code::iso));
  bytes[5] = static_cast<char>(bytes[5] ^ 0x40);
  Findings findings;
  const auto text = decoded(bytes, reading(Code::iso), &findings);
  EXPECT_EQ(text, "O1\nG0X5\n");
  ASSERT_EQ(findings.count(), 1u);
  EXPECT_EQ(findings.kept()[0].kind, Finding::th);
  EXPECT_EQ(findings.kept()[0].offset, 5u);
  EXPECT_EQ(findings.kept()[0].line, 2u);
  EXPECT_EQ(findings.kept()[0].column, 3u);
  EXPECT_EQ(describe(findings.kept()[0]), "line 2, column 3: byte F1 has wrong parity (TH)");
}

TEST(Convert, WhatACodeLacksIsAnErrorNotSilence) {
  PunchFormat plain;
  plain.code = Code::eia;
  Findings findings;
  encoded("G1X#1\n(a)\n", plain, &findings);
  ASSERT_EQ(findings.count(), 2u);
  EXPECT_EQ(describe(findings.kept()[0]), "line 1, column 4: byte 23 (#) has no code here");
  plain.code = Code::iso;
  encoded("(\xE4\xB8\xAD)\n", plain, &findings);
  EXPECT_EQ(findings.count(), 3u);
  plain.code = Code::eia;
  plain.fold_case = true;
  EXPECT_EQ(encoded("a", plain, &findings), "\x61");
  EXPECT_TRUE(findings.none());
}

TEST(Convert, AsciiKeepsChineseComments) {
  const std::string text = "O1(\xE4\xB8\xAD\xE6\x96\x87)\n";
  EXPECT_EQ(encoded(text, format_of(Code::ascii)), text);
  EXPECT_EQ(decoded(text, reading(Code::ascii)), text);
}

TEST(Convert, PiecesDoNotMatter) {
  std::mt19937 random(7);
  const std::string text = "%\r\nO1000(TEST)\r\nG0 X1. Z-2.5\r\n\r\nM30\r\n%\r\n";
  auto format = format_of(Code::iso);
  format.end_of_block = EndOfBlock::lf_cr_cr;
  const std::string whole = encoded(text, format);
  const std::string plain = decoded(whole, reading(Code::iso));
  for (int round = 0; round < 200; ++round) {
    Encoder encoder(format);
    Decoder decoder(reading(Code::iso));
    std::string bytes, back;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t count = 1 + random() % 5;
      encoder.put(std::string_view(text).substr(at, count), bytes);
      at += count;
    }
    encoder.finish(bytes);
    ASSERT_EQ(bytes, whole);
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t count = 1 + random() % 5;
      decoder.put(std::string_view(bytes).substr(at, count), back);
      at += count;
    }
    decoder.finish(back);
    ASSERT_EQ(back, plain);
  }
}

/// ISO → EIA → ISO of a text that EIA can carry.
void expect_identity(const std::string& iso, const std::string& what) {
  Findings findings;
  const std::string text = decoded(iso, reading(Code::iso), &findings);
  ASSERT_TRUE(findings.none()) << what << ": " << describe(findings.kept()[0]);
  const std::string eia = encoded(text, format_of(Code::eia), &findings);
  ASSERT_TRUE(findings.none()) << what << ": " << describe(findings.kept()[0]);
  const std::string again = decoded(eia, reading(Code::eia), &findings);
  ASSERT_TRUE(findings.none()) << what << ": " << describe(findings.kept()[0]);
  EXPECT_TRUE(encoded(again, format_of(Code::iso)) == iso) << what;
}

TEST(Convert, IsoToEiaAndBackIsTheIdentityOnEveryCharacter) {
  std::string text;
  const CharacterSet eia(Code::eia, all_symbols());
  for (int c = 1; c < 128; ++c)
    if (eia.byte_of(static_cast<char>(c)) &&
        eia.meaning_of(*eia.byte_of(static_cast<char>(c))).kind == Meaning::character)
      text += static_cast<char>(c);
  EXPECT_EQ(text.size(), 48u + 13u);
  expect_identity(encoded(text + "\n", format_of(Code::iso)), "all characters");
}

TEST(Convert, IsoToEiaAndBackIsTheIdentityOnTheCorpus) {
  const char* const folder = std::getenv("HEADSTOCK_CORPUS");
  if (folder == nullptr) GTEST_SKIP() << "HEADSTOCK_CORPUS names no folder of real programs";
  int converted = 0, refused = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const auto extension = entry.path().extension();
    if (extension != ".nc" && extension != ".ngc" && extension != ".gcode") continue;
    std::ifstream in(entry.path(), std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    auto format = format_of(Code::iso);
    format.fold_case = true;
    Findings findings;
    const std::string iso = encoded(decoded(text, reading(Code::ascii)), format, &findings);
    Encoder probe(format_of(Code::eia));
    std::string ignored;
    probe.put(decoded(iso, reading(Code::iso)), ignored);
    if (!findings.none() || !probe.findings().none()) {
      ++refused;  // said with line and column, not changed quietly
      std::printf("%s: %s\n", entry.path().filename().c_str(),
                  describe((findings.none() ? probe.findings() : findings).kept().front()).c_str());
      continue;
    }
    ++converted;
    expect_identity(iso, entry.path().filename());
  }
  EXPECT_GT(converted, 0);
  EXPECT_EQ(refused, 0) << "capitals, with holes for what else comments have";
  RecordProperty("converted", converted);
  RecordProperty("refused", refused);
}

}  // namespace
}  // namespace headstock::tape

// Every character of the manual's code list, both ways (B-64304CM appendix B, L68857-68990).
#include "protocol/tape/code.hpp"

#include <gtest/gtest.h>

#include <bit>

namespace headstock::tape {
namespace {

struct Row {
  char character;
  int iso, eia;  ///< -1: none
};
// As printed, except ISO ';' (FB printed), ISO '_' (6F printed) and EIA Tab (2E printed), whose parity is
// wrong there, and '<', printed with the code of ','.
constexpr Row kManual[] = {
    {'0', 0x30, 0x20}, {'1', 0xB1, 0x01},  {'2', 0xB2, 0x02},  {'3', 0x33, 0x13}, {'4', 0xB4, 0x04},
    {'5', 0x35, 0x15}, {'6', 0x36, 0x16},  {'7', 0xB7, 0x07},  {'8', 0xB8, 0x08}, {'9', 0x39, 0x19},
    {'A', 0x41, 0x61}, {'B', 0x42, 0x62},  {'C', 0xC3, 0x73},  {'D', 0x44, 0x64}, {'E', 0xC5, 0x75},
    {'F', 0xC6, 0x76}, {'G', 0x47, 0x67},  {'H', 0x48, 0x68},  {'I', 0xC9, 0x79}, {'J', 0xCA, 0x51},
    {'K', 0x4B, 0x52}, {'L', 0xCC, 0x43},  {'M', 0x4D, 0x54},  {'N', 0x4E, 0x45}, {'O', 0xCF, 0x46},
    {'P', 0x50, 0x57}, {'Q', 0xD1, 0x58},  {'R', 0xD2, 0x49},  {'S', 0x53, 0x32}, {'T', 0xD4, 0x23},
    {'U', 0x55, 0x34}, {'V', 0x56, 0x25},  {'W', 0xD7, 0x26},  {'X', 0xD8, 0x37}, {'Y', 0x59, 0x38},
    {'Z', 0x5A, 0x29}, {'\t', 0x09, 0x3E}, {'\n', 0x0A, 0x80}, {' ', 0xA0, 0x10}, {'%', 0xA5, 0x0B},
    {'(', 0x28, 0x1A}, {')', 0xA9, 0x4A},  {'+', 0x2B, 0x70},  {'-', 0x2D, 0x40}, {':', 0x3A, -1},
    {'/', 0xAF, 0x31}, {'.', 0x2E, 0x6B},  {'#', 0xA3, -1},    {'$', 0x24, -1},   {'&', 0xA6, 0x0E},
    {'\'', 0x27, -1},  {'*', 0xAA, -1},    {',', 0xAC, 0x3B},  {';', 0xBB, -1},   {'<', 0x3C, -1},
    {'=', 0xBD, -1},   {'>', 0xBE, -1},    {'?', 0x3F, -1},    {'@', 0xC0, -1},   {'"', 0x22, -1},
    {'[', 0xDB, -1},   {']', 0xDD, -1},    {'_', 0x5F, -1}};

void expect_both_ways(const CharacterSet& set, char character, int byte) {
  SCOPED_TRACE(character);
  if (byte < 0) {
    EXPECT_FALSE(set.byte_of(character));
    return;
  }
  ASSERT_TRUE(set.byte_of(character));
  EXPECT_EQ(*set.byte_of(character), byte);
  const Meaning back = set.meaning_of(static_cast<std::uint8_t>(byte));
  EXPECT_EQ(back.kind, Meaning::character);
  EXPECT_EQ(back.value, character);
}

TEST(Code, EveryCharacterOfTheManualBothWays) {
  const CharacterSet iso(Code::iso), eia(Code::eia);
  for (const Row& row : kManual) {
    expect_both_ways(iso, row.character, row.iso);
    expect_both_ways(eia, row.character, row.eia);
  }
}

TEST(Code, ControlCodesOfTheManual) {
  const CharacterSet iso(Code::iso), eia(Code::eia);
  EXPECT_EQ(iso.meaning_of(0xFF).kind, Meaning::feed);     // DEL
  EXPECT_EQ(iso.meaning_of(0x88).kind, Meaning::ignored);  // BS
  EXPECT_EQ(iso.meaning_of(0x8D).value, '\r');
  EXPECT_EQ(eia.meaning_of(0x7F).kind, Meaning::feed);
  EXPECT_EQ(eia.meaning_of(0x2A).kind, Meaning::ignored);
  EXPECT_EQ(iso.meaning_of(0).kind, Meaning::feed);
  EXPECT_EQ(eia.meaning_of(0).kind, Meaning::feed);
}

TEST(Code, EverySingleFlippedBitIsWrongParity) {
  for (const Code code : {Code::iso, Code::eia}) {
    const CharacterSet set(code);
    for (const Row& row : kManual) {
      const auto byte = set.byte_of(row.character);
      if (!byte) continue;
      for (unsigned bit = 0; bit < 8; ++bit) {
        const auto flipped = static_cast<std::uint8_t>(*byte ^ (1u << bit));
        if (flipped == 0) continue;  // blank tape
        EXPECT_EQ(set.meaning_of(flipped).kind, Meaning::wrong_parity) << row.character << " bit " << bit;
      }
    }
  }
}

TEST(Code, SymbolsGetTheHolesOfTheParameters) {
  Symbols symbols;
  EXPECT_EQ(symbols.read("#=4C,*=0D"), "");
  EXPECT_EQ(symbols.text(), "*=0D,#=4C");
  const CharacterSet eia(Code::eia, symbols);
  expect_both_ways(eia, '#', 0x4C);
  expect_both_ways(eia, '*', 0x0D);
  EXPECT_FALSE(eia.byte_of('='));
}

TEST(Code, ASymbolCannotTakeTheHolesOfAnother) {
  Symbols symbols;
  EXPECT_FALSE(symbols.set('#', 0x61));  // A
  EXPECT_FALSE(symbols.set('#', 0));
  EXPECT_FALSE(symbols.set('A', 0x4C));
  EXPECT_TRUE(symbols.set('#', 0x4C));
  EXPECT_FALSE(symbols.set('*', 0x4C));
  EXPECT_NE(symbols.read("#=61"), "");
  EXPECT_NE(symbols.read("#"), "");
  EXPECT_NE(symbols.read("#=1234"), "");
  EXPECT_EQ(symbols.text(), "#=4C");  // what could not be read changes nothing
}

TEST(Code, EvenParityOfTheSteeringCodes) {
  EXPECT_EQ(with_even_parity(dc1), 0x11);
  EXPECT_EQ(with_even_parity(dc2), 0x12);
  EXPECT_EQ(with_even_parity(dc3), 0x93);
  EXPECT_EQ(with_even_parity(dc4), 0x14);
  for (unsigned byte = 0; byte < 128; ++byte)
    EXPECT_EQ(std::popcount(with_even_parity(static_cast<std::uint8_t>(byte))) % 2, 0);
}

}  // namespace
}  // namespace headstock::tape

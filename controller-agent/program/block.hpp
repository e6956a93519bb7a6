// One block as the lexer leaves it: words with their exact decimals and their columns. No allocation; reused
// for every block of a program.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace headstock::program {

/// Index of an address letter, 'A'…'Z' → 0…25.
constexpr unsigned letter_index(char letter) {
  return static_cast<unsigned>(letter - 'A');
}
/// Bit of an address letter in a mask.
constexpr std::uint32_t letter_bit(char letter) {
  return 1u << letter_index(letter);
}
/// Mask of several letters: letters("XYZ").
constexpr std::uint32_t letters(const char* text) {
  std::uint32_t mask = 0;
  for (; *text != '\0'; ++text) mask |= letter_bit(*text);
  return mask;
}

/// Powers of ten that a 64-bit integer holds.
inline constexpr std::array<std::int64_t, 19> kPowerOfTen = [] {
  std::array<std::int64_t, 19> powers{};
  std::int64_t power = 1;
  for (auto& entry : powers) {
    entry = power;
    power = power <= INT64_MAX / 10 ? power * 10 : power;
  }
  return powers;
}();

/// Positions are counted in these: 1e-9 of the programming unit (mm, inch, degree). Exact for every decimal
/// word.
inline constexpr int kNanoDecimals = 9;
inline constexpr std::int64_t kNano = 1'000'000'000;

/// The number behind an address, exactly as written.
struct Word {
  std::int64_t digits = 0;       ///< all its digits as one signed integer: -1.250 → -1250
  std::uint8_t decimals = 0;     ///< digits after the point, at most kNanoDecimals
  std::uint8_t digit_count = 0;  ///< digits as typed, leading zeros too
  bool point = false;            ///< written with a decimal point (or computed by a macro)
  std::uint32_t column = 0;      ///< 1-based, of the address letter

  /// The number as written, correctly rounded: "1250" → 1250, "1.25" → 1.25.
  double value() const { return static_cast<double>(digits) / static_cast<double>(kPowerOfTen[decimals]); }
  /// In 1e-9 of the unit the point stands for. Exact. Precondition: |value| < 1e9.
  std::int64_t nano() const { return digits * kPowerOfTen[kNanoDecimals - decimals]; }
  /// Whole part; fractions are cut.
  std::int64_t integer() const { return digits / kPowerOfTen[decimals]; }
};

/// A G or M code with its tenths: G54.1 → 541.
struct Code {
  std::int32_t tenths = 0;
  std::uint32_t column = 0;
};

inline constexpr std::size_t kMostCodes = 16;

/// Takes the code at `place` out of the first `count`.
template <std::size_t N>
void remove_code(std::array<Code, N>& codes, std::uint8_t& count, std::size_t place) {
  for (std::size_t i = place; i + 1 < count; ++i) codes[i] = codes[i + 1];
  --count;
}

/// A word that was written again later in its block (I J K of a macro call).
struct EarlierWord {
  Word word;
  char letter = 'A';
  bool negative = false;
};
inline constexpr std::size_t kMostEarlier = 40;

/// A word whose number a macro expression gives; the expression belongs to whoever compiled it.
struct ComputedWord {
  char letter = 'A';       ///< G and M: of g[place], m[place]
  bool marked = false;     ///< of marked_word[]
  std::uint8_t place = 0;  ///< earlier[place − 1]; 0: word[] itself
  std::uint16_t expression = 0;
};
inline constexpr std::size_t kMostComputed = 40;

struct Block {
  std::uint32_t words = 0;           ///< letters present, without G M N O; see letter_bit
  std::uint32_t pointed = 0;         ///< of these: written with a point
  std::uint32_t negative = 0;        ///< of these: written with a minus sign
  std::uint32_t repeated = 0;        ///< of these: written more than once (the last one is kept)
  std::array<Word, 26> word;         ///< by letter_index; meaningful where `words` has the bit
  std::uint32_t marked = 0;          ///< letters of the words with a mark before the letter: `,C` `,R` `,A`
  std::array<Word, 26> marked_word;  ///< of these; meaningful where `marked` has the bit
  std::array<Code, kMostCodes> g;
  std::array<Code, kMostCodes> m;
  std::array<EarlierWord, kMostEarlier> earlier;  ///< words that were repeated, in order
  std::array<ComputedWord, kMostComputed> computed;
  std::uint8_t g_count = 0;
  std::uint8_t m_count = 0;
  std::uint8_t earlier_count = 0;
  std::uint8_t computed_count = 0;
  bool m_pointed = false;      ///< an M code was written with a point
  bool has_sequence = false;   ///< N word present
  bool has_number = false;     ///< O word (or `:`) present
  std::uint32_t sequence = 0;  ///< N word
  std::uint32_t sequence_column = 0;
  std::uint32_t number = 0;  ///< O word
  std::uint32_t number_column = 0;
  std::uint32_t skip = 0;         ///< bit n: `/n` stands at the head of the block; plain `/` is bit 1
  std::uint32_t inner_slash = 0;  ///< column of a slash that is not at the head; 0: none

  bool has(char letter) const { return (words & letter_bit(letter)) != 0; }
  const Word& operator[](char letter) const { return word[letter_index(letter)]; }
  bool has_marked(char letter) const { return (marked & letter_bit(letter)) != 0; }
  const Word& marked_at(char letter) const { return marked_word[letter_index(letter)]; }

  /// Forgets the last block; word[] stays as it is, `words` says what is meaningful.
  void clear() {
    words = pointed = negative = repeated = marked = 0;
    g_count = m_count = earlier_count = computed_count = 0;
    m_pointed = has_sequence = has_number = false;
    skip = inner_slash = 0;
  }
};

}  // namespace headstock::program

// The codes of the tape and of the serial line: what each byte means and how each character is punched.
// Source: FANUC B-64304CM appendix B (program code list). ISO is ASCII with even parity in bit 8, EIA
// (RS-244) has odd parity in bit 5. Three entries of the printed list contradict their own parity (ISO `;`
// FB, ISO `_` 6F, EIA Tab 2E); here they have the codes of the standards (BB, 5F, 3E).
//
// Characters are ASCII; '\n' is the end of block (LF in ISO, the code 80 in EIA). Any thread; tables are
// constant.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace headstock::tape {

enum class Code {
  ascii,  ///< bytes as they are, bit 8 included (Chinese comments); parity, if any, is the line's
  iso,    ///< 7 bits and even parity in bit 8
  eia     ///< RS-244
};

/// "ascii", "iso", "eia".
std::string_view name_of(Code code);
std::optional<Code> code_named(std::string_view name);

/// The holes of the characters that EIA does not have, as the control's parameters No.6010-6018 give them; 0:
/// the character cannot be punched. The manual prints no defaults, so there are none here. What else ASCII
/// has (a colon in the comments of CAM systems) has no parameter: holes for it are an agreement of the two
/// ends.
class Symbols {
 public:
  static constexpr std::string_view characters = "*=#[]?@&_:;'\"!$<>\\^`{|}~";  ///< No.6010…6018, others
  std::uint8_t pattern(char character) const;
  /// @return false when the character is none of `characters`, or the pattern is 0 or already means something
  /// in EIA (other than `character` itself).
  bool set(char character, std::uint8_t pattern);
  /// Reads "#=4C,*=8A": hexadecimal patterns. @return what is wrong, empty when read.
  std::string read(std::string_view text);
  std::string text() const;

 private:
  std::array<std::uint8_t, characters.size()> patterns_{};
};

/// What one byte of a tape is.
struct Meaning {
  enum Kind : std::uint8_t {
    character,    ///< of the program
    feed,         ///< blank tape or DEL: skipped everywhere
    ignored,      ///< a code that controls skip (backspace, unlisted codes with right parity, CR in ISO)
    wrong_parity  ///< TH alarm (PS0001)
  };
  Kind kind = ignored;
  char value = 0;  ///< of character; for ignored ISO and ASCII codes the control character
};

class CharacterSet {
 public:
  explicit CharacterSet(Code code, const Symbols& symbols = {});
  Code code() const { return code_; }
  /// @return the byte with its parity, nothing when this code has no such character. EIA has one case of
  /// letters: lower-case letters have none.
  std::optional<std::uint8_t> byte_of(char character) const;
  Meaning meaning_of(std::uint8_t byte) const { return meanings_[byte]; }

 private:
  Code code_;
  std::array<Meaning, 256> meanings_{};
  std::array<std::int16_t, 256> bytes_{};  ///< -1: none
};

/// The codes that steer a tape reader or a punch on the line (ISO, even parity: DC3 is 93 there).
enum : std::uint8_t { dc1 = 0x11, dc2 = 0x12, dc3 = 0x13, dc4 = 0x14, end_of_file = 0x1A };
/// "DC3", "LF", "NUL", "DEL" … for bytes that do not print; empty for those that do.
std::string_view control_name(std::uint8_t byte);
/// The byte with bit 8 set when that makes the number of its ones even.
constexpr std::uint8_t with_even_parity(std::uint8_t seven_bits) {
  std::uint8_t ones = 0;
  for (unsigned bit = 0; bit < 7; ++bit) ones = static_cast<std::uint8_t>(ones ^ ((unsigned{seven_bits} >> bit) & 1u));
  return static_cast<std::uint8_t>((seven_bits & 0x7Fu) | (ones << 7));
}

}  // namespace headstock::tape

#include "protocol/tape/code.hpp"

#include <bit>
#include <charconv>

namespace headstock::tape {
namespace {

struct EiaRow {
  char character;
  std::uint8_t byte;
};
constexpr EiaRow kEia[] = {
    {'0', 0x20}, {'1', 0x01}, {'2', 0x02}, {'3', 0x13}, {'4', 0x04},  {'5', 0x15}, {'6', 0x16}, {'7', 0x07},
    {'8', 0x08}, {'9', 0x19}, {'A', 0x61}, {'B', 0x62}, {'C', 0x73},  {'D', 0x64}, {'E', 0x75}, {'F', 0x76},
    {'G', 0x67}, {'H', 0x68}, {'I', 0x79}, {'J', 0x51}, {'K', 0x52},  {'L', 0x43}, {'M', 0x54}, {'N', 0x45},
    {'O', 0x46}, {'P', 0x57}, {'Q', 0x58}, {'R', 0x49}, {'S', 0x32},  {'T', 0x23}, {'U', 0x34}, {'V', 0x25},
    {'W', 0x26}, {'X', 0x37}, {'Y', 0x38}, {'Z', 0x29}, {'\t', 0x3E}, {' ', 0x10}, {'%', 0x0B}, {'(', 0x1A},
    {')', 0x4A}, {'+', 0x70}, {'-', 0x40}, {'/', 0x31}, {'.', 0x6B},  {'&', 0x0E}, {',', 0x3B}, {'\n', 0x80}};
constexpr std::uint8_t kEiaDelete = 0x7F, kEiaBackspace = 0x2A;

constexpr std::string_view kControlNames[32] = {"NUL", "SOH", "STX", "ETX", "EOT", "ENQ", "ACK", "BEL",
                                                "BS",  "HT",  "LF",  "VT",  "FF",  "CR",  "SO",  "SI",
                                                "DLE", "DC1", "DC2", "DC3", "DC4", "NAK", "SYN", "ETB",
                                                "CAN", "EM",  "SUB", "ESC", "FS",  "GS",  "RS",  "US"};

std::size_t index_of(char character) {
  return static_cast<unsigned char>(character);
}
bool odd(std::uint8_t byte) {
  return std::popcount(byte) % 2 == 1;
}

}  // namespace

std::string_view name_of(Code code) {
  switch (code) {
    case Code::ascii:
      return "ascii";
    case Code::iso:
      return "iso";
    case Code::eia:
      return "eia";
  }
  return "";
}

std::optional<Code> code_named(std::string_view name) {
  for (const Code code : {Code::ascii, Code::iso, Code::eia})
    if (name == name_of(code)) return code;
  return std::nullopt;
}

std::uint8_t Symbols::pattern(char character) const {
  const auto at = characters.find(character);
  return at == std::string_view::npos ? 0 : patterns_[at];
}

bool Symbols::set(char character, std::uint8_t pattern) {
  const auto at = characters.find(character);
  if (at == std::string_view::npos || pattern == 0 || pattern == kEiaDelete || pattern == kEiaBackspace)
    return false;
  for (const EiaRow& row : kEia)
    if (row.byte == pattern && row.character != character) return false;
  for (std::size_t other = 0; other < patterns_.size(); ++other)
    if (other != at && patterns_[other] == pattern) return false;
  patterns_[at] = pattern;
  return true;
}

std::string Symbols::read(std::string_view text) {
  Symbols read;
  while (!text.empty()) {
    unsigned pattern = 0;
    const char* const end = text.data() + text.size();
    if (text.size() < 3 || text[1] != '=') return "expected CHARACTER=HEX, separated by commas";
    const auto [stop, error] = std::from_chars(text.data() + 2, end, pattern, 16);
    if (error != std::errc() || pattern > 0xFF || (stop != end && *stop != ','))
      return "the pattern is a byte in hexadecimal";
    if (!read.set(text[0], static_cast<std::uint8_t>(pattern)))
      return std::string("this pattern cannot stand for ") + text[0];
    text = stop == end ? std::string_view()
                       : std::string_view(stop + 1, static_cast<std::size_t>(end - stop - 1));
  }
  *this = read;
  return "";
}

std::string Symbols::text() const {
  static constexpr char digits[] = "0123456789ABCDEF";
  std::string text;
  for (std::size_t at = 0; at < patterns_.size(); ++at) {
    if (patterns_[at] == 0) continue;
    if (!text.empty()) text += ',';
    text += {characters[at], '=', digits[patterns_[at] >> 4], digits[patterns_[at] & 15u]};
  }
  return text;
}

CharacterSet::CharacterSet(Code code, const Symbols& symbols) : code_(code) {
  bytes_.fill(-1);
  const auto punch = [this](char character, std::uint8_t byte) {
    meanings_[byte] = {Meaning::character, character};
    bytes_[index_of(character)] = byte;
  };
  for (unsigned byte = 0; byte < 256; ++byte) {
    const auto at = static_cast<std::uint8_t>(byte);
    if (code == Code::eia) {
      meanings_[at] = {odd(at) ? Meaning::ignored : Meaning::wrong_parity, 0};
      continue;
    }
    if (code == Code::iso && odd(at)) {
      meanings_[at] = {Meaning::wrong_parity, 0};
      continue;
    }
    const auto character = static_cast<char>(code == Code::iso ? byte & 0x7Fu : byte);
    const bool prints = character == '\n' || character == '\t' || index_of(character) >= 0x20;
    if (prints && index_of(character) != 0x7F) {
      punch(character, at);
    } else {
      meanings_[at] = {Meaning::ignored, character};
      bytes_[index_of(character)] = static_cast<std::int16_t>(at);
    }
  }
  if (code == Code::eia) {
    for (const char character : Symbols::characters)
      if (const auto pattern = symbols.pattern(character); pattern != 0) punch(character, pattern);
    for (const EiaRow& row : kEia)
      if (row.character != '&' || symbols.pattern('&') == 0) punch(row.character, row.byte);
    meanings_[kEiaDelete] = {Meaning::feed, 0};
    meanings_[kEiaBackspace] = {Meaning::ignored, '\b'};
  } else {
    meanings_[code == Code::iso ? 0xFF : 0x7F] = {Meaning::feed, 0x7F};
  }
  meanings_[0] = {Meaning::feed, 0};  // blank tape
}

std::optional<std::uint8_t> CharacterSet::byte_of(char character) const {
  const auto byte = bytes_[index_of(character)];
  if (byte < 0) return std::nullopt;
  return static_cast<std::uint8_t>(byte);
}

std::string_view control_name(std::uint8_t byte) {
  if (byte < 32) return kControlNames[byte];
  return byte == 0x7F ? "DEL" : "";
}

}  // namespace headstock::tape

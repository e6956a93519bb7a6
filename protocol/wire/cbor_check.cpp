#include "protocol/wire/cbor_check.hpp"

#include <array>
#include <cstdint>

namespace headstock::wire {
namespace {

constexpr std::size_t kMaxDepth = 16;
constexpr std::size_t kMaxItems = 200'000;

// Major types of RFC 8949.
enum Major : unsigned {
  kUnsigned = 0,
  kNegative = 1,
  kBytes = 2,
  kText = 3,
  kArray = 4,
  kMap = 5,
  kTag = 6,
  kSimple = 7
};

}  // namespace

bool is_utf8(std::string_view text) {
  const auto* p = reinterpret_cast<const unsigned char*>(text.data());
  const auto* end = p + text.size();
  while (p < end) {
    if (*p < 0x80) {
      ++p;
      continue;
    }
    const int length = *p >= 0xC2 && *p <= 0xDF   ? 2
                       : (*p & 0xF0) == 0xE0      ? 3
                       : *p >= 0xF0 && *p <= 0xF4 ? 4
                                                  : 0;
    if (length == 0 || end - p < length) return false;
    for (int i = 1; i < length; ++i)
      if ((p[i] & 0xC0) != 0x80) return false;
    // Overlong forms, surrogates, beyond U+10FFFF.
    if ((p[0] == 0xE0 && p[1] < 0xA0) || (p[0] == 0xED && p[1] > 0x9F) || (p[0] == 0xF0 && p[1] < 0x90) ||
        (p[0] == 0xF4 && p[1] > 0x8F))
      return false;
    p += length;
  }
  return true;
}

std::string check_cbor(std::string_view body) {
  // Items still to come at each level; a stack of our own because the library's reader calls itself for each
  // level.
  std::array<std::uint64_t, kMaxDepth + 1> open{};
  std::array<bool, kMaxDepth + 1> in_map{};
  std::size_t depth = 0, items = 0, at = 0;
  open[0] = 1;
  while (true) {
    while (open[depth] == 0) {
      if (depth == 0) return at == body.size() ? "" : "bytes after the message";
      --depth;
    }
    const bool is_key = in_map[depth] && open[depth] % 2 == 0;
    --open[depth];
    if (++items > kMaxItems) return "too many items";
    if (at >= body.size()) return "cut short";
    const auto initial = static_cast<unsigned char>(body[at++]);
    const unsigned major = initial >> 5, low = initial & 31u;
    std::uint64_t argument = low;
    if (low >= 28) return "a length of unknown form";
    if (low >= 24) {
      const std::size_t bytes = std::size_t{1} << (low - 24);
      if (body.size() - at < bytes) return "cut short";
      argument = 0;
      for (std::size_t i = 0; i < bytes; ++i)
        argument = (argument << 8) | static_cast<unsigned char>(body[at++]);
    }
    if (is_key && major != kText) return "a key that is no text";
    switch (major) {
      case kUnsigned:
        break;
      case kNegative:
        if (argument > INT64_MAX) return "a number too small";
        break;
      case kText:
        if (argument > body.size() - at) return "cut short";
        if (!is_utf8(body.substr(at, argument))) return "a text that is not UTF-8";
        at += argument;
        break;
      case kArray:
      case kMap: {
        // Each item needs a byte at least: a length beyond the rest is a lie.
        if (argument > body.size() - at) return "cut short";
        if (++depth > kMaxDepth) return "nested too deep";
        open[depth] = major == kMap ? argument * 2 : argument;
        in_map[depth] = major == kMap;
        break;
      }
      case kSimple:
        // false, true, null, and floats of 32 and 64 bits.
        if (low != 20 && low != 21 && low != 22 && low != 26 && low != 27) return "a value of unknown kind";
        break;
      default:
        return "a value of unknown kind";
    }
  }
}

}  // namespace headstock::wire

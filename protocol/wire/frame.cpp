#include "protocol/wire/frame.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace headstock::wire {
namespace {

constexpr std::string_view kMagic = "HSTK";
constexpr std::size_t kReadAhead = 192u << 10;
constexpr std::size_t kLeastSpace = 32u << 10;  // two TLS records
/// A buffer that grew for a big control message is given back after it.
constexpr std::size_t kKeepCapacity = 256u << 10;

using CrcTables = std::array<std::array<std::uint32_t, 256>, 8>;

/// Slicing by 8: eight bytes a step, about six times a byte-wise table; drip-feeds pass every byte through it
/// twice.
constexpr CrcTables make_tables() {
  CrcTables tables{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) ? 0xEDB88320u : 0u);
    tables[0][i] = value;
  }
  for (std::size_t t = 1; t < 8; ++t)
    for (std::size_t i = 0; i < 256; ++i)
      tables[t][i] = (tables[t - 1][i] >> 8) ^ tables[0][tables[t - 1][i] & 0xff];
  return tables;
}
constexpr CrcTables kCrc = make_tables();

std::uint32_t little(const char* at) {
  const auto* p = reinterpret_cast<const unsigned char*>(at);
  return static_cast<std::uint32_t>(p[0]) | static_cast<std::uint32_t>(p[1]) << 8 |
         static_cast<std::uint32_t>(p[2]) << 16 | static_cast<std::uint32_t>(p[3]) << 24;
}

template <class Integer>
void put_big(char* at, Integer value) {
  for (std::size_t i = 0; i < sizeof(Integer); ++i)
    at[i] = static_cast<char>((value >> (8 * (sizeof(Integer) - 1 - i))) & 0xff);
}

template <class Integer>
Integer get_big(const char* at) {
  Integer value = 0;
  for (std::size_t i = 0; i < sizeof(Integer); ++i)
    value = static_cast<Integer>((value << 8) | static_cast<unsigned char>(at[i]));
  return value;
}

}  // namespace

std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = 0xffffffffu;
  const char* at = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= 8; at += 8, left -= 8) {
    const std::uint32_t low = crc ^ little(at), high = little(at + 4);
    crc = kCrc[7][low & 0xff] ^ kCrc[6][(low >> 8) & 0xff] ^ kCrc[5][(low >> 16) & 0xff] ^
          kCrc[4][low >> 24] ^ kCrc[3][high & 0xff] ^ kCrc[2][(high >> 8) & 0xff] ^
          kCrc[1][(high >> 16) & 0xff] ^ kCrc[0][high >> 24];
  }
  for (; left > 0; ++at, --left) crc = (crc >> 8) ^ kCrc[0][(crc ^ static_cast<unsigned char>(*at)) & 0xff];
  return ~crc;
}

void append_frame(std::string& out, Type type, std::uint32_t stream, std::string_view body) {
  char header[kHeaderBytes];
  std::memcpy(header, kMagic.data(), 4);
  header[4] = static_cast<char>(kVersion);
  header[5] = static_cast<char>(type);
  put_big<std::uint16_t>(header + 6, 0);
  put_big<std::uint32_t>(header + 8, stream);
  put_big<std::uint32_t>(header + 12, static_cast<std::uint32_t>(body.size()));
  put_big<std::uint32_t>(header + 16, crc32(body));
  out.append(header, kHeaderBytes).append(body);
}

std::span<char> FrameReader::space() {
  if (begin_ == end_) {
    begin_ = end_ = 0;
    if (buffer_.size() > kKeepCapacity) {
      buffer_.clear();
      buffer_.shrink_to_fit();
    }
  }
  if (buffer_.size() - end_ < kLeastSpace) {
    if (begin_ > 0) {
      std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
      end_ -= begin_;
      begin_ = 0;
    }
    // Never more than one biggest frame and one read: next() took every whole frame out before.
    if (buffer_.size() - end_ < kLeastSpace) buffer_.resize(end_ + kReadAhead);
  }
  return {buffer_.data() + end_, buffer_.size() - end_};
}

void FrameReader::received(std::size_t bytes) {
  end_ += std::min(bytes, buffer_.size() - end_);
}

FrameReader::Status FrameReader::fail(std::string why) {
  fault_ = std::move(why);
  return Status::malformed;
}

FrameReader::Status FrameReader::next(Frame& frame) {
  if (!fault_.empty()) return Status::malformed;
  const char* at = buffer_.data() + begin_;
  const std::size_t have = end_ - begin_;
  // The magic is judged by its first bytes: whatever speaks another protocol need not send twenty of them.
  if (std::memcmp(at, kMagic.data(), std::min<std::size_t>(have, 4)) != 0)
    return fail("not a Headstock frame");
  if (have < kHeaderBytes) return Status::need_more;
  const auto version = static_cast<std::uint8_t>(at[4]);
  if (version != kVersion) {
    foreign_version_ = true;
    return fail("version " + std::to_string(version) + " of the link is not spoken here");
  }
  frame.type = static_cast<Type>(static_cast<std::uint8_t>(at[5]));
  frame.flags = get_big<std::uint16_t>(at + 6);
  frame.stream = get_big<std::uint32_t>(at + 8);
  const auto length = get_big<std::uint32_t>(at + 12);
  const std::size_t limit = frame.type == Type::data ? kMaxDataBytes : kMaxControlBytes;
  if (length > limit)
    return fail("a frame of " + std::to_string(length) + " bytes, more than " + std::to_string(limit));
  if (have < kHeaderBytes + length) return Status::need_more;
  frame.body = {at + kHeaderBytes, length};
  if (crc32(frame.body) != get_big<std::uint32_t>(at + 16)) return fail("a frame with a wrong check sum");
  begin_ += kHeaderBytes + length;
  return Status::frame;
}

}  // namespace headstock::wire

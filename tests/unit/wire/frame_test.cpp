// Frames: what goes in comes out, however it is cut; every bound is kept before memory is spent.
#include "protocol/wire/frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace headstock::wire {
namespace {

std::string frame(Type type, std::string_view body, std::uint32_t stream = 0) {
  std::string out;
  append_frame(out, type, stream, body);
  return out;
}

/// Feeds at most `piece` bytes at a time. @return the fault, or "" when all was read into `bodies`.
std::string read(std::string_view bytes, std::size_t piece, std::vector<std::string>& bodies,
                 FrameReader& reader) {
  Frame next;
  while (true) {
    const auto status = reader.next(next);
    if (status == FrameReader::Status::malformed) return reader.fault();
    if (status == FrameReader::Status::frame) {
      bodies.emplace_back(next.body);
      continue;
    }
    if (bytes.empty()) return "";
    const auto into = reader.space();
    const std::size_t count = std::min({piece, bytes.size(), into.size()});
    std::copy_n(bytes.data(), count, into.data());
    reader.received(count);
    bytes.remove_prefix(count);
  }
}

std::string read(std::string_view bytes, std::size_t piece = 1'000'000) {
  std::vector<std::string> bodies;
  FrameReader reader;
  return read(bytes, piece, bodies, reader);
}

TEST(Crc32, KnownValues) {
  EXPECT_EQ(crc32("123456789"), 0xCBF43926u);
  EXPECT_EQ(crc32(""), 0u);
  // Every length around the eight-byte step against the definition, bit by bit.
  std::string text;
  for (int n = 0; n < 40; ++n) {
    std::uint32_t slow = 0xffffffffu;
    for (const char c : text) {
      slow ^= static_cast<unsigned char>(c);
      for (int bit = 0; bit < 8; ++bit) slow = (slow >> 1) ^ ((slow & 1) ? 0xEDB88320u : 0u);
    }
    EXPECT_EQ(crc32(text), ~slow) << n;
    text += static_cast<char>(n * 37);
  }
}

TEST(Frame, HeaderIsAsDescribed) {
  const std::string bytes = frame(Type::data, "ab", 0x01020304);
  ASSERT_EQ(bytes.size(), 22u);
  EXPECT_EQ(bytes.substr(0, 16), std::string("HSTK\x01\x2d\0\0\x01\x02\x03\x04\0\0\0\x02", 16));
}

TEST(Frame, CutAnywhereItIsTheSame) {
  std::mt19937 random(3);
  std::vector<std::string> sent;
  std::string bytes;
  for (int n = 0; n < 60; ++n) {
    std::string body(random() % (n % 10 == 0 ? kMaxDataBytes : 300), '\0');
    for (char& c : body) c = static_cast<char>(random());
    bytes += frame(Type::data, body, static_cast<std::uint32_t>(n));
    sent.push_back(std::move(body));
  }
  for (const std::size_t piece : {1u, 7u, 20u, 1'000u, 65'536u, 1'000'000u}) {
    std::vector<std::string> received;
    FrameReader reader;
    EXPECT_EQ(read(bytes, piece, received, reader), "");
    EXPECT_EQ(received, sent) << piece;
    EXPECT_LE(reader.capacity(), 600u << 10);
  }
}

TEST(Frame, BoundsAreExact) {
  EXPECT_EQ(read(frame(Type::data, std::string(kMaxDataBytes, 'x'))), "");
  EXPECT_NE(read(frame(Type::data, std::string(kMaxDataBytes + 1, 'x'))), "");
  EXPECT_EQ(read(frame(Type::live, std::string(kMaxControlBytes, 'x'))), "");
  EXPECT_NE(read(frame(Type::live, std::string(kMaxControlBytes + 1, 'x'))), "");
}

TEST(Frame, TwoGigabytesAreRefusedByTheHeaderAlone) {
  std::string bytes = frame(Type::live, "");
  bytes[12] = '\x7f';
  bytes[13] = bytes[14] = bytes[15] = '\xff';
  std::vector<std::string> bodies;
  FrameReader reader;
  EXPECT_EQ(read(bytes, 100, bodies, reader), "a frame of 2147483647 bytes, more than 1048576");
  EXPECT_LE(reader.capacity(), 256u << 10);
  Frame next;
  EXPECT_EQ(reader.next(next), FrameReader::Status::malformed) << "lost for good";
}

TEST(Frame, EveryFlippedBitIsNoticedOrHarmless) {
  const std::string good = frame(Type::live, "some body of a frame", 5);
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    std::string bad = good;
    bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << (bit % 8)));
    std::vector<std::string> bodies;
    FrameReader reader;
    const std::string fault = read(bad, 1'000, bodies, reader);
    const std::size_t byte = bit / 8;
    if (byte < 5 || byte >= 16) {
      EXPECT_NE(fault, "") << bit;  // magic, version, check sum, body
    } else if (byte >= 12) {
      EXPECT_TRUE(bodies.empty()) << "another length is no frame";
    }
  }
}

TEST(Frame, CutFramesAreNotFrames) {
  const std::string good = frame(Type::live, "body");
  for (std::size_t length = 0; length < good.size(); ++length) {
    std::vector<std::string> bodies;
    FrameReader reader;
    EXPECT_EQ(read(good.substr(0, length), 3, bodies, reader), "");
    EXPECT_TRUE(bodies.empty());
  }
}

TEST(Frame, AnotherProtocolIsKnownByItsFirstByte) {
  EXPECT_EQ(read("G"), "not a Headstock frame");
  EXPECT_EQ(read("HSTX"), "not a Headstock frame");
}

TEST(Frame, ForeignVersionIsMarked) {
  std::string bytes = frame(Type::hello, "");
  bytes[4] = 2;
  std::vector<std::string> bodies;
  FrameReader reader;
  EXPECT_NE(read(bytes, 100, bodies, reader), "");
  EXPECT_TRUE(reader.foreign_version());
}

TEST(Frame, UnknownTypesAreFramesLikeOthers) {
  EXPECT_EQ(read(frame(static_cast<Type>(250), "x")), "");
}

}  // namespace
}  // namespace headstock::wire

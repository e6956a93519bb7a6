// Frames of the link: a 20-byte header and a body (protocol/wire/README.md). Every length is checked before a
// byte of memory is spent on it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace headstock::wire {

inline constexpr std::uint8_t kVersion = 1;
inline constexpr std::size_t kHeaderBytes = 20;
inline constexpr std::size_t kMaxControlBytes = 1u << 20;
inline constexpr std::size_t kMaxDataBytes = 64u << 10;

enum class Type : std::uint8_t {
  hello = 1,
  welcome = 2,
  refuse = 3,
  ping = 4,
  pong = 5,
  enrol = 10,
  enrolled = 11,
  renew = 12,
  certificate_stored = 13,
  certificate_current = 14,
  live = 20,
  events = 21,
  events_ack = 22,
  census = 23,
  command = 30,
  command_result = 31,
  program_put = 40,
  program_get = 41,
  program_delete = 42,
  drip_open = 43,
  credit = 44,
  data = 45,
  data_end = 46,
  transfer_result = 47,
  transfer_cancel = 48,
  drip_resume = 49,
  transfer_closed = 50,
  program_request = 51,
  request_answer = 52,
  data_report = 60,
  data_write = 61,
  data_result = 62
};

/// One frame; `body` points into the reader and stays valid until the reader is used again.
struct Frame {
  Type type = Type::ping;
  std::uint16_t flags = 0;
  std::uint32_t stream = 0;
  std::string_view body;
};

/// CRC-32 (IEEE 802.3, as in zlib) of `bytes`.
std::uint32_t crc32(std::string_view bytes);

/// Appends a frame. The caller keeps the bounds: at most kMaxDataBytes for data, kMaxControlBytes otherwise.
void append_frame(std::string& out, Type type, std::uint32_t stream, std::string_view body);

/// Cuts a byte stream into frames. One thread.
class FrameReader {
 public:
  enum class Status { frame, need_more, malformed };

  /// Where the next bytes may be written (never empty); invalidates the last frame's body.
  std::span<char> space();
  void received(std::size_t bytes);
  /// @return malformed: what is wrong is in fault(), and the stream is lost for good.
  Status next(Frame& frame);

  const std::string& fault() const { return fault_; }
  /// The fault is a version this side does not speak.
  bool foreign_version() const { return foreign_version_; }
  std::size_t capacity() const { return buffer_.size(); }

 private:
  Status fail(std::string why);

  std::string buffer_;
  std::size_t begin_ = 0, end_ = 0;  // unread bytes
  std::string fault_;
  bool foreign_version_ = false;
};

}  // namespace headstock::wire

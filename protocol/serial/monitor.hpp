// What went over a line, for a person who looks for a wrong cable: every byte both ways, handshake lines,
// errors, in order and with its time. Bounded: the newest is kept. One thread.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

namespace headstock::serial {

struct MonitorEntry {
  enum Kind : std::uint8_t { in, out, signals, fault, note };
  std::uint64_t sequence = 0;  ///< from 1, without gaps
  std::int64_t at_ms = 0;      ///< Unix time of its first byte
  Kind kind = in;
  std::string data;  ///< bytes; of signals "RTS DTR CTS", of faults and notes a message key
};
std::string_view name_of(MonitorEntry::Kind kind);

class Monitor {
 public:
  /// @param most_bytes kept, entries included.
  explicit Monitor(std::size_t most_bytes = 64u << 10) : most_bytes_(most_bytes) {}
  /// Bytes that follow one another in one direction become one entry, up to 256 of them or 100 ms.
  void bytes(MonitorEntry::Kind direction, std::string_view bytes, std::int64_t now_ms);
  void add(MonitorEntry::Kind kind, std::string text, std::int64_t now_ms);
  /// What came behind entry `after`, at most `most` entries; the last entry of a direction may still have
  /// grown when it is asked for again, so a reader asks from the last but one.
  std::vector<MonitorEntry> since(std::uint64_t after, std::size_t most) const;
  std::uint64_t last() const { return last_; }
  /// Changes with every byte.
  std::uint64_t version() const { return version_; }

 private:
  void trim();
  std::size_t most_bytes_, kept_bytes_ = 0;
  std::uint64_t last_ = 0, version_ = 0;
  std::deque<MonitorEntry> entries_;
};

/// Control characters by name and in angle brackets, other non-printing bytes in hexadecimal:
/// `<DC1>G0X1<LF>`, `<8D>`.
/// @param iso bit 8 is parity and is taken off first.
std::string readable(std::string_view bytes, bool iso);
/// "11 47 30"
std::string hexadecimal(std::string_view bytes);

}  // namespace headstock::serial

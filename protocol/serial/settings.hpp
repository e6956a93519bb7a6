// How a serial line is set: speed, character frame, handshake. Plain values, any thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace headstock::serial {

enum class Parity { none, even, odd, mark, space };
enum class Handshake {
  none,
  software,  ///< DC1/DC3 (XON/XOFF), both ways
  hardware,  ///< RTS/CTS
  both
};

struct LineSettings {
  std::uint32_t baud = 9'600;  ///< 50…921,600; speeds without a name of their own too, where the device can
  std::uint8_t data_bits = 8;  ///< 5…8
  Parity parity = Parity::none;
  std::uint8_t stop_bits = 1;  ///< 1, 2
  Handshake handshake = Handshake::software;

  bool operator==(const LineSettings&) const = default;
  bool software() const { return handshake == Handshake::software || handshake == Handshake::both; }
  bool hardware() const { return handshake == Handshake::hardware || handshake == Handshake::both; }
  /// Start, data, parity and stop bits.
  double bits_a_character() const { return 1.0 + data_bits + (parity == Parity::none ? 0 : 1) + stop_bits; }
  double characters_s() const { return baud / bits_a_character(); }
  std::chrono::nanoseconds character_time() const {
    return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / characters_s()));
  }
};

/// "9600-8-E-1-software"; the last part may be left out (software).
std::string to_text(const LineSettings& settings);
/// @return nothing when it is not of that form or not allowed.
std::optional<LineSettings> settings_of(std::string_view text);
/// @return the field that is out of its range ("baud", "data_bits", "stop_bits"), empty when all are good.
std::string_view wrong_field(const LineSettings& settings);

std::string_view name_of(Parity parity);        ///< "none" "even" "odd" "mark" "space"
std::string_view name_of(Handshake handshake);  ///< "none" "software" "hardware" "both"
std::optional<Parity> parity_named(std::string_view name);
std::optional<Handshake> handshake_named(std::string_view name);

/// The lines beside the data.
struct Signals {
  bool rts = false, dtr = false;                             ///< ours
  bool cts = false, dsr = false, dcd = false, ring = false;  ///< the other side's
  bool known = false;                                        ///< false: this kind of port has no such lines
  bool operator==(const Signals&) const = default;
};

}  // namespace headstock::serial

#include "protocol/serial/settings.hpp"

#include <array>
#include <charconv>

namespace headstock::serial {
namespace {

constexpr std::array<std::string_view, 5> kParities = {"none", "even", "odd", "mark", "space"};
constexpr std::array<std::string_view, 4> kHandshakes = {"none", "software", "hardware", "both"};
constexpr std::string_view kParityLetters = "NEOMS";

template <class Enum, std::size_t N>
std::optional<Enum> named(const std::array<std::string_view, N>& names, std::string_view name) {
  for (std::size_t at = 0; at < N; ++at)
    if (names[at] == name) return static_cast<Enum>(at);
  return std::nullopt;
}

std::string_view next_part(std::string_view& text) {
  const auto end = text.find('-');
  const auto part = text.substr(0, end);
  text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  return part;
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
  unsigned value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || value > 1'000'000) return false;
  number = static_cast<Number>(value);
  return value == number;
}

}  // namespace

std::string_view name_of(Parity parity) {
  return kParities[static_cast<std::size_t>(parity)];
}
std::string_view name_of(Handshake handshake) {
  return kHandshakes[static_cast<std::size_t>(handshake)];
}
std::optional<Parity> parity_named(std::string_view name) {
  return named<Parity>(kParities, name);
}
std::optional<Handshake> handshake_named(std::string_view name) {
  return named<Handshake>(kHandshakes, name);
}

std::string to_text(const LineSettings& settings) {
  std::string text = std::to_string(settings.baud);
  for (const char c : {'-', static_cast<char>('0' + settings.data_bits), '-',
                       kParityLetters[static_cast<std::size_t>(settings.parity)], '-',
                       static_cast<char>('0' + settings.stop_bits), '-'})
    text += c;
  return text += name_of(settings.handshake);
}

std::optional<LineSettings> settings_of(std::string_view text) {
  LineSettings settings;
  if (!read_number(next_part(text), settings.baud) || !read_number(next_part(text), settings.data_bits))
    return std::nullopt;
  const auto parity = next_part(text);
  const auto letter = parity.size() == 1 ? kParityLetters.find(parity[0]) : std::string_view::npos;
  if (letter == std::string_view::npos) return std::nullopt;
  settings.parity = static_cast<Parity>(letter);
  if (text.ends_with('-') || !read_number(next_part(text), settings.stop_bits)) return std::nullopt;
  if (!text.empty()) {
    const auto handshake = handshake_named(text);
    if (!handshake) return std::nullopt;
    settings.handshake = *handshake;
  }
  if (!wrong_field(settings).empty()) return std::nullopt;
  return settings;
}

std::string_view wrong_field(const LineSettings& settings) {
  if (settings.baud < 50 || settings.baud > 921'600) return "baud";
  if (settings.data_bits < 5 || settings.data_bits > 8) return "data_bits";
  if (settings.stop_bits < 1 || settings.stop_bits > 2) return "stop_bits";
  // DC1 and DC3 need five bits and are told from letters by two more.
  if (settings.software() && settings.data_bits < 7) return "handshake";
  return "";
}

}  // namespace headstock::serial

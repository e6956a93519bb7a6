#include "agent/dnc_settings.hpp"

#include <charconv>
#include <vector>

namespace headstock::agent {
namespace {

constexpr std::string_view kListen = "listen://";
constexpr std::size_t kLeastBuffer = 1'024, kMostBuffer = 1u << 20, kLeastAfterStop = 10;

std::vector<std::string_view> parts_of(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto comma = text.find(',');
    parts.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

template <class Number>
bool read_number(std::string_view text, Number least, Number most, Number& into) {
  Number value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < least || value > most) return false;
  into = value;
  return true;
}

bool read_port(std::string_view text, DncSettings& settings) {
  settings.port = text;
  if (!text.starts_with(kListen)) {
    settings.address = serial::address_of(text);
    return settings.address.has_value();
  }
  text.remove_prefix(kListen.size());
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  settings.listen_address = text.substr(0, colon);
  return read_number<std::uint16_t>(text.substr(colon + 1), 0, 65'535, settings.listen_port);
}

}  // namespace

std::string read_dnc_settings(std::string_view text, DncSettings& settings) {
  DncSettings read;
  const auto parts = parts_of(text);
  if (!read_port(parts[0], read))
    return std::string(parts[0]) +
           ": not a device, tcp://HOST:PORT, rfc2217://HOST:PORT or listen://ADDRESS:PORT";
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const auto equals = parts[i].find('=');
    const std::string_view key = parts[i].substr(0, equals);
    const std::string_view value = equals == std::string_view::npos ? "" : parts[i].substr(equals + 1);
    bool good = false;
    if (key == "line") {
      const auto line = serial::settings_of(value);
      good = line.has_value();
      if (good) read.line = *line;
    } else if (key == "code") {
      const auto code = tape::code_named(value);
      good = code.has_value();
      if (good) read.code = *code;
    } else if (key == "buffer") {
      good = read_number(value, kLeastBuffer, kMostBuffer, read.buffer);
    } else if (key == "after-stop") {
      good = read_number(value, kLeastAfterStop, kMostBuffer / 2, read.after_stop);
    } else if (parts[i] == "tv-check") {
      good = read.tv_check = true;
    } else if (parts[i] == "any-start") {
      good = read.any_start = true;
    }
    if (!good) return std::string(parts[i]) + ": not a setting of the DNC line, or not one of its values";
  }
  if (read.buffer < 2 * read.after_stop) read.buffer = 2 * read.after_stop + 2;
  settings = std::move(read);
  return {};
}

}  // namespace headstock::agent

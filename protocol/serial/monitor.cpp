#include "protocol/serial/monitor.hpp"

#include <algorithm>

#include "protocol/tape/code.hpp"

namespace headstock::serial {
namespace {

constexpr std::size_t kEntryBytes = 256, kEntryCost = 64;
constexpr std::int64_t kEntryMs = 100;
constexpr char kDigits[] = "0123456789ABCDEF";

}  // namespace

std::string_view name_of(MonitorEntry::Kind kind) {
  constexpr std::string_view names[] = {"in", "out", "signals", "fault", "note"};
  return names[kind];
}

void Monitor::trim() {
  while (kept_bytes_ > most_bytes_ && entries_.size() > 1) {
    kept_bytes_ -= entries_.front().data.size() + kEntryCost;
    entries_.pop_front();
  }
}

void Monitor::bytes(MonitorEntry::Kind direction, std::string_view bytes, std::int64_t now_ms) {
  while (!bytes.empty()) {
    ++version_;
    const bool goes_on = !entries_.empty() && entries_.back().kind == direction &&
                         entries_.back().data.size() < kEntryBytes &&
                         now_ms - entries_.back().at_ms < kEntryMs;
    if (!goes_on) {
      entries_.push_back({++last_, now_ms, direction, {}});
      kept_bytes_ += kEntryCost;
    }
    std::string& data = entries_.back().data;
    const std::size_t count = std::min(bytes.size(), kEntryBytes - data.size());
    data += bytes.substr(0, count);
    kept_bytes_ += count;
    bytes.remove_prefix(count);
  }
  trim();
}

void Monitor::add(MonitorEntry::Kind kind, std::string text, std::int64_t now_ms) {
  ++version_;
  kept_bytes_ += text.size() + kEntryCost;
  entries_.push_back({++last_, now_ms, kind, std::move(text)});
  trim();
}

std::vector<MonitorEntry> Monitor::since(std::uint64_t after, std::size_t most) const {
  std::vector<MonitorEntry> found;
  for (const MonitorEntry& entry : entries_) {
    if (entry.sequence <= after) continue;
    if (found.size() == most) break;
    found.push_back(entry);
  }
  return found;
}

std::string readable(std::string_view bytes, bool iso) {
  std::string text;
  for (const char byte : bytes) {
    const auto value = static_cast<std::uint8_t>(static_cast<std::uint8_t>(byte) & (iso ? 0x7F : 0xFF));
    const auto name = tape::control_name(value);
    if (!name.empty()) {
      text.append(1, '<').append(name).append(1, '>');
    } else if (value < 0x7F) {
      text += static_cast<char>(value);
    } else {
      for (const char c : {'<', kDigits[value >> 4], kDigits[value & 15u], '>'}) text += c;
    }
  }
  return text;
}

std::string hexadecimal(std::string_view bytes) {
  std::string text;
  for (const char byte : bytes) {
    const auto value = static_cast<std::uint8_t>(byte);
    if (!text.empty()) text += ' ';
    text += kDigits[value >> 4];
    text += kDigits[value & 15u];
  }
  return text;
}

}  // namespace headstock::serial

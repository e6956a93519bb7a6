#include "server/dnc/punched_values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <string>

#include "dialects/catalogue.hpp"
#include "protocol/tape/machine_data.hpp"

namespace headstock::dnc {
namespace {

constexpr unsigned kBits = 8;

std::optional<double> number_of(std::string_view text) {
  double value = 0;
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// Digits at the front of `text`, taken off.
std::optional<unsigned> take_digits(std::string_view& text) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

class Reader {
 public:
  Reader(const fleet::MachinePages& pages, PunchedValues& found) : pages_(pages), found_(found) {}

  void entry(const tape::DataEntry& entry) {
    const bool read = entry.item.starts_with("No.")      ? parameter(entry)
                      : entry.item.starts_with("group ") ? life(entry)
                                                         : true;  // named_values has it, or counted below
    found_.not_read += !read;
  }

 private:
  void put(std::string what, double value) { found_.values.insert_or_assign(std::move(what), value); }

  bool known(const std::string& key, dialects::Parameter& row) const {
    return dialects::find_parameter(pages_.machine.profile, key, row);
  }

  /// The profile's own way to write a number: "1320", "P017", "P0017".
  std::optional<std::string> key_of(unsigned number, dialects::Parameter& row) const {
    for (const char* form : {"{:04}", "P{:03}", "P{:04}"}) {
      std::string key = fmt::format(fmt::runtime(form), number);
      if (known(key, row)) return key;
      for (unsigned bit = 0; bit < kBits; ++bit)
        for (const char mark : {'#', '.'})
          if (known(key + mark + std::to_string(bit), row)) return key;
    }
    return std::nullopt;
  }

  bool parameter(const tape::DataEntry& entry) {
    std::string_view rest = std::string_view(entry.item).substr(3);
    const auto number = take_digits(rest);
    dialects::Parameter row;
    const auto key = number ? key_of(*number, row) : std::nullopt;
    if (!key) return false;
    std::string suffix;
    if (rest.starts_with(" A")) {
      rest.remove_prefix(2);
      const auto axis = take_digits(rest);
      if (!axis || *axis == 0 || *axis > pages_.axes.size()) return false;
      suffix = std::string("/") + pages_.axes[*axis - 1];
    }
    if (!rest.empty()) return false;  // of a spindle, a tool, a path
    const char mark = row.number.find('#') != row.number.npos   ? '#'
                      : row.number.find('.') != row.number.npos ? '.'
                                                                : ' ';
    if (mark != ' ') return bits("parameter/" + *key + mark, suffix, entry.value, *key);
    const auto value = number_of(entry.value);
    if (!value) return false;
    const bool length = row.unit.find("mm") != row.unit.npos || row.unit.find("deg") != row.unit.npos;
    if (length && entry.value.find('.') == entry.value.npos) return false;
    put("parameter/" + *key + suffix, *value);
    return true;
  }

  /// Eight digits, bit 7 first. Those that the catalogue does not know are reserved.
  bool bits(const std::string& head, const std::string& suffix, const std::string& digits,
            const std::string& key) {
    if (digits.size() != kBits || digits.find_first_not_of("01") != digits.npos) return false;
    dialects::Parameter row;
    for (unsigned bit = 0; bit < kBits; ++bit)
      if (known(key + head.back() + std::to_string(bit), row))
        put(head + std::to_string(bit) + suffix, digits[kBits - 1 - bit] == '1' ? 1 : 0);
    return true;
  }

  /// T0203: tool 2, offset 3.
  unsigned split() const {
    const auto& tools = pages_.dialect->tools;
    const double digits = pages_.data.parameter(tools.offset_digits_parameter, tools.offset_digits);
    return digits == 1 ? 10 : digits == 3 ? 1'000 : 100;
  }

  /// Of one unit of a life by time.
  double seconds() const { return pages_.data.bit(pages_.dialect->life.tenths_word_parameter) ? 0.1 : 60; }

  /// "group 1 life" 30, "group 1 kind" 2, "group 1 tool 1" T11H11D11.
  bool life(const tape::DataEntry& entry) {
    std::string_view rest = std::string_view(entry.item).substr(std::string_view("group ").size());
    const auto group = take_digits(rest);
    if (!group || *group == 0) return false;
    const std::string head = "tool_life/" + std::to_string(*group) + "/";
    if (rest == " life") {
      const auto value = number_of(entry.value);
      if (!value) return false;
      const bool by_time = pages_.data.bit(pages_.dialect->life.by_time_parameter);
      put(head + "unit", by_time ? 1 : 0);
      put(head + "life", by_time ? *value * seconds() : *value);
      return true;
    }
    if (rest == " kind") {
      const auto life = found_.values.find(head + "life");
      if (life == found_.values.end() || (entry.value != "1" && entry.value != "2")) return false;
      const bool by_time = entry.value == "2", was = found_.values[head + "unit"] == 1;
      if (by_time != was) life->second = by_time ? life->second * seconds() : life->second / seconds();
      found_.values[head + "unit"] = by_time ? 1 : 0;
      return true;
    }
    if (!rest.starts_with(" tool ")) return false;
    rest.remove_prefix(std::string_view(" tool ").size());
    const auto place = take_digits(rest);
    return place && *place > 0 && tool(head, std::to_string(*place - 1), entry.value);
  }

  bool tool(const std::string& head, const std::string& place, std::string_view words) {
    while (!words.empty()) {
      const char address = words.front();
      words.remove_prefix(1);
      const auto number = take_digits(words);
      if (!number) return false;
      if (address == 'H' || address == 'D') {
        put(head + (address == 'H' ? "h/" : "d/") + place, *number);
      } else if (address == 'T' && pages_.dialect->life.form == dialects::ToolLifeRules::Form::turret) {
        put(head + "tool/" + place, *number / split());
        put(head + "offset/" + place, *number % split());
      } else if (address == 'T') {
        put(head + "tool/" + place, *number);
      } else {
        return false;
      }
    }
    return true;
  }

  const fleet::MachinePages& pages_;
  PunchedValues& found_;
};

}  // namespace

PunchedValues punched_values(const fleet::MachinePages& pages, std::string_view text) {
  PunchedValues found;
  for (const tape::NamedValue& one : tape::named_values(text))
    found.values.insert_or_assign(one.what, one.value);
  Reader reader(pages, found);
  for (const tape::DataEntry& entry : tape::machine_data(text)) reader.entry(entry);
  return found;
}

}  // namespace headstock::dnc

// Build tool: what the sources of the controllers really raise and read, for the coverage report. It lists
// the string constants that look like a controller's number ("PS0010", "3402#0", "P154", "067") with the file
// that holds them, and the alarm reasons that some code raises. Reading the sources, it cannot claim what is
// not there. Usage: cite_sources ROOT ALARM_REASON_HEADER OUT_HEADER FILE…
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

bool letter(char c) {
  return c >= 'A' && c <= 'Z';
}
bool digit(char c) {
  return c >= '0' && c <= '9';
}
bool name_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

// Letters, digits, perhaps "#3" or ".3"; "1241/" stands for the parameter of every axis.
std::string number_of(std::string_view text) {
  if (text.ends_with('/')) text.remove_suffix(1);
  std::size_t i = 0;
  while (i < text.size() && letter(text[i])) ++i;
  const std::size_t digits = i;
  while (i < text.size() && digit(text[i])) ++i;
  if (digits > 3 || i == digits || text.size() < 3) return {};
  if (i + 1 < text.size() && (text[i] == '#' || text[i] == '.') && digit(text[i + 1])) i += 2;
  while (i < text.size() && digit(text[i])) ++i;
  return i == text.size() ? std::string(text) : std::string();
}

// "gsk-218t", "fanuc-0i", "k2000tc": what stands behind it in the row of a table is said of these controllers only.
bool names_controllers(std::string_view text) {
  const auto allowed = [](char c) { return (c >= 'a' && c <= 'z') || digit(c) || c == '-'; };
  return !text.empty() && text[0] >= 'a' && text[0] <= 'z' && std::ranges::all_of(text, allowed) &&
         std::ranges::any_of(text, digit);
}

struct Cited {
  std::string number;
  std::string place;
  std::string controllers;  // beginning of their profiles' names; empty: all that the place speaks for
  char kind;  // 'p': a parameter, 'a': an alarm, '?': the line does not say
  auto operator<=>(const Cited&) const = default;
};

struct Found {
  std::set<Cited> cited;
  std::set<std::string> raised;
};

// The reasons that a dialect's table gives a number to are not raised there: `{R::nesting, "077"}`.
bool is_numbered(std::string_view after) {
  std::size_t i = 0;
  const auto skip_spaces = [&] {
    while (i < after.size() && std::isspace(static_cast<unsigned char>(after[i])) != 0) ++i;
  };
  skip_spaces();
  if (i >= after.size() || after[i] != ',') return false;
  ++i;
  skip_spaces();
  return i < after.size() && after[i] == '"';
}

// …, nor is one reason paired with another whose number it takes over: `{R::scale_value, R::value_range}`.
std::string without_pairs(std::string_view text) {
  static const std::regex pair(R"(\{\s*(AlarmReason|R)::\w+,\s*(AlarmReason|R)::\w+\s*\})");
  return std::regex_replace(std::string(text), pair, "{}");
}

void scan_reasons(std::string_view whole, Found& found) {
  const std::string text = without_pairs(whole);
  for (const std::string_view prefix : {std::string_view("AlarmReason::"), std::string_view("R::"), std::string_view("Fault::")}) {
    for (std::size_t at = text.find(prefix); at != text.npos; at = text.find(prefix, at + 1)) {
      if (at != 0 && name_character(text[at - 1])) continue;
      std::size_t end = at + prefix.size();
      while (end < text.size() && name_character(text[end])) ++end;
      if (!is_numbered(std::string_view(text).substr(end))) {
        found.raised.emplace(text.substr(at + prefix.size(), end - at - prefix.size()));
      }
    }
  }
}

void scan_line(std::string_view line, const std::string& place, Found& found) {
  const bool parameter = line.find("parameter") != line.npos || line.find("bit(") != line.npos;
  const bool alarm = line.find("alarm") != line.npos;
  const char kind = parameter == alarm ? '?' : parameter ? 'p' : 'a';
  std::string controllers;
  bool inside = false;
  std::size_t start = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (!inside && line[i] == '/' && i + 1 < line.size() && line[i + 1] == '/') return;
    if (!inside && line[i] == '{') controllers.clear();  // the next row of the table
    if (line[i] == '\\') {
      ++i;
    } else if (line[i] == '"') {
      if (inside) {
        std::string_view text = line.substr(start, i - start);
        // "!8136#6 6000#3": conditions of a system variable, each a parameter.
        if (text.find(' ') != text.npos || text.starts_with('!')) {
          std::vector<std::string> all;
          bool numbers = true;
          while (numbers && !text.empty()) {
            std::string_view one = text.substr(0, text.find(' '));
            text.remove_prefix(std::min(text.size(), one.size() + 1));
            if (one.starts_with('!')) one.remove_prefix(1);
            all.push_back(number_of(one));
            numbers = !all.back().empty();
          }
          for (const std::string& one : all)
            if (numbers) found.cited.insert({one, place, controllers, 'p'});
          inside = false;
          start = i + 1;
          continue;
        }
        if (names_controllers(text)) controllers = text;
        const std::string number = number_of(text);
        std::string_view before = line.substr(0, start - 1);
        while (before.ends_with(' ')) before.remove_suffix(1);
        const std::size_t word =
            before.ends_with(',') ? before.find_last_of("{( ", before.size() - 2) : before.npos;
        const bool given_to_reason =
            word != before.npos && before.substr(word + 1).find("R::") != before.npos;
        if (!number.empty() && !given_to_reason) found.cited.insert({number, place, controllers, kind});
      }
      inside = !inside;
      start = i + 1;
    }
  }
}

std::vector<std::string> reasons_of(const std::string& header) {
  std::vector<std::string> names;
  std::istringstream lines(header.substr(header.find("enum class AlarmReason")));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line) && line.find("};") == line.npos) {
    std::size_t i = line.find_first_not_of(' ');
    if (i == line.npos || !std::islower(static_cast<unsigned char>(line[i]))) continue;
    std::size_t end = i;
    while (end < line.size() && name_character(line[end])) ++end;
    names.push_back(line.substr(i, end - i));
  }
  if (!names.empty() && names.back() == "count_") names.pop_back();
  return names;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::cerr << "usage: cite_sources ROOT ALARM_REASON_HEADER OUT FILE...\n";
    return 1;
  }
  const fs::path root = argv[1];
  Found found;
  for (int i = 4; i < argc; ++i) {
    const std::string text = read(argv[i]);
    const std::string place = fs::path(argv[i]).lexically_relative(root).generic_string();
    scan_reasons(text, found);
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) scan_line(line, place, found);
  }
  std::ostringstream out;
  out << "// Made by cite_sources.\n#pragma once\n#include <string_view>\n\nnamespace headstock::tables {\n"
         "struct Citation {\n  std::string_view number, place, controllers;\n  char kind;  // 'p' parameter, 'a' alarm, "
         "'?' either\n};\n"
         "inline constexpr Citation citations[] = {\n";
  for (const auto& one : found.cited)
    out << "    {\"" << one.number << "\", \"" << one.place << "\", \"" << one.controllers << "\", '" << one.kind << "'},\n";
  out << "};\n// By AlarmReason: whether some code raises it.\ninline constexpr bool reason_raised[] = {\n";
  for (const auto& name : reasons_of(read(argv[2])))
    out << "    " << (found.raised.contains(name) ? "true" : "false") << ",  // " << name << '\n';
  out << "};\n}  // namespace headstock::tables\n";
  const fs::path target = argv[3];
  if (fs::exists(target) && read(target) == out.str()) return 0;  // nothing depends on it anew
  fs::create_directories(target.parent_path());
  std::ofstream file(target, std::ios::binary | std::ios::trunc);
  file << out.str();
  if (!file.flush()) {
    std::cerr << target << ": cannot be written\n";
    return 1;
  }
}

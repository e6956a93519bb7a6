#include "protocol/tape/machine_data.hpp"

#include <bit>
#include <cmath>
#include <cstdlib>
#include <map>

namespace headstock::tape {
namespace {

struct Word {
  char address;
  std::string_view number;
};

/// The words of a block, comments left out; nothing when something else is in it.
std::optional<std::vector<Word>> words_of(std::string_view line) {
  std::vector<Word> words;
  for (std::size_t at = 0; at < line.size();) {
    const char c = line[at];
    if (c == ' ' || c == '\t' || c == '\r' || c == ';') {
      ++at;
      continue;
    }
    if (c == '(') {
      const auto close = line.find(')', at);
      if (close == std::string_view::npos) return std::nullopt;
      at = close + 1;
      continue;
    }
    if (c < 'A' || c > 'Z') return std::nullopt;
    auto end = at + 1;
    while (end < line.size() && std::string_view("+-.0123456789").find(line[end]) != std::string_view::npos)
      ++end;
    if (end == at + 1) return std::nullopt;
    words.push_back({c, line.substr(at + 1, end - at - 1)});
    at = end;
  }
  return words;
}

std::string plain_line(std::string_view line) {
  std::string kept;
  for (const char c : line)
    if (c != ' ' && c != '\t' && c != '\r' && c != ';') kept += c;
  return kept;
}

const Word* find(const std::vector<Word>& words, char address) {
  for (const auto& word : words)
    if (word.address == address) return &word;
  return nullptr;
}

/// "017 2": parameters as a plain table (GSK218T L3649).
bool numbered_row(std::string_view line) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  return digit(line[0]) && digit(line[1]) && digit(line[2]) && (line[3] == ' ' || line[3] == '\t');
}

std::string text_of(const Word* word) {
  return word == nullptr ? "" : std::string(word->number);
}

class Reader {
 public:
  std::vector<DataEntry> entries;

  void line(std::string_view text) {
    const std::string plain = plain_line(text);
    if (plain.empty() || plain.front() == '%' || plain == "M30" || plain == "M02") return;
    const auto words = words_of(text);
    if (text.size() > 3 && numbered_row(text))
      return put("No." + std::string(text.substr(0, 3)), plain.substr(3));
    if (plain.starts_with("G10L85")) return variable(plain, words);
    if (!words || words->empty()) return put(plain, "");
    const auto& first = words->front();
    if (first.address == 'N') return parameter(*words);
    const Word* const l = find(*words, 'L');
    if (first.address == 'G' && first.number == "10" && l != nullptr && l->number == "3")
      return;  // tool life begins
    if (first.address == 'G' && first.number == "11") return;
    if (first.address == 'G' && first.number == "10") return offset(*words, text_of(l));
    if (first.address == 'P') return group(*words);
    if (first.address == 'T') return tool(*words);
    put(plain, "");
  }

 private:
  void put(const std::string& item, std::string value) {
    const auto [place, fresh] = places_.emplace(item, entries.size());
    if (fresh) {
      entries.push_back({item, std::move(value)});
    } else {
      entries[place->second].value = std::move(value);
    }
  }
  void offset(const std::vector<Word>& words, const std::string& l) {
    const std::string head = (l.empty() ? "" : "L" + l + " ") + "P" + text_of(find(words, 'P'));
    for (const auto& word : words)
      if (word.address != 'G' && word.address != 'L' && word.address != 'P')
        put(head + " " + word.address, std::string(word.number));
  }
  /// N1320 A1 P500 A2 P600; N0020 P4; N1001 Q0 P-3 (pitch error)
  void parameter(const std::vector<Word>& words) {
    const std::string head = "No." + text_of(&words.front());
    std::string part;
    for (const auto& word : words) {
      if (word.address == 'N' || word.address == 'Q') continue;
      if (word.address == 'P') {
        put(head + part, std::string(word.number));
        part.clear();
      } else {
        part += std::string(" ") + word.address + std::string(word.number);
      }
    }
  }
  /// G10 L85 P100 (4024000000000000): the value stands as a hexadecimal number in the comment.
  void variable(const std::string& plain, const std::optional<std::vector<Word>>& words) {
    const auto open = plain.find('('), close = plain.find(')');
    if (!words || open == std::string::npos || close == std::string::npos) return put(plain, "");
    put("#" + text_of(find(*words, 'P')), plain.substr(open + 1, close - open - 1));
  }
  void group(const std::vector<Word>& words) {
    group_ = text_of(&words.front());
    tools_ = 0;
    put("group " + group_ + " life", text_of(find(words, 'L')));
    if (const auto* kind = find(words, 'Q')) put("group " + group_ + " kind", std::string(kind->number));
  }
  void tool(const std::vector<Word>& words) {
    std::string value;
    for (const auto& word : words) value += word.address + std::string(word.number);
    put("group " + group_ + " tool " + std::to_string(++tools_), value);
  }

  std::map<std::string, std::size_t> places_;
  std::string group_;
  int tools_ = 0;
};

template <class Each>
void each_line(std::string_view text, Each each) {
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    each(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

}  // namespace

std::vector<DataEntry> machine_data(std::string_view text) {
  Reader reader;
  each_line(text, [&](std::string_view line) { reader.line(line); });
  return std::move(reader.entries);
}

std::vector<DataChange> changes(const std::vector<DataEntry>& before, const std::vector<DataEntry>& after) {
  std::map<std::string, std::string> was;
  for (const auto& entry : before) was[entry.item] = entry.value;
  std::vector<DataChange> found;
  for (const auto& entry : after) {
    const auto known = was.find(entry.item);
    if (known == was.end()) {
      found.push_back({entry.item, std::nullopt, entry.value});
    } else {
      if (known->second != entry.value) found.push_back({entry.item, known->second, entry.value});
      was.erase(known);
    }
  }
  for (const auto& entry : before)
    if (was.contains(entry.item)) found.push_back({entry.item, entry.value, std::nullopt});
  return found;
}

namespace {

constexpr unsigned long kGeometry = 10'000;  ///< P10003: geometry of tool 3

double number_of(const Word& word) {
  return std::strtod(std::string(word.number).c_str(), nullptr);
}

void name_work_offset(const std::vector<Word>& words, const std::string& l, unsigned long number,
                      std::vector<NamedValue>& found) {
  std::string system;
  if (l == "20") {
    system = "G54.1P" + std::to_string(number);
  } else {
    if (number > 6) return;
    system = number == 0 ? "EXT" : "G" + std::to_string(53 + number);
  }
  for (const auto& word : words)
    if (std::string_view("XYZABCUVW").find(word.address) != std::string_view::npos)
      found.push_back({"work/" + system + "/" + word.address, number_of(word)});
}

void name_tool_offset(const std::vector<Word>& words, const std::string& l, unsigned long number,
                      std::vector<NamedValue>& found) {
  struct Mill {
    std::string_view l, field;
  };
  constexpr Mill kMill[] = {{"10", "geometry/Z"}, {"11", "wear/Z"}, {"12", "radius"}, {"13", "radius_wear"}};
  const bool wear = number <= kGeometry;
  const std::string tool = "tool/" + std::to_string(wear ? number : number - kGeometry) + "/";
  for (const auto& word : words) {
    if (!l.empty()) {
      for (const auto& row : kMill)
        if (row.l == l && word.address == 'R')
          found.push_back({tool + std::string(row.field), number_of(word)});
    } else if (word.address == 'X' || word.address == 'Y' || word.address == 'Z') {
      found.push_back({tool + (wear ? "wear/" : "geometry/") + word.address, number_of(word)});
    } else if (word.address == 'R') {
      found.push_back({tool + (wear ? "radius_wear" : "radius"), number_of(word)});
    } else if (word.address == 'Q') {
      found.push_back({tool + "tip", number_of(word)});
    }
  }
}

/// G10 L85 P500(4028000000000000): the bits of a double.
void name_variable(std::string_view line, unsigned long number, std::vector<NamedValue>& found) {
  const auto open = line.find('('), close = line.find(')', open);
  if (open == std::string_view::npos || close == std::string_view::npos) return;
  const std::string digits(line.substr(open + 1, close - open - 1));
  if (digits.size() != 16 || digits.find_first_not_of("0123456789ABCDEF") != std::string::npos) return;
  const std::uint64_t bits = std::strtoull(digits.c_str(), nullptr, 16);
  const double value = std::bit_cast<double>(bits);
  if (std::isfinite(value)) found.push_back({"variable/" + std::to_string(number), value});
}

}  // namespace

std::vector<NamedValue> named_values(std::string_view text) {
  std::vector<NamedValue> found;
  each_line(text, [&](std::string_view line) {
    const auto words = words_of(line);
    if (!words || words->empty() || words->front().address != 'G' || words->front().number != "10") return;
    const auto* const p = find(*words, 'P');
    if (p == nullptr) return;
    const unsigned long number = std::strtoul(std::string(p->number).c_str(), nullptr, 10);
    const std::string l = text_of(find(*words, 'L'));
    if (l == "2" || l == "20") {
      name_work_offset(*words, l, number, found);
    } else if (l == "85") {
      name_variable(line, number, found);
    } else {
      name_tool_offset(*words, l, number, found);
    }
  });
  return found;
}

}  // namespace headstock::tape

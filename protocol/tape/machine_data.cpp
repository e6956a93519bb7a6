#include "protocol/tape/machine_data.hpp"

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

std::vector<PunchedOffset> punched_offsets(std::string_view text) {
  constexpr std::uint32_t kGeometry = 10'000;
  std::vector<PunchedOffset> found;
  each_line(text, [&](std::string_view line) {
    const auto words = words_of(line);
    if (!words || words->empty() || words->front().address != 'G' || words->front().number != "10") return;
    const auto* const number = find(*words, 'P');
    const std::string l = text_of(find(*words, 'L'));
    if (number == nullptr || l == "2" || l == "20" || l == "3") return;
    const auto raw =
        static_cast<std::uint32_t>(std::strtoul(std::string(number->number).c_str(), nullptr, 10));
    for (const auto& word : *words) {
      if (word.address == 'G' || word.address == 'P' || word.address == 'L') continue;
      PunchedOffset one;
      one.value = std::strtod(std::string(word.number).c_str(), nullptr);
      const bool mill = l.size() == 2 && l[0] == '1' && word.address == 'R';
      if (mill) {
        one.number = raw;
        one.axis = l == "10" || l == "11" ? 'H' : 'D';
        one.wear = l == "11" || l == "13";
      } else {
        one.number = raw > kGeometry ? raw - kGeometry : raw;
        one.axis = word.address;
        one.wear = raw <= kGeometry;
      }
      found.push_back(one);
    }
  });
  return found;
}

}  // namespace headstock::tape

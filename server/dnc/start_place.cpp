#include "server/dnc/start_place.hpp"

#include <cctype>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

namespace headstock::dnc {
namespace {

struct Word {
  char address;
  std::int64_t number;
};

/// Words with whole numbers, in capitals, comments left out; block skip ("/", "/2") does not hide a block.
std::vector<Word> words_of(std::string_view line) {
  std::vector<Word> words;
  bool comment = false;
  for (std::size_t at = 0; at < line.size(); ++at) {
    const char c = line[at];
    if (c == '(') comment = true;
    if (c == ')') comment = false;
    if (comment || std::isalpha(static_cast<unsigned char>(c)) == 0) continue;
    std::size_t end = at + 1;
    while (end < line.size() && line[end] == ' ') ++end;
    const std::size_t digits = end;
    std::int64_t number = 0;
    while (end < line.size() && std::isdigit(static_cast<unsigned char>(line[end])) != 0 && end - digits < 12)
      number = number * 10 + (line[end++] - '0');
    if (end > digits)
      words.push_back({static_cast<char>(std::toupper(static_cast<unsigned char>(c))), number});
  }
  return words;
}

bool is_block(std::string_view line) {
  const auto at = line.find_first_not_of(" \t\r");
  return at != std::string_view::npos && line[at] != '%';
}

class Search {
 public:
  Search(const StartWish& wish, bool mill) : wish_(wish), mill_(mill) {}

  /// Is this line one of those that were asked for?
  bool hit(std::string_view line, std::int64_t number) {
    switch (wish_.by) {
      case StartWish::line:
        return number == wish_.value;
      case StartWish::block:
        return is_block(line) && ++blocks_ == wish_.value;
      case StartWish::sequence:
        return has_sequence(line);
      case StartWish::tool:
        return changes_tool(line);
    }
    return false;
  }

 private:
  bool has_sequence(std::string_view line) const {
    for (const Word& word : words_of(line)) {
      if (word.address == 'N') return word.number == wish_.value;
      if (word.address != 'O') return false;  // a sequence number stands in front
    }
    return false;
  }
  bool changes_tool(std::string_view line) {
    bool change = false, named = false;
    for (const Word& word : words_of(line)) {
      if (word.address == 'T') ready_ = word.number, named = true;
      if (word.address == 'M' && word.number == 6) change = true;
    }
    if (mill_) return change && ready_ == wish_.value;
    // T0505 and T505 are tool 5 with offset 5; T5 is tool 5 where no offset is given.
    return named && ready_ && (*ready_ >= 100 ? *ready_ / 100 : *ready_) == wish_.value;
  }

  StartWish wish_;
  bool mill_;
  std::int64_t blocks_ = 0;
  std::optional<std::int64_t> ready_;
};

}  // namespace

StartPlace find_place(const std::string& file, const StartWish& wish, bool mill) {
  constexpr std::size_t kShown = 200;
  StartPlace place;
  Search search(wish, mill);
  std::ifstream in(file, std::ios::binary);
  std::string line;
  for (std::int64_t number = 1; std::getline(in, line); ++number) {
    if (!search.hit(line, number) || ++place.occurrences != wish.occurrence) continue;
    place.line = number;
    place.text = line.substr(0, kShown);
    if (!place.text.empty() && place.text.back() == '\r') place.text.pop_back();
  }
  return place;
}

}  // namespace headstock::dnc

// What kind of change it is when one block becomes another. Works on the words of a block, whatever the
// dialect; what is not words (macro statements, jumps) counts as structure.
#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include "server/library/difference.hpp"

namespace headstock::library {
namespace {

/// A block taken apart. Values are texts: "1" and "1." differ, as they do in a controller.
struct Block {
  std::map<char, std::vector<std::string>> words;
  std::string text;        ///< without comments and blanks, upper case
  bool statement = false;  ///< IF, WHILE, GOTO, assignments, %, anything that is not plain words
};

/// "007.500" → "7.5", but "7." stays different from "7".
std::string plain_number(std::string value) {
  std::size_t sign = !value.empty() && (value[0] == '-' || value[0] == '+') ? 1 : 0;
  if (value.find_first_not_of("0123456789.", sign) != std::string::npos) return value;
  while (sign + 1 < value.size() && value[sign] == '0' && value[sign + 1] != '.') value.erase(sign, 1);
  if (value.find('.') != std::string::npos)
    while (value.back() == '0' && value[value.size() - 2] != '.') value.pop_back();
  if (!value.empty() && value[0] == '+') value.erase(0, 1);
  if (value.size() >= 2 && value.ends_with(".0")) value.pop_back();
  return value;
}

std::string without_comments(std::string_view line) {
  std::string text;
  int depth = 0;
  for (const char c : line) {
    if (c == ';' && depth == 0) break;
    if (c == '(') {
      ++depth;
    } else if (c == ')' && depth > 0) {
      --depth;
    } else if (depth == 0 && static_cast<unsigned char>(c) > ' ') {
      text += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    }
  }
  return text;
}

Block parse(std::string_view line) {
  Block block;
  block.text = without_comments(line);
  const std::string& text = block.text;
  std::size_t at = 0;
  while (at < text.size() && text[at] == '/') ++at;  // block skip: in `text`, so a change of it is seen
  if (at > 0) block.words['/'].push_back(text.substr(0, at));
  while (at < text.size()) {
    const char letter = text[at];
    const bool word = std::isalpha(static_cast<unsigned char>(letter)) != 0;
    std::size_t end = at + 1;
    int brackets = 0;
    while (end < text.size()) {
      const auto c = static_cast<unsigned char>(text[end]);
      if (brackets == 0 && (std::isalpha(c) != 0 || c == '=' || c == '%')) break;
      brackets += c == '[';
      brackets -= c == ']';
      ++end;
    }
    if (!word || end == at + 1) {  // "#100=…", "%", "GOTO", "IF"
      block.statement = true;
      return block;
    }
    block.words[letter].push_back(plain_number(text.substr(at + 1, end - at - 1)));
    at = end;
  }
  return block;
}

bool has_code(const Block& block, char letter, std::initializer_list<std::string_view> codes) {
  const auto found = block.words.find(letter);
  return found != block.words.end() && std::ranges::any_of(found->second, [&](const std::string& value) {
           return std::ranges::find(codes, value) != codes.end();
         });
}

/// What a block's G codes make of its other words.
enum class Context { plain, offsets, dwell, thread };

Context context_of(const Block& block) {
  if (has_code(block, 'G', {"10", "50", "52", "54", "55", "56", "57", "58", "59", "54.1", "92"}))
    return has_code(block, 'G', {"92"}) && block.words.contains('F') ? Context::thread : Context::offsets;
  if (has_code(block, 'G', {"4"})) return Context::dwell;
  // Here F is a lead or a pitch: it changes the part, not the pace.
  if (has_code(block, 'G', {"32", "33", "34", "76", "78", "84", "74", "84.2", "88"})) return Context::thread;
  return Context::plain;
}

/// The class of a G code that appears or disappears.
ChangeClass class_of_g(const std::string& value) {
  static constexpr std::array<std::string_view, 9> kOffsets = {"10", "52", "54", "55",  "56",
                                                               "57", "58", "59", "54.1"};
  static constexpr std::array<std::string_view, 7> kPace = {"94", "95", "96", "97", "98", "99", "4"};
  static constexpr std::array<std::string_view, 9> kGeometry = {"0",  "1",  "2",  "3", "17",
                                                                "18", "19", "90", "91"};
  if (std::ranges::find(kOffsets, value) != kOffsets.end()) return ChangeClass::offset;
  if (std::ranges::find(kPace, value) != kPace.end()) return ChangeClass::feed_speed;
  if (std::ranges::find(kGeometry, value) != kGeometry.end()) return ChangeClass::geometry;
  return ChangeClass::structure;
}

ChangeClass class_of_word(char letter, Context context) {
  constexpr std::string_view kAxes = "XYZUVWABCIJKRQ";
  if (letter == 'F' || letter == 'E')
    return context == Context::thread ? ChangeClass::geometry : ChangeClass::feed_speed;
  if (letter == 'S') return ChangeClass::feed_speed;
  if (letter == 'T' || letter == 'D' || letter == 'H') return ChangeClass::offset;
  if (context == Context::offsets &&
      (kAxes.find(letter) != std::string_view::npos || letter == 'P' || letter == 'L'))
    return ChangeClass::offset;
  if (context == Context::dwell && (letter == 'X' || letter == 'U' || letter == 'P'))
    return ChangeClass::feed_speed;
  if (kAxes.find(letter) != std::string_view::npos) return ChangeClass::geometry;
  return ChangeClass::structure;  // N O M L P / …
}

ChangeClass class_of_g_change(const std::vector<std::string>& left, const std::vector<std::string>& right) {
  ChangeClass worst = ChangeClass::none;
  const auto only_in = [&](const auto& these, const auto& those) {
    for (const std::string& value : these)
      if (std::ranges::find(those, value) == those.end()) worst = std::max(worst, class_of_g(value));
  };
  only_in(left, right);
  only_in(right, left);
  return worst == ChangeClass::none ? ChangeClass::structure : worst;  // the order of the codes only
}

}  // namespace

ChangeClass classify(std::string_view left, std::string_view right) {
  if (left == right) return ChangeClass::none;
  const Block a = parse(left), b = parse(right);
  if (a.text == b.text) return ChangeClass::comment;
  if (a.statement || b.statement) return ChangeClass::structure;
  // A whole block that comes or goes is judged by what it does, not by its sequence number.
  const bool whole = a.text.empty() || b.text.empty();
  const Context left_context = context_of(a), right_context = context_of(b);
  ChangeClass worst = ChangeClass::comment;
  std::map<char, std::vector<std::string>> letters = a.words;
  letters.insert(b.words.begin(), b.words.end());
  const std::vector<std::string> none;
  for (const auto& [letter, unused] : letters) {
    const auto in_a = a.words.find(letter), in_b = b.words.find(letter);
    const auto& values_a = in_a == a.words.end() ? none : in_a->second;
    const auto& values_b = in_b == b.words.end() ? none : in_b->second;
    if (values_a == values_b || (whole && letter == 'N' && letters.size() > 1)) continue;
    worst = std::max(worst, letter == 'G' ? class_of_g_change(values_a, values_b)
                                          : std::max(class_of_word(letter, left_context),
                                                     class_of_word(letter, right_context)));
  }
  // The same words in another order: harmless in most controllers, but somebody should look.
  return worst == ChangeClass::comment ? ChangeClass::structure : worst;
}

}  // namespace headstock::library

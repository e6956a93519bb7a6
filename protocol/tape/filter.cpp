#include "protocol/tape/filter.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

namespace headstock::tape {
namespace {

bool digit(char c) {
  return c >= '0' && c <= '9';
}
bool blank(std::string_view text) {
  return text.find_first_not_of(" \t\r") == std::string_view::npos;
}

/// The line without what the options take out.
std::string thinned(std::string_view line, const FilterOptions& options) {
  std::string kept;
  bool in_comment = false;
  for (const char c : line) {
    if (c == '(') in_comment = true;
    const bool space = (c == ' ' || c == '\t') && !in_comment;
    if (!(in_comment && options.strip_comments) && !(space && options.strip_spaces)) kept += c;
    if (c == ')') in_comment = false;
  }
  return kept;
}

/// Where the block begins behind "/2" and "N123"; the block skip stays in front.
struct Head {
  std::string_view skip, rest;
};
Head head_of(std::string_view line) {
  std::size_t at = line.find_first_not_of(" \t");
  if (at == std::string_view::npos) return {"", line};
  std::size_t skip_end = at;
  if (line[at] == '/') {
    ++at;
    if (at < line.size() && digit(line[at])) ++at;
    skip_end = at;
    while (at < line.size() && line[at] == ' ') ++at;
  }
  if (at < line.size() && (line[at] == 'N' || line[at] == 'n')) {
    std::size_t end = at + 1;
    while (end < line.size() && digit(line[end])) ++end;
    if (end > at + 1) at = end;
  }
  return {line.substr(0, skip_end), line.substr(at)};
}

bool is_program_number(std::string_view line) {
  const auto at = line.find_first_not_of(" \t");
  return at != std::string_view::npos && at + 1 < line.size() &&
         (line[at] == 'O' || line[at] == 'o' || line[at] == ':') && digit(line[at + 1]);
}

/// Capitals, without comments and spaces.
std::string plain(std::string_view line) {
  FilterOptions options;
  options.strip_comments = options.strip_spaces = true;
  std::string text = thinned(line, options);
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/// A word like M99 or G71, not M990 and not G71.5.
bool has_word(std::string_view text, char address, int low, int high) {
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] != address) continue;
    std::size_t end = at + 1;
    while (end < text.size() && digit(text[end])) ++end;
    if (end == at + 1 || end - at > 6) continue;
    const int number = std::stoi(std::string(text.substr(at + 1, end - at - 1)));
    if (number >= low && number <= high && (end == text.size() || text[end] != '.')) return true;
  }
  return false;
}

}  // namespace

void Filter::header(std::string& out) {
  if (std::exchange(header_done_, true) || options_.header.empty()) return;
  out += options_.header;
  if (options_.header.back() != '\n') out += '\n';
}

void Filter::line(std::string_view line, std::string_view end, std::string& out) {
  const bool percent =
      !line.empty() &&
      line[line.find_first_not_of(" \t") == std::string_view::npos ? 0 : line.find_first_not_of(" \t")] ==
          '%';
  const bool program_number = is_program_number(line);
  if (!percent && !program_number && !blank(line)) header(out);
  std::string kept = thinned(line, options_);
  if (options_.strip_empty && blank(kept)) return;
  if (options_.number_step > 0 && !percent && !program_number && !blank(kept)) {
    const Head head = head_of(kept);
    std::string number(1, 'N');
    number += std::to_string(options_.number_from + next_number_ * options_.number_step);
    if (!options_.strip_spaces) number += ' ';
    if (!blank(head.rest)) {
      const auto first = head.rest.find_first_not_of(" \t");
      number.insert(0, head.skip).append(head.rest.substr(first));
      kept = std::move(number);
      ++next_number_;
    }
  }
  out += kept;
  out += end;
  if (program_number) header(out);
}

void Filter::put(std::string_view text, std::string& out) {
  while (!text.empty()) {
    const auto end = text.find('\n');
    line_ += text.substr(0, end);
    if (end == std::string_view::npos) return;
    const bool cr = !line_.empty() && line_.back() == '\r';
    if (cr) line_.pop_back();
    line(line_, cr ? "\r\n" : "\n", out);
    line_.clear();
    text.remove_prefix(end + 1);
  }
}

void Filter::finish(std::string& out) {
  if (!line_.empty()) line(line_, "", out);
  line_.clear();
}

void ReferenceSearch::examine() {
  ++number_;
  if (found_ != 0) return;
  const std::string text = plain(line_);
  const bool has_p = text.find('P') != std::string::npos;
  const bool jump = text.find("GOTO") != std::string::npos;
  const bool back = has_p && (has_word(text, 'M', 99, 99) || has_word(text, 'M', 97, 97));
  const bool contour = has_p && text.find('Q') != std::string::npos && has_word(text, 'G', 70, 73);
  if (jump || back || contour) found_ = number_;
}

void ReferenceSearch::put(std::string_view text) {
  while (!text.empty()) {
    const auto end = text.find('\n');
    line_ += text.substr(0, end);
    if (end == std::string_view::npos) return;
    examine();
    line_.clear();
    text.remove_prefix(end + 1);
  }
}

void ReferenceSearch::finish() {
  if (!line_.empty()) examine();
  line_.clear();
}

}  // namespace headstock::tape

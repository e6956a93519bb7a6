#include "protocol/tape/punch.hpp"

#include <algorithm>
#include <regex>

namespace headstock::tape {
namespace {

struct KindRow {
  PunchKind kind;
  std::string_view name;
  const char* line;  ///< every line of such data looks like this
};
constexpr KindRow kKinds[] = {
    {PunchKind::program, "program", nullptr},
    {PunchKind::macro_variables, "macro_variables",
     R"((G10 ?L85 ?P\d+ ?\([0-9A-F]{16}\).*)|(SETVN ?\d+ ?\[.*\]))"},
    {PunchKind::tool_life, "tool_life", R"(G10 ?L3( ?P\d)?|G11|P\d+ ?L\d+( ?Q\d)?|T\d+( ?H\d+)?( ?D\d+)?)"},
    {PunchKind::work_offsets, "work_offsets", R"(G10 ?(G90 ?)?L20? ?P\d+( ?[XYZABCUVW][-+.0-9]+)+)"},
    {PunchKind::tool_offsets, "tool_offsets", R"(G10 ?(G90 ?)?(L1[0-3] ?)?P\d+( ?[XYZRQ][-+.0-9]+)+)"},
    {PunchKind::pitch_error, "pitch_error", R"(N1\d{4} ?Q0 ?P-?\d+)"},
    {PunchKind::parameters, "parameters",
     R"((N\d{4,5} ?(Q1 ?)?([ALTS]\d+ ?)*P[-+.0-9]+( ?[ALTS]\d+ ?P[-+.0-9]+)*)|(\d{3}[ \t]+[-+.0-9]*))"},
    {PunchKind::unknown, "unknown", nullptr},
};
constexpr std::size_t kLongestComment = 120;

const std::regex& pattern_of(std::size_t row) {
  static const std::vector<std::regex> patterns = [] {
    std::vector<std::regex> made;
    for (const KindRow& kind : kKinds) made.emplace_back(kind.line == nullptr ? "(?!)" : kind.line);
    return made;
  }();
  return patterns[row];
}

bool digit(char c) {
  return c >= '0' && c <= '9';
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r;");
  if (first == std::string_view::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r;") - first + 1);
}

std::string comment_of(std::string_view line) {
  const auto open = line.find('(');
  if (open == std::string_view::npos) return "";
  const auto text = line.substr(open + 1, line.find(')', open) - open - 1);
  return std::string(trimmed(text.substr(0, kLongestComment)));
}

PunchKind kind_of_line(std::string_view line) {
  if (line.size() > 300) return PunchKind::program;
  for (std::size_t row = 0; row < std::size(kKinds); ++row)
    if (kKinds[row].line != nullptr && std::regex_match(line.begin(), line.end(), pattern_of(row)))
      return kKinds[row].kind;
  return PunchKind::program;
}

}  // namespace

std::string_view name_of(PunchKind kind) {
  for (const KindRow& row : kKinds)
    if (row.kind == kind) return row.name;
  return "unknown";
}

void PunchSplitter::open(std::uint64_t at) {
  if (pieces_.size() >= most_pieces) {
    too_many_ = true;
    return;
  }
  pieces_.push_back({});
  pieces_.back().begin = at;
  open_ = true;
  all_one_kind_ = true;
  kind_so_far_ = PunchKind::unknown;
}

void PunchSplitter::close(std::uint64_t at) {
  if (!open_) return;
  open_ = false;
  PunchedPiece& piece = pieces_.back();
  piece.end = at;
  piece.kind = piece.has_number ? PunchKind::program : all_one_kind_ ? kind_so_far_ : PunchKind::program;
}

void PunchSplitter::classify(std::string_view text) {
  PunchedPiece& piece = pieces_.back();
  if (piece.comment.empty() && !piece.has_number) piece.comment = comment_of(text);
  if (piece.has_number || !all_one_kind_ || text.front() == '(' || text == "M02" || text == "M30") return;
  const PunchKind kind = kind_of_line(text);
  if (kind_so_far_ == PunchKind::unknown) kind_so_far_ = kind;
  all_one_kind_ = kind == kind_so_far_ && kind != PunchKind::program;
}

void PunchSplitter::line() {
  const std::string_view text = trimmed(line_);
  if (text.empty()) {
    if (open_) ++pieces_.back().lines;
    return;
  }
  percent_last_ = text.front() == '%';
  if (percent_last_) {
    ++percents_;
    return close(line_begin_);
  }
  const bool numbered = text.size() > 1 && (text[0] == 'O' || text[0] == ':') && digit(text[1]);
  if (numbered) {
    close(line_begin_);
    open(line_begin_);
  } else if (!open_) {
    open(line_begin_);
  }
  if (!open_) return;
  PunchedPiece& piece = pieces_.back();
  ++piece.lines;
  if (numbered) {
    piece.has_number = true;
    for (std::size_t at = 1; at < text.size() && at < 9 && digit(text[at]); ++at)
      piece.number = piece.number * 10 + static_cast<std::uint32_t>(text[at] - '0');
    piece.comment = comment_of(text);
  }
  classify(text);
}

void PunchSplitter::put(std::string_view text) {
  for (const char c : text) {
    ++offset_;
    if (c == '\n') {
      line();
      line_.clear();
      line_begin_ = offset_;
    } else if (line_.size() < 4'096) {  // enough to see what a line is
      line_ += c;
    }
  }
}

void PunchSplitter::finish() {
  if (!line_.empty()) line();
  line_.clear();
  close(percent_last_ ? line_begin_ : offset_);
}

std::string punched_name(const PunchedPiece& piece, NameRule rule, std::string_view fallback) {
  std::string name;
  if (rule == NameRule::comment) {
    for (const char c : piece.comment)
      name += static_cast<unsigned char>(c) < 0x20 || c == '/' || c == '\\' || c == 0x7F ? '_' : c;
    while (!name.empty() && (name.front() == '.' || name.front() == ' ')) name.erase(0, 1);
    while (!name.empty() && (name.back() == '.' || name.back() == ' ')) name.pop_back();
  }
  if (!name.empty()) return name;
  if (!piece.has_number) return std::string(fallback);
  const std::string digits = std::to_string(piece.number);
  name.assign(1, 'O').append(digits.size() < 4 ? 4 - digits.size() : 0, '0').append(digits);
  return name;
}

}  // namespace headstock::tape

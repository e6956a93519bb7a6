#include "protocol/tape/finding.hpp"

namespace headstock::tape {
namespace {

struct Row {
  Finding::Kind kind;
  std::string_view name, text;
};
constexpr Row kRows[] = {
    {Finding::th, "th", "has wrong parity (TH)"},
    {Finding::tv, "tv", "the block has an odd number of characters (TV)"},
    {Finding::no_code, "no_code", "has no code here"},
    {Finding::no_percent, "no_percent", "the tape ends without %"},
};

const Row& row_of(Finding::Kind kind) {
  for (const Row& row : kRows)
    if (row.kind == kind) return row;
  return kRows[0];
}

}  // namespace

std::string_view name_of(Finding::Kind kind) {
  return row_of(kind).name;
}

std::string describe(const Finding& finding) {
  static constexpr char digits[] = "0123456789ABCDEF";
  std::string text = "line " + std::to_string(finding.line);
  if (finding.column != 0) text += ", column " + std::to_string(finding.column);
  text += ": ";
  if (finding.kind == Finding::th || finding.kind == Finding::no_code) {
    text += std::string("byte ") + digits[finding.byte >> 4] + digits[finding.byte & 15u] + ' ';
    if (finding.kind == Finding::no_code && finding.byte > 0x20 && finding.byte < 0x7F)
      text += std::string("(") + static_cast<char>(finding.byte) + ") ";
  }
  text += row_of(finding.kind).text;
  return text;
}

}  // namespace headstock::tape

// Line comparison. The common head and tail are cut off first; what is left is searched with Myers' greedy
// algorithm for the shortest edit. Its cost grows with lines × edits, so it gets a budget: where that runs
// out, lines that occur once on each side anchor the texts to each other (patience) and the pieces between
// the anchors are searched again; a piece with neither is shown as replaced as a whole. So two unrelated
// texts of a million lines cost seconds, not hours.
#include "server/library/difference.hpp"

#include <algorithm>
#include <array>
#include <unordered_map>

#include "db/refusal.hpp"
#include "server/library/lines.hpp"
#include "server/library/text_facts.hpp"

namespace headstock::library {
namespace {

constexpr std::array<std::string_view, 5> kKinds = {"same", "changed", "added", "removed", "skipped"};
constexpr std::array<std::string_view, 6> kClasses = {"none",   "comment",  "feed_speed",
                                                      "offset", "geometry", "structure"};
constexpr std::size_t kMostTableLines = 2'000'000;  // lines a side that are searched at all
constexpr int kMostEdits = 1'500;                   // one greedy search; its memory grows with the square

using Lines = std::vector<std::string_view>;

Lines split(std::string_view text) {
  Lines lines;
  std::size_t at = 0;
  while (at < text.size()) {
    if (lines.size() == kMostTableLines) throw db::Refusal("too_large", "difference");
    const std::size_t end = std::min(text.find_first_of("\r\n", at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
    if (end + 1 < text.size() && text[end] == '\r' && text[end + 1] == '\n') ++at;
  }
  return lines;
}

/// Bytes at the front that are the same whole lines on both sides.
std::size_t common_head(std::string_view left, std::string_view right) {
  const std::size_t shorter = std::min(left.size(), right.size());
  const auto same = static_cast<std::size_t>(
      std::mismatch(left.begin(), left.begin() + static_cast<std::ptrdiff_t>(shorter), right.begin()).first -
      left.begin());
  const std::size_t line_end = same == 0 ? std::string_view::npos : left.rfind('\n', same - 1);
  return line_end == std::string_view::npos ? 0 : line_end + 1;
}

/// Lines of a text that ends with a line end.
std::int64_t count_lines(std::string_view text) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < text.size(); ++i)
    count += text[i] == '\n' || (text[i] == '\r' && (i + 1 == text.size() || text[i + 1] != '\n'));
  return count;
}

/// The last `lines` lines of it.
std::string_view last_lines(std::string_view text, std::int64_t lines) {
  std::size_t at = text.size();
  while (at > 0 && lines-- > 0) {
    const std::size_t line_end = at < 2 ? std::string_view::npos : text.rfind('\n', at - 2);
    at = line_end == std::string_view::npos ? 0 : line_end + 1;
  }
  return text.substr(at);
}

/// Half-open ranges of line indexes on both sides.
struct Range {
  int left, left_end, right, right_end;
  bool empty_side() const { return left == left_end || right == right_end; }
};

/// Finds for every left line its partner on the right, or -1.
class Matcher {
 public:
  Matcher(const Lines& left, const Lines& right, std::int64_t effort)
      : effort_(effort), partner_(left.size(), -1) {
    std::unordered_map<std::string_view, int> numbers;
    numbers.reserve(left.size() + right.size());
    const auto number = [&](std::string_view line) {
      return numbers.try_emplace(line, static_cast<int>(numbers.size())).first->second;
    };
    for (const auto line : left) left_.push_back(number(line));
    for (const auto line : right) right_.push_back(number(line));
  }

  void run() {
    work_.push_back({0, static_cast<int>(left_.size()), 0, static_cast<int>(right_.size())});
    while (!work_.empty()) {
      const Range range = work_.back();
      work_.pop_back();
      search(range);
    }
  }
  const std::vector<int>& partner() const { return partner_; }
  bool coarse() const { return coarse_; }

 private:
  void search(Range range) {
    while (!range.empty_side() && left_[at(range.left)] == right_[at(range.right)])
      partner_[at(range.left++)] = range.right++;
    while (!range.empty_side() && left_[at(range.left_end - 1)] == right_[at(range.right_end - 1)])
      partner_[at(--range.left_end)] = --range.right_end;
    if (range.empty_side() || greedy(range) || anchored(range)) return;
    coarse_ = true;
  }

  /// Myers: for each number of edits how far each diagonal gets. @return false when the budget is used up.
  bool greedy(const Range& range) {
    const int n = range.left_end - range.left, m = range.right_end - range.right;
    const int most = std::min(n + m, kMostEdits);
    std::vector<std::vector<int>> trace;
    std::vector<int> reach(static_cast<std::size_t>(2 * most + 3), 0);
    const auto cell = [&](int diagonal) -> int& { return reach[at(diagonal + most + 1)]; };
    for (int edits = 0; edits <= most; ++edits) {
      for (int diagonal = -edits; diagonal <= edits; diagonal += 2) {
        int x = diagonal == -edits || (diagonal != edits && cell(diagonal - 1) < cell(diagonal + 1))
                    ? cell(diagonal + 1)
                    : cell(diagonal - 1) + 1;
        int y = x - diagonal;
        --effort_;
        while (x < n && y < m && left_[at(range.left + x)] == right_[at(range.right + y)]) {
          ++x;
          ++y;
          --effort_;
        }
        cell(diagonal) = x;
        if (x >= n && y >= m) {
          trace.emplace_back(reach.begin() + (most + 1 - edits), reach.begin() + (most + 2 + edits));
          walk_back(range, trace);
          return true;
        }
      }
      if (effort_ < 0) return false;
      trace.emplace_back(reach.begin() + (most + 1 - edits), reach.begin() + (most + 2 + edits));
    }
    return false;
  }

  void walk_back(const Range& range, const std::vector<std::vector<int>>& trace) {
    int x = range.left_end - range.left, y = range.right_end - range.right;
    for (int edits = static_cast<int>(trace.size()) - 1; edits > 0; --edits) {
      const std::vector<int>& before = trace[at(edits - 1)];  // diagonals -(edits-1) … edits-1
      const auto reached = [&](int diagonal) {
        const int index = diagonal + edits - 1;
        return index < 0 || index >= static_cast<int>(before.size()) ? -1 : before[at(index)];
      };
      const int diagonal = x - y;
      const bool down =
          diagonal == -edits || (diagonal != edits && reached(diagonal - 1) < reached(diagonal + 1));
      const int from_x = down ? reached(diagonal + 1) : reached(diagonal - 1);
      const int from_y = from_x - (down ? diagonal + 1 : diagonal - 1);
      for (const int step_end = down ? from_x : from_x + 1; x > step_end;) {  // equal lines after the edit
        --x;
        --y;
        partner_[at(range.left + x)] = range.right + y;
      }
      x = from_x;
      y = from_y;
    }
    while (x > 0 && y > 0) {
      --x;
      --y;
      partner_[at(range.left + x)] = range.right + y;
    }
  }

  /// Lines that occur once on each side, in an order both share: the pieces between them are searched again.
  bool anchored(const Range& range) {
    if (rounds_left_ == 0) return false;
    --rounds_left_;
    struct Seen {
      int left = 0, right = 0, left_at = 0, right_at = 0;
    };
    std::unordered_map<int, Seen> seen;
    for (int i = range.left; i < range.left_end; ++i) {
      Seen& entry = seen[left_[at(i)]];
      ++entry.left;
      entry.left_at = i;
    }
    for (int i = range.right; i < range.right_end; ++i) {
      Seen& entry = seen[right_[at(i)]];
      ++entry.right;
      entry.right_at = i;
    }
    std::vector<std::pair<int, int>> unique;
    for (const auto& [number, entry] : seen)
      if (entry.left == 1 && entry.right == 1) unique.emplace_back(entry.left_at, entry.right_at);
    if (unique.empty()) return false;
    std::ranges::sort(unique);
    Range piece = range;
    for (const auto& [left, right] : longest_rising(unique)) {
      partner_[at(left)] = right;
      work_.push_back({piece.left, left, piece.right, right});
      piece.left = left + 1;
      piece.right = right + 1;
    }
    work_.push_back(piece);
    effort_ = std::max(
        effort_, static_cast<std::int64_t>(range.left_end - range.left + range.right_end - range.right));
    return true;
  }

  static std::vector<std::pair<int, int>> longest_rising(const std::vector<std::pair<int, int>>& pairs) {
    std::vector<std::size_t> tops;  // index of the pair that ends the best sequence of each length
    std::vector<std::ptrdiff_t> previous(pairs.size(), -1);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto pile = std::ranges::lower_bound(tops, pairs[i].second, {},
                                                 [&](std::size_t top) { return pairs[top].second; });
      if (pile != tops.begin()) previous[i] = static_cast<std::ptrdiff_t>(*(pile - 1));
      if (pile == tops.end())
        tops.push_back(i);
      else
        *pile = i;
    }
    std::vector<std::pair<int, int>> rising;
    for (auto i = tops.empty() ? -1 : static_cast<std::ptrdiff_t>(tops.back()); i >= 0;
         i = previous[static_cast<std::size_t>(i)])
      rising.push_back(pairs[static_cast<std::size_t>(i)]);
    std::ranges::reverse(rising);
    return rising;
  }

  static std::size_t at(int index) { return static_cast<std::size_t>(index); }

  std::int64_t effort_;
  std::vector<int> left_, right_, partner_;
  std::vector<Range> work_;
  int rounds_left_ = 64;
  bool coarse_ = false;
};

/// Do the two lines say the same kind of thing? 0…1 by the letters they share.
double likeness(std::string_view left, std::string_view right) {
  std::array<int, 26> letters{};
  int total = 0, shared = 0;
  const auto each = [](std::string_view text, auto use) {
    for (const char c : text) {
      const char upper = c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
      if (upper >= 'A' && upper <= 'Z') use(static_cast<std::size_t>(upper - 'A'));
    }
  };
  each(left.substr(0, 200), [&](std::size_t i) {
    ++letters[i];
    ++total;
  });
  each(right.substr(0, 200), [&](std::size_t i) {
    ++total;
    if (letters[i]-- > 0) ++shared;
  });
  return total == 0 ? 1.0 : 2.0 * shared / total;
}

/// Where a run of equal lines lies.
struct Edge {
  bool first = false, last = false;
};

class Rows {
 public:
  Rows(const Lines& left, std::string_view left_encoding, const Lines& right, std::string_view right_encoding,
       std::int64_t first_line, std::size_t context, const DiffOptions& options, Difference& out)
      : left_(left),
        right_(right),
        left_encoding_(left_encoding),
        right_encoding_(right_encoding),
        base_(first_line),
        context_(context),
        options_(options),
        out_(out) {}

  /// @param first,last is there no change before, after these?
  void same(std::size_t left, std::size_t right, std::size_t count, Edge edge) {
    const std::size_t head = edge.first ? 0 : context_, tail = edge.last && !edge.first ? 0 : context_;
    for (std::size_t i = 0; i < count; ++i) {
      if (count > head + tail && i == head) {
        const std::size_t left_out = count - head - tail;
        put({RowKind::skipped, ChangeClass::none, 0, 0, {}, {}, static_cast<std::int64_t>(left_out)}, kNone,
            kNone);
        i += left_out - 1;
        continue;
      }
      put({RowKind::same, ChangeClass::none, line(left + i), line(right + i), {}, {}, 0}, left + i,
          right + i);
    }
  }
  void skipped(std::int64_t count) {
    put({RowKind::skipped, ChangeClass::none, 0, 0, {}, {}, count}, kNone, kNone);
  }

  void block(std::size_t left, std::size_t left_end, std::size_t right, std::size_t right_end) {
    const auto pairs = pair_up(left, left_end, right, right_end);
    for (const auto& [l, r] : pairs) {
      while (left < l) removed(left++);
      while (right < r) added(right++);
      if (l == left_end || r == right_end) continue;
      const ChangeClass change = classify(left_[l], right_[r]);
      ++out_.changed;
      note(change);
      put({RowKind::changed, change, line(l), line(r), {}, {}, 0}, l, r);
      left = l + 1;
      right = r + 1;
    }
    while (left < left_end) removed(left++);
    while (right < right_end) added(right++);
  }

  void finish() {
    for (std::size_t i = 0; i < seen_.size(); ++i)
      if (seen_[i]) out_.classes.push_back(static_cast<ChangeClass>(i));
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  std::int64_t line(std::size_t index) const { return base_ + static_cast<std::int64_t>(index) + 1; }
  void note(ChangeClass change) { seen_[static_cast<std::size_t>(change)] = true; }

  void removed(std::size_t i) {
    const ChangeClass change = classify(left_[i], {});
    ++out_.removed;
    note(change == ChangeClass::none ? ChangeClass::comment : change);
    put({RowKind::removed,
         change == ChangeClass::none ? ChangeClass::comment : change,
         line(i),
         0,
         {},
         {},
         0},
        i, kNone);
  }
  void added(std::size_t i) {
    const ChangeClass change = classify({}, right_[i]);
    ++out_.added;
    note(change == ChangeClass::none ? ChangeClass::comment : change);
    put({RowKind::added, change == ChangeClass::none ? ChangeClass::comment : change, 0, line(i), {}, {}, 0},
        kNone, i);
  }

  void put(DiffRow row, std::size_t left, std::size_t right) {
    if (static_cast<std::int64_t>(out_.rows.size()) >= options_.max_rows) {
      out_.truncated = true;
      return;
    }
    if (left != kNone) row.left = to_utf8(left_[left].substr(0, kLongestShown), left_encoding_);
    if (right != kNone) row.right = to_utf8(right_[right].substr(0, kLongestShown), right_encoding_);
    out_.rows.push_back(std::move(row));
  }

  /// Which removed line became which added one: those that are alike, in order.
  std::vector<std::pair<std::size_t, std::size_t>> pair_up(std::size_t left, std::size_t left_end,
                                                           std::size_t right, std::size_t right_end) {
    const std::size_t n = left_end - left, m = right_end - right;
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    pairings_ += n * m;
    if (n * m > 10'000 || pairings_ > 2'000'000) {
      for (std::size_t i = 0; i < std::min(n, m); ++i)
        if (likeness(left_[left + i], right_[right + i]) >= 0.5) pairs.emplace_back(left + i, right + i);
      return pairs;
    }
    std::vector<double> best((n + 1) * (m + 1), 0);
    const auto cell = [&](std::size_t i, std::size_t j) -> double& { return best[i * (m + 1) + j]; };
    std::vector<double> alike(n * m);
    for (std::size_t i = n; i-- > 0;)
      for (std::size_t j = m; j-- > 0;) {
        const double score = alike[i * m + j] = likeness(left_[left + i], right_[right + j]);
        cell(i, j) =
            std::max({cell(i + 1, j), cell(i, j + 1), score >= 0.5 ? cell(i + 1, j + 1) + score : 0.0});
      }
    for (std::size_t i = 0, j = 0; i < n && j < m;) {
      const double score = alike[i * m + j];
      if (score >= 0.5 && cell(i, j) <= cell(i + 1, j + 1) + score) {
        pairs.emplace_back(left + i++, right + j++);
      } else if (cell(i + 1, j) >= cell(i, j + 1)) {
        ++i;
      } else {
        ++j;
      }
    }
    return pairs;
  }

  const Lines& left_;
  const Lines& right_;
  std::string_view left_encoding_, right_encoding_;
  std::int64_t base_;  // equal lines before the first of these
  std::size_t context_;
  const DiffOptions& options_;
  Difference& out_;
  std::array<bool, kClasses.size()> seen_{};
  std::size_t pairings_ = 0;
};

}  // namespace

std::string_view to_string(RowKind kind) {
  return kKinds[static_cast<std::size_t>(kind)];
}
std::string_view to_string(ChangeClass change) {
  return kClasses[static_cast<std::size_t>(change)];
}

Difference compare(std::string_view left, std::string_view left_encoding, std::string_view right,
                   std::string_view right_encoding, const DiffOptions& options) {
  Difference difference;
  // The common head needs no search and no tables; a part of it is shown.
  const std::string_view head = left.substr(0, common_head(left, right));
  const std::int64_t head_lines = count_lines(head);
  const std::int64_t most_rows = std::max<std::int64_t>(options.max_rows, 1);
  const bool fits =
      head_lines + count_lines(left.substr(head.size())) + count_lines(right.substr(head.size())) < most_rows;
  const std::int64_t context = options.context >= 0 ? options.context : fits ? most_rows : 10;
  const std::string_view shown = last_lines(head, context);
  const std::int64_t not_shown = head_lines - count_lines(shown);
  const std::size_t start = head.size() - shown.size();

  const Lines left_lines = split(left.substr(start)), right_lines = split(right.substr(start));
  Matcher matcher(left_lines, right_lines, options.effort);
  matcher.run();
  difference.coarse = matcher.coarse();
  Rows rows(left_lines, left_encoding, right_lines, right_encoding, not_shown,
            static_cast<std::size_t>(context), options, difference);
  if (not_shown > 0) rows.skipped(not_shown);
  std::size_t l = 0, r = 0;
  while (l < left_lines.size() || r < right_lines.size()) {
    std::size_t next_left = l;
    while (next_left < left_lines.size() && matcher.partner()[next_left] < 0) ++next_left;
    const std::size_t next_right = next_left < left_lines.size()
                                       ? static_cast<std::size_t>(matcher.partner()[next_left])
                                       : right_lines.size();
    if (next_left > l || next_right > r) rows.block(l, next_left, r, next_right);
    l = next_left;
    r = next_right;
    std::size_t count = 0;
    while (l + count < left_lines.size() && matcher.partner()[l + count] == static_cast<int>(r + count))
      ++count;
    const bool first = l == 0 && r == 0 && not_shown == 0;
    if (count > 0)
      rows.same(l, r, count, {first, l + count == left_lines.size() && r + count == right_lines.size()});
    l += count;
    r += count;
  }
  rows.finish();
  return difference;
}

}  // namespace headstock::library

#include "server/library/lines.hpp"

#include <algorithm>

#include "server/library/text_facts.hpp"

namespace headstock::library {
namespace {

constexpr std::int64_t kStep = 1'024;    // lines between two entries of the index
constexpr std::size_t kRemembered = 16;  // indexes kept
constexpr std::size_t kChunk = 1u << 18;
constexpr std::size_t kLongestWindow = 1u << 20;  // bytes of one window
constexpr std::int64_t kMostLines = 2'000;

/// Feeds lines of a blob to `line(number, offset of its start)` until it says stop; reads in chunks. `text`
/// gets the shown part of lines when wanted. Returns the number of the last line seen.
class Scanner {
 public:
  Scanner(const db::Blobs::Reader& reader, std::uint64_t offset, std::int64_t number)
      : reader_(reader), offset_(offset), number_(number), buffer_(kChunk) {}

  /// The next line, without its end. @return false at the end of the text.
  bool next(std::uint64_t& start, std::string* text, bool* cut) {
    if (!peek()) return false;
    start = offset_ + at_;
    if (text) text->clear();
    if (cut) *cut = false;
    ++number_;
    while (peek()) {
      const char* const begin = buffer_.data() + at_;
      const char* const end = buffer_.data() + filled_;
      const char* const stop = std::find_if(begin, end, [](char c) { return c == '\n' || c == '\r'; });
      if (text) {
        const auto room = kLongestShown - text->size();
        const auto length = static_cast<std::size_t>(stop - begin);
        text->append(begin, std::min(room, length));
        if (length > room && cut) *cut = true;
      }
      at_ += static_cast<std::size_t>(stop - begin);
      if (stop == end) continue;
      const bool carriage_return = *stop == '\r';
      ++at_;
      if (carriage_return && peek() && buffer_[at_] == '\n') ++at_;
      return true;
    }
    return true;
  }

  std::int64_t number() const { return number_; }

 private:
  bool peek() {
    if (at_ < filled_) return true;
    offset_ += filled_;
    at_ = 0;
    filled_ = reader_.read(offset_, buffer_.data(), buffer_.size());
    return filled_ > 0;
  }

  const db::Blobs::Reader& reader_;
  std::uint64_t offset_;  // of the buffer's first byte
  std::int64_t number_;   // of the line returned last
  std::vector<char> buffer_;
  std::size_t at_ = 0, filled_ = 0;
};

}  // namespace

std::shared_ptr<const LineReader::Index> LineReader::index(const std::string& sha256) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find(recent_, sha256, [](const auto& entry) { return entry.first; });
    if (found != recent_.end()) {
      recent_.splice(recent_.begin(), recent_, found);
      return found->second;
    }
  }
  const auto reader = blobs_.open(sha256);
  auto made = std::make_shared<Index>();
  Scanner scanner(*reader, 0, 0);
  std::uint64_t start = 0;
  while (scanner.next(start, nullptr, nullptr))
    if ((scanner.number() - 1) % kStep == 0) made->every_1024th.push_back(start);
  made->total = scanner.number();
  const std::lock_guard lock(mutex_);
  recent_.emplace_front(sha256, made);
  if (recent_.size() > kRemembered) recent_.pop_back();
  return made;
}

LineWindow LineReader::window(const std::string& sha256, const std::string& encoding, std::int64_t from,
                              std::int64_t count) {
  const auto known = index(sha256);
  LineWindow window;
  window.total = known->total;
  from = std::max<std::int64_t>(from, 1);
  if (from > known->total) return window;
  const std::int64_t last = std::min(known->total, from + std::clamp<std::int64_t>(count, 0, kMostLines) - 1);
  const std::int64_t entry = (from - 1) / kStep;
  const auto reader = blobs_.open(sha256);
  Scanner scanner(*reader, known->every_1024th[static_cast<std::size_t>(entry)], entry * kStep);
  std::uint64_t start = 0;
  std::size_t bytes = 0;
  std::string text;
  bool cut = false;
  while (scanner.number() < last && bytes < kLongestWindow && scanner.next(start, &text, &cut)) {
    if (scanner.number() < from) continue;
    window.lines.push_back({scanner.number(), to_utf8(text, encoding), cut});
    bytes += text.size() + 16;
  }
  return window;
}

}  // namespace headstock::library

#include "program/block_reader.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace headstock::program {
namespace {

constexpr std::size_t kChunkBytes = 64 * 1024;

std::size_t find(const char* data, std::size_t from, std::size_t to, char wanted) {
  if (from >= to) return to;
  const void* hit = std::memchr(data + from, wanted, to - from);
  return hit == nullptr ? to : static_cast<std::size_t>(static_cast<const char*>(hit) - data);
}

}  // namespace

BlockReader::BlockReader(std::unique_ptr<Source> source, std::size_t longest_line)
    : source_(std::move(source)), longest_line_(longest_line), buffer_(longest_line + kChunkBytes) {}

// Makes room and reads once. Both line-end caches stay right: they are moved, or searched on from the old
// end.
LineStatus BlockReader::fill() {
  if (at_end_) return LineStatus::end;
  if (begin_ > 0 && buffer_.size() - end_ < kChunkBytes) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    base_offset_ += begin_;
    end_ -= begin_;
    next_lf_ -= std::min(next_lf_, begin_);
    next_cr_ -= std::min(next_cr_, begin_);
    begin_ = 0;
  }
  const ReadResult got = source_->read({buffer_.data() + end_, buffer_.size() - end_});
  switch (got.status) {
    case ReadStatus::wait:
      return LineStatus::wait;
    case ReadStatus::failed:
      return LineStatus::failed;
    case ReadStatus::end:
      at_end_ = true;
      return LineStatus::end;
    case ReadStatus::data:
      break;
  }
  const std::size_t old_end = end_;
  end_ += got.bytes;
  if (next_lf_ >= old_end) next_lf_ = find(buffer_.data(), std::max(old_end, begin_), end_, '\n');
  if (next_cr_ >= old_end) next_cr_ = find(buffer_.data(), std::max(old_end, begin_), end_, '\r');
  return LineStatus::line;
}

void BlockReader::deliver(std::size_t length, std::size_t terminator, Line& out) {
  out = {{buffer_.data() + begin_, length}, line_number_, byte_offset(), {byte_offset(), line_number_, false, false}};
  begin_ += length + terminator;
  ++line_number_;
  if (next_lf_ < begin_) next_lf_ = find(buffer_.data(), begin_, end_, '\n');
  if (next_cr_ < begin_) next_cr_ = find(buffer_.data(), begin_, end_, '\r');
}

LineStatus BlockReader::next(Line& out) {
  for (;;) {
    while (begin_ < end_ &&
           ((skip_cr_ && buffer_[begin_] == '\r') || (skip_lf_ && buffer_[begin_] == '\n'))) {
      skip_cr_ = skip_cr_ || skip_lf_;
      skip_lf_ = false;
      ++begin_;
      if (next_lf_ < begin_) next_lf_ = find(buffer_.data(), begin_, end_, '\n');
      if (next_cr_ < begin_) next_cr_ = find(buffer_.data(), begin_, end_, '\r');
    }
    if (begin_ < end_) skip_cr_ = skip_lf_ = false;

    const std::size_t eol = std::min(next_lf_, next_cr_);
    if (eol < end_) {
      if (eol - begin_ > longest_line_) return LineStatus::too_long;
      const bool lf = next_lf_ < next_cr_;
      const bool cr_lf = !lf && next_lf_ == eol + 1 && next_lf_ < end_;
      deliver(eol - begin_, cr_lf ? 2 : 1, out);
      skip_cr_ = lf || cr_lf;
      skip_lf_ = !lf && !cr_lf;
      return LineStatus::line;
    }
    if (end_ - begin_ > longest_line_) return LineStatus::too_long;
    const LineStatus status = fill();
    if (status == LineStatus::line) continue;
    if (status != LineStatus::end) return status;
    if (begin_ == end_) return LineStatus::end;
    deliver(end_ - begin_, 0, out);
    return LineStatus::line;
  }
}

bool BlockReader::can_seek() {
  if (seekable_ == Seek::unknown)
    seekable_ = source_->seek(base_offset_ + end_) ? Seek::can : Seek::cannot;
  return seekable_ == Seek::can;
}

bool BlockReader::seek(const LinePlace& place) {
  if (!can_seek()) return false;
  if (place.byte_offset >= base_offset_ && place.byte_offset <= base_offset_ + end_) {
    // A short loop stays in the buffer, and only what lies between is searched again for line ends.
    const auto begin = static_cast<std::size_t>(place.byte_offset - base_offset_);
    const auto line_end = [&](std::size_t known, char wanted) {
      if (begin > known) return find(buffer_.data(), begin, end_, wanted);
      const std::size_t nearer = begin < begin_ ? find(buffer_.data(), begin, begin_, wanted) : begin_;
      return nearer < begin_ ? nearer : known;
    };
    next_lf_ = line_end(next_lf_, '\n');
    next_cr_ = line_end(next_cr_, '\r');
    begin_ = begin;
  } else {
    if (!source_->seek(place.byte_offset)) return false;
    begin_ = end_ = next_lf_ = next_cr_ = 0;
    base_offset_ = place.byte_offset;
    at_end_ = false;
  }
  line_number_ = place.number;
  skip_cr_ = place.after_lf;
  skip_lf_ = place.after_cr;
  return true;
}

void BlockReader::restart(std::unique_ptr<Source> source) {
  source_ = std::move(source);
  begin_ = end_ = next_lf_ = next_cr_ = 0;
  base_offset_ = 0;
  line_number_ = 1;
  skip_cr_ = skip_lf_ = at_end_ = false;
  seekable_ = Seek::unknown;
}

}  // namespace headstock::program

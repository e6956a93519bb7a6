// Bytes to lines: finds the ends of blocks in a stream that may pause anywhere, in bounded memory.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "program/source.hpp"

namespace headstock::program {

/// Where a line begins, well enough to go back there.
struct LinePlace {
  std::uint64_t byte_offset = 0;
  std::uint32_t number = 1;
  bool after_lf = false;  ///< CRs that follow belong to the line before
  bool after_cr = false;  ///< so does an LF
};

/// One line of a program: everything between two end-of-block codes on the tape.
struct Line {
  std::string_view text;          ///< without its end; valid until the next call of `next`
  std::uint32_t number = 0;       ///< 1-based
  std::uint64_t byte_offset = 0;  ///< of the first byte in the source
  LinePlace place;                ///< to come back to this line
};

enum class LineStatus {
  line,      ///< `out` holds a line
  wait,      ///< the source has no more data for now; nothing is lost
  end,       ///< no more lines
  too_long,  ///< the line is longer than the limit; it cannot be read past
  failed     ///< the source broke
};

/// Splits a source at LF, CR LF, CR or LF CR CR (the punch code of older controls). One thread at a time.
class BlockReader {
 public:
  /// @param longest_line bytes a line may have without its end; 1…1'000'000.
  explicit BlockReader(std::unique_ptr<Source> source, std::size_t longest_line = 8'192);

  LineStatus next(Line& out);

  /// Goes to a line whose place is known. @return false when the source cannot seek.
  bool seek(std::uint64_t byte_offset, std::uint32_t line_number) {
    return seek(LinePlace{byte_offset, line_number, false, false});
  }
  bool seek(const LinePlace& place);
  /// Whether the source can go back; a stream cannot, whatever the buffer happens to hold.
  bool can_seek();
  /// The next line's.
  LinePlace place() const { return {byte_offset(), line_number_, skip_cr_, skip_lf_}; }
  /// Begins with another source; what was known of the last one is forgotten.
  void restart(std::unique_ptr<Source> source);

  /// Where the next line starts.
  std::uint64_t byte_offset() const { return base_offset_ + begin_; }
  std::uint32_t line_number() const { return line_number_; }

 private:
  LineStatus fill();
  void deliver(std::size_t length, std::size_t terminator, Line& out);

  std::unique_ptr<Source> source_;
  std::size_t longest_line_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;          // start of the next line in the buffer
  std::size_t end_ = 0;            // end of the data in the buffer
  std::size_t next_lf_ = 0;        // first LF at or after begin_; end_ when there is none
  std::size_t next_cr_ = 0;        // the same for CR
  std::uint64_t base_offset_ = 0;  // of buffer_[0] in the source
  std::uint32_t line_number_ = 1;
  bool skip_cr_ = false;  // the last line ended with LF: CRs that follow belong to it
  bool skip_lf_ = false;  // the last line ended with CR: an LF that follows belongs to it
  bool at_end_ = false;
  enum class Seek : std::uint8_t { unknown, can, cannot };
  Seek seekable_ = Seek::unknown;
};

}  // namespace headstock::program

// What a program is relieved of or given on its way out, without touching the stored revision: spaces,
// comments, empty lines, sequence numbers, a header. Streaming, by lines. One thread at a time.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace headstock::tape {

struct FilterOptions {
  bool strip_spaces = false;    ///< outside comments
  bool strip_comments = false;  ///< ( … ), not nested; the comment of the O line goes too
  bool strip_empty = false;     ///< lines with nothing left
  std::uint32_t number_from = 0, number_step = 0;  ///< step > 0: every block of the program gets a new N
  std::string header;  ///< lines put behind the O line (in front when there is none)

  bool nothing() const {
    return !strip_spaces && !strip_comments && !strip_empty && number_step == 0 && header.empty();
  }
};

class Filter {
 public:
  explicit Filter(FilterOptions options) : options_(std::move(options)) {}
  void put(std::string_view text, std::string& out);
  void finish(std::string& out);

 private:
  void line(std::string_view line, std::string_view end, std::string& out);
  void header(std::string& out);

  FilterOptions options_;
  std::string line_;
  std::uint64_t next_number_ = 0;
  bool header_done_ = false;
};

/// Numbers cannot be changed where the program refers to them: GOTO, M99 P, M97 P, IF … THEN GOTO and the P/Q
/// of contour cycles G70-G73. Feed it the whole text.
class ReferenceSearch {
 public:
  void put(std::string_view text);
  void finish();
  /// The first line that refers to a sequence number; 0: none does.
  std::uint64_t line() const { return found_; }

 private:
  void examine();
  std::string line_;
  std::uint64_t number_ = 0, found_ = 0;
};

}  // namespace headstock::tape

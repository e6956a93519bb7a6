// What a control has punched: one text may hold several programs, or machine data. Streaming: keeps where
// each piece stands, not the pieces.
//
// Sources of the formats: FANUC III 8 (tool offsets L35200 ff, pitch error L35332, macro variables L35488),
// GSK218T L3649 (parameter text). A piece is machine data only when every line of it is; a program that sets
// offsets by G10 stays a program.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace headstock::tape {

enum class PunchKind {
  program,
  tool_offsets,
  work_offsets,
  parameters,
  pitch_error,
  macro_variables,
  tool_life,
  unknown
};
/// "program", "tool_offsets" …
std::string_view name_of(PunchKind kind);

struct PunchedPiece {
  PunchKind kind = PunchKind::unknown;
  std::uint32_t number = 0;  ///< O number; 0: none
  bool has_number = false;
  std::string comment;               ///< of the O line (or the first comment), at most 120 bytes
  std::uint64_t begin = 0, end = 0;  ///< bytes of the text, without the % lines
  std::uint64_t lines = 0;
};

class PunchSplitter {
 public:
  static constexpr std::size_t most_pieces = 10'000;
  void put(std::string_view text);
  void finish();
  const std::vector<PunchedPiece>& pieces() const { return pieces_; }
  /// A % has come behind the text: the punch is complete.
  bool closed() const { return percents_ >= 2 || (percents_ == 1 && percent_last_); }
  bool too_many() const { return too_many_; }

 private:
  void line();
  void open(std::uint64_t at);
  void close(std::uint64_t at);
  void classify(std::string_view text);

  std::vector<PunchedPiece> pieces_;
  std::string line_;
  std::uint64_t line_begin_ = 0, offset_ = 0;
  bool open_ = false, percent_last_ = false, too_many_ = false, all_one_kind_ = true;
  PunchKind kind_so_far_ = PunchKind::unknown;
  unsigned percents_ = 0;
};

/// How a received program is called: by its O number ("O1234") or by its comment; characters that could leave
/// a folder or that names may not have become "_". @param fallback when the piece has neither.
enum class NameRule { number, comment };
std::string punched_name(const PunchedPiece& piece, NameRule rule, std::string_view fallback);

}  // namespace headstock::tape

// What is wrong with a text on its way to or from a tape, and where.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace headstock::tape {

struct Finding {
  enum Kind {
    th,          ///< a byte of wrong parity (a control says TH alarm, PS0001)
    tv,          ///< a block with an odd number of characters (TV alarm, PS0002)
    no_code,     ///< a character that the wanted code does not have
    no_percent,  ///< the tape ended without its final %
  };
  Kind kind = th;
  std::uint64_t offset = 0;  ///< of the byte in the input, from 0
  std::uint64_t line = 0;    ///< from 1
  std::uint64_t column = 0;  ///< from 1; 0: the whole block
  std::uint8_t byte = 0;
};

/// "th", "tv", "no_code" …: the key of a finding in messages.
std::string_view name_of(Finding::Kind kind);
/// One line in English: "line 3, column 7: byte 4D has wrong parity (TH)".
std::string describe(const Finding& finding);

/// Keeps the first thousand, counts all.
class Findings {
 public:
  void add(const Finding& finding) {
    if (kept_.size() < 1'000) kept_.push_back(finding);
    ++count_;
  }
  std::uint64_t count() const { return count_; }
  bool none() const { return count_ == 0; }
  const std::vector<Finding>& kept() const { return kept_; }

 private:
  std::vector<Finding> kept_;
  std::uint64_t count_ = 0;
};

}  // namespace headstock::tape

// Bytes of a tape or a line as program text, with the checks a control makes: TH (each character's parity),
// TV (an even number of characters a block). Streaming: memory does not grow with the tape. One thread at a
// time.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/tape/code.hpp"
#include "protocol/tape/finding.hpp"

namespace headstock::tape {

struct ReadFormat {
  Code code = Code::ascii;
  Symbols symbols;
  bool tv_check = false;           ///< No.0000#0 TVC; not before the first end of block (label skip)
  bool tv_counts_comments = true;  ///< No.0100#1 CTV = 0
  bool keep_cr = false;            ///< CR stays in the text; otherwise CR LF, LF CR CR and CR become LF
};

class Decoder {
 public:
  explicit Decoder(const ReadFormat& format);
  /// Appends the characters of `bytes` to `text`. A byte of wrong parity is left out and found.
  void put(std::string_view bytes, std::string& text);
  /// The end of the bytes.
  void finish(std::string& text);
  const Findings& findings() const { return findings_; }
  std::uint64_t bytes() const { return offset_; }

 private:
  void one(std::uint8_t byte, std::string& text);
  void character(char value, std::string& text);
  void end_block(std::string& text);

  ReadFormat format_;
  CharacterSet set_;
  Findings findings_;
  std::uint64_t offset_ = 0, line_ = 1, column_ = 0, block_characters_ = 0;
  bool labelled_ = false, in_comment_ = false, cr_waits_ = false, after_lf_ = false;
};

/// Converts a whole text; for tests and small files.
std::string decoded(std::string_view bytes, const ReadFormat& format, Findings* findings = nullptr);

}  // namespace headstock::tape

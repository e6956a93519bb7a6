// A program text on its way to the tape or the line: characters to bytes, end of block, leader and trailer,
// framing. Streaming: memory does not grow with the text. One thread at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/tape/code.hpp"
#include "protocol/tape/finding.hpp"

namespace headstock::tape {

/// How an end of block goes out. FANUC writes LF or LF CR CR (NCR, No.0100#3); PCs write CR LF.
enum class EndOfBlock { lf, cr_lf, lf_cr_cr, cr, keep };
std::string_view name_of(EndOfBlock form);
std::optional<EndOfBlock> end_of_block_named(std::string_view name);

struct PunchFormat {
  Code code = Code::ascii;
  Symbols symbols;
  EndOfBlock end_of_block = EndOfBlock::lf;  ///< `keep`: CRs of the text go out where they stand
  std::uint32_t leader = 0, trailer = 0;     ///< blank characters before and after, at most 10,000
  /// Puts a % line in front and a % behind unless the text has them. A control skips everything up to the
  /// first end of block after a reset (label skip): without the leading % it would lose the program's first
  /// block.
  bool frame = false;
  /// Makes the number of characters of each block even with a space before its end (TV check, PS0002).
  bool pad_for_tv = false;
  bool fold_case = false;  ///< lower-case letters go out as capitals
};

class Encoder {
 public:
  explicit Encoder(PunchFormat format);
  /// Appends the bytes of `text` to `out`. Characters without a code are left out and found.
  void put(std::string_view text, std::string& out);
  /// What comes behind the text: the last end of block, %, trailer.
  void finish(std::string& out);
  const Findings& findings() const { return findings_; }

 private:
  void begin(std::string& out);
  void frame_start(char first, std::string& out);
  void character(char character, std::string& out);
  void raw(char character, std::string& out);
  void end_block(std::string& out);

  PunchFormat format_;
  CharacterSet set_;
  Findings findings_;
  std::uint64_t offset_ = 0, line_ = 1, column_ = 0;
  std::uint64_t block_characters_ = 0;
  bool begun_ = false, framed_ = false, in_block_ = false, cr_waits_ = false, block_is_percent_ = false;
  bool percent_last_ = false;  ///< the last block with anything in it is % alone
};

}  // namespace headstock::tape

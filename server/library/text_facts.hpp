// What can be said of a program text without understanding it: encoding, line ends, longest line. Fed in
// pieces.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "db/program_store.hpp"

namespace headstock::library {

class TextFacts {
 public:
  void add(std::string_view bytes);
  /// Everything but the hash. Call once, at the end.
  db::BlobRow finish();

 private:
  void end_line();
  void see_utf8(unsigned char byte);
  void see_gbk(unsigned char byte);

  db::BlobRow facts_;
  std::int64_t line_length_ = 0;
  std::int64_t lf_ = 0, crlf_ = 0, cr_ = 0;  // line ends of each kind
  bool after_cr_ = false, high_bytes_ = false, text_seen_ = false;
  bool utf8_ok_ = true, gbk_ok_ = true, gbk_lead_ = false;
  int utf8_left_ = 0;  // continuation bytes still to come
  unsigned char utf8_low_ = 0x80,
                utf8_high_ = 0xBF;  // what the next one may be (no overlong forms, no surrogates)
};

/// The text as UTF-8 for people: GBK converted, bytes that are neither become U+FFFD, NUL becomes U+2400.
std::string to_utf8(std::string_view bytes, std::string_view encoding);

}  // namespace headstock::library

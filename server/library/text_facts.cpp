#include "server/library/text_facts.hpp"

#include <iconv.h>

#include <algorithm>

namespace headstock::library {

void TextFacts::end_line() {
  ++facts_.lines;
  facts_.longest_line = std::max(facts_.longest_line, line_length_);
  line_length_ = 0;
}

void TextFacts::see_utf8(unsigned char byte) {
  if (utf8_left_ > 0) {
    utf8_ok_ = utf8_ok_ && byte >= utf8_low_ && byte <= utf8_high_;
    utf8_low_ = 0x80;
    utf8_high_ = 0xBF;
    --utf8_left_;
    return;
  }
  if (byte < 0x80) return;
  utf8_left_ = byte >= 0xF0 ? 3 : byte >= 0xE0 ? 2 : 1;
  if (byte < 0xC2 || byte > 0xF4) utf8_ok_ = false;
  if (byte == 0xE0) utf8_low_ = 0xA0;
  if (byte == 0xED) utf8_high_ = 0x9F;
  if (byte == 0xF0) utf8_low_ = 0x90;
  if (byte == 0xF4) utf8_high_ = 0x8F;
}

void TextFacts::see_gbk(unsigned char byte) {
  if (gbk_lead_) {
    gbk_ok_ = gbk_ok_ && byte >= 0x40 && byte != 0x7F && byte != 0xFF;
    gbk_lead_ = false;
  } else if (byte >= 0x80) {
    gbk_ok_ = gbk_ok_ && byte != 0x80 && byte != 0xFF;
    gbk_lead_ = true;
  }
}

void TextFacts::add(std::string_view bytes) {
  facts_.bytes += static_cast<std::int64_t>(bytes.size());
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    high_bytes_ = high_bytes_ || byte >= 0x80;
    if (high_bytes_ && utf8_ok_) see_utf8(byte);
    if (high_bytes_ && gbk_ok_) see_gbk(byte);
    if (after_cr_ && c != '\n') ++cr_;
    if (c == '\n') {
      if (after_cr_) {
        ++crlf_;
      } else {
        ++lf_;
        end_line();
      }
    } else if (c == '\r') {
      end_line();
    } else {
      ++line_length_;
      facts_.nul_bytes += c == '\0';
      if (!text_seen_ && byte > ' ') {
        text_seen_ = true;
        facts_.has_percent = c == '%';
      }
    }
    after_cr_ = c == '\r';
  }
}

db::BlobRow TextFacts::finish() {
  if (after_cr_) ++cr_;
  if (line_length_ > 0) end_line();
  const bool utf8 = utf8_ok_ && utf8_left_ == 0;
  const bool gbk = gbk_ok_ && !gbk_lead_;
  facts_.encoding = !high_bytes_ ? "ascii" : utf8 ? "utf-8" : gbk ? "gbk" : "other";
  const int kinds = (lf_ > 0) + (crlf_ > 0) + (cr_ > 0);
  facts_.line_ends = kinds == 0 ? "none" : kinds > 1 ? "mixed" : lf_ > 0 ? "lf" : crlf_ > 0 ? "crlf" : "cr";
  return facts_;
}

namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD
constexpr std::string_view kNulSymbol = "\xE2\x90\x80";    // U+2400

/// One conversion of the C library per thread; opening it costs more than a line.
class GbkConverter {
 public:
  GbkConverter() : handle_(iconv_open("UTF-8", "GB18030")) {}
  ~GbkConverter() {
    if (usable()) iconv_close(handle_);
  }
  GbkConverter(const GbkConverter&) = delete;
  GbkConverter& operator=(const GbkConverter&) = delete;
  bool usable() const { return handle_ != reinterpret_cast<iconv_t>(-1); }  // NOLINT: that is its interface

  std::string convert(std::string_view bytes) {
    std::string text(bytes.size() * 3 + 4, '\0');
    char* in = const_cast<char*>(bytes.data());
    std::size_t in_left = bytes.size();
    char* out = text.data();
    std::size_t out_left = text.size();
    while (in_left > 0 && iconv(handle_, &in, &in_left, &out, &out_left) == static_cast<std::size_t>(-1) &&
           in_left > 0) {
      iconv(handle_, nullptr, nullptr, nullptr, nullptr);
      ++in;
      --in_left;
      out = std::copy(kReplacement.begin(), kReplacement.end(), out);
      out_left -= kReplacement.size();
    }
    text.resize(text.size() - out_left);
    return text;
  }

 private:
  iconv_t handle_;
};

/// Length of the well-formed UTF-8 sequence at the front, 0 when there is none.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  const unsigned char second = byte(1);
  const bool bad = (lead == 0xE0 && second < 0xA0) || (lead == 0xED && second > 0x9F) ||
                   (lead == 0xF0 && second < 0x90) || (lead == 0xF4 && second > 0x8F);
  return bad ? 0 : length;
}

}  // namespace

std::string to_utf8(std::string_view bytes, std::string_view encoding) {
  std::string converted;
  if (encoding == "gbk") {
    thread_local GbkConverter converter;
    if (converter.usable()) {
      converted = converter.convert(bytes);
      bytes = converted;
    }
  }
  std::string text;
  text.reserve(bytes.size());
  while (!bytes.empty()) {
    const std::size_t length = utf8_length(bytes);
    if (length == 0)
      text += kReplacement;
    else if (bytes.front() == '\0')
      text += kNulSymbol;
    else
      text += bytes.substr(0, length);
    bytes.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return text;
}

}  // namespace headstock::library

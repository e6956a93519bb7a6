#include "protocol/tape/decoder.hpp"

namespace headstock::tape {

Decoder::Decoder(const ReadFormat& format) : format_(format), set_(format.code, format.symbols) {}

void Decoder::end_block(std::string& text) {
  ++block_characters_;
  if (format_.tv_check && labelled_ && block_characters_ % 2 != 0)
    findings_.add({Finding::tv, offset_, line_, 0, 0});
  labelled_ = true;
  in_comment_ = false;
  block_characters_ = 0;
  text += '\n';
  ++line_, column_ = 0;
}

void Decoder::character(char value, std::string& text) {
  if (value == '\n') return end_block(text);
  ++column_;
  if (value == '(') in_comment_ = true;
  if (!in_comment_ || format_.tv_counts_comments) ++block_characters_;
  if (value == ')') in_comment_ = false;
  text += value;
}

void Decoder::one(std::uint8_t byte, std::string& text) {
  const Meaning meaning = set_.meaning_of(byte);
  const bool is_cr = meaning.kind == Meaning::ignored && meaning.value == '\r';
  // CR LF and LF CR CR are one end of block; CR alone is one too (files of old computers).
  if (cr_waits_ && !(meaning.kind == Meaning::character && meaning.value == '\n') && !is_cr) end_block(text);
  cr_waits_ = false;
  if (is_cr && !format_.keep_cr) {
    cr_waits_ = !after_lf_;
    return;
  }
  if (is_cr) {
    text += '\r';
    return;
  }
  if (meaning.kind == Meaning::feed) return;
  after_lf_ = meaning.kind == Meaning::character && meaning.value == '\n';
  if (meaning.kind == Meaning::character) return character(meaning.value, text);
  if (meaning.kind == Meaning::wrong_parity) findings_.add({Finding::th, offset_, line_, column_ + 1, byte});
}

void Decoder::put(std::string_view bytes, std::string& text) {
  for (const char byte : bytes) {
    one(static_cast<std::uint8_t>(byte), text);
    ++offset_;
  }
}

void Decoder::finish(std::string& text) {
  if (cr_waits_) end_block(text);
  cr_waits_ = false;
}

std::string decoded(std::string_view bytes, const ReadFormat& format, Findings* findings) {
  Decoder decoder(format);
  std::string text;
  decoder.put(bytes, text);
  decoder.finish(text);
  if (findings != nullptr) *findings = decoder.findings();
  return text;
}

}  // namespace headstock::tape

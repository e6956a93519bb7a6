#include "protocol/tape/encoder.hpp"

#include <algorithm>
#include <utility>

namespace headstock::tape {
namespace {

struct FormName {
  EndOfBlock form;
  std::string_view name;
};
constexpr FormName kForms[] = {{EndOfBlock::lf, "lf"},
                               {EndOfBlock::cr_lf, "crlf"},
                               {EndOfBlock::lf_cr_cr, "lfcrcr"},
                               {EndOfBlock::cr, "cr"},
                               {EndOfBlock::keep, "keep"}};
constexpr std::uint32_t kLongestFeed = 10'000;

}  // namespace

std::string_view name_of(EndOfBlock form) {
  for (const FormName& row : kForms)
    if (row.form == form) return row.name;
  return "";
}

std::optional<EndOfBlock> end_of_block_named(std::string_view name) {
  for (const FormName& row : kForms)
    if (row.name == name) return row.form;
  return std::nullopt;
}

Encoder::Encoder(PunchFormat format) : format_(std::move(format)), set_(format_.code, format_.symbols) {}

void Encoder::begin(std::string& out) {
  if (begun_) return;
  begun_ = true;
  out.append(std::min(format_.leader, kLongestFeed), '\0');
}

void Encoder::frame_start(char first, std::string& out) {
  if (framed_) return;
  framed_ = true;
  if (!format_.frame || first == '%') return;
  raw('%', out);
  block_characters_ = 1;
  end_block(out);
}

void Encoder::raw(char character, std::string& out) {
  if (const auto byte = set_.byte_of(character)) out += static_cast<char>(*byte);
}

void Encoder::end_block(std::string& out) {
  // The end of block is one of the block's characters, so an even number before it needs the space.
  if (format_.pad_for_tv && block_characters_ % 2 == 0) raw(' ', out);
  const bool has_cr = set_.byte_of('\r').has_value();
  const auto form = has_cr ? format_.end_of_block : EndOfBlock::lf;
  if (form == EndOfBlock::cr_lf) raw('\r', out);
  raw(form == EndOfBlock::cr ? '\r' : '\n', out);
  if (form == EndOfBlock::lf_cr_cr) out.append(2, static_cast<char>(*set_.byte_of('\r')));
  block_characters_ = 0;
}

void Encoder::character(char character, std::string& out) {
  if (format_.fold_case && character >= 'a' && character <= 'z')
    character = static_cast<char>(character - 'a' + 'A');
  const auto byte = set_.byte_of(character);
  if (!byte || (format_.code != Code::ascii && static_cast<unsigned char>(character) >= 0x80)) {
    findings_.add({Finding::no_code, offset_, line_, column_, static_cast<std::uint8_t>(character)});
    return;
  }
  out += static_cast<char>(*byte);
  ++block_characters_;
}

void Encoder::put(std::string_view text, std::string& out) {
  begin(out);
  for (const char next : text) {
    const bool was_cr = std::exchange(cr_waits_, false);
    if (next == '\r' && (format_.end_of_block != EndOfBlock::keep || format_.code == Code::eia)) {
      cr_waits_ = true;  // part of an end of block; one alone (old files) ends a block too
      ++offset_;
      continue;
    }
    if (was_cr && next != '\n') {
      if (framed_) end_block(out);
      ++line_, column_ = 0, in_block_ = false;
    }
    if (next == '\n') {
      if (framed_ || !format_.frame) end_block(out);
      if (in_block_) percent_last_ = block_is_percent_;
      ++line_, column_ = 0, in_block_ = false;
    } else {
      frame_start(next, out);
      ++column_;
      if (next != ' ' && next != '\r') {
        block_is_percent_ = !in_block_ && next == '%';
        in_block_ = true;
      }
      character(next, out);
    }
    ++offset_;
  }
}

void Encoder::finish(std::string& out) {
  begin(out);
  if (cr_waits_ && framed_) end_block(out), in_block_ = false;
  if (in_block_) percent_last_ = block_is_percent_;
  if (format_.frame && !percent_last_) {
    frame_start(' ', out);
    if (in_block_) end_block(out);
    raw('%', out);
    block_characters_ = 1;
    end_block(out);
  }
  out.append(std::min(format_.trailer, kLongestFeed), '\0');
}

}  // namespace headstock::tape

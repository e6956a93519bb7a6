#include "server/dnc/outgoing.hpp"

#include <algorithm>
#include <array>
#include <fstream>

#include "db/hash.hpp"
#include "protocol/tape/decoder.hpp"

namespace headstock::dnc {
namespace {

constexpr std::size_t kPiece = 4'096;

class Outgoing final : public serial::Source {
 public:
  Outgoing(const OutgoingText& text, const PortSettings& settings)
      : header_(text.header), filter_(settings.filter), encoder_(serial::punch_format(settings.link)) {
    if (text.file.empty()) {
      file_over_ = true;
      return;
    }
    in_.open(text.file, std::ios::binary);
    if (text.offset > 0) in_.seekg(static_cast<std::streamoff>(text.offset));
    if (!in_) reason_ = "blob_unreadable";
  }

  Result read(std::span<char> into) override {
    while (at_ == bytes_.size() && !finished_ && reason_.empty()) fill();
    if (!reason_.empty()) return {Status::failed, 0};
    if (at_ == bytes_.size()) return {Status::end, 0};
    const std::size_t count = bytes_.copy(into.data(), into.size(), at_);
    at_ += count;
    return {Status::data, count};
  }
  std::string reason() const override { return reason_; }
  const tape::Findings& findings() const { return encoder_.findings(); }

 private:
  void fill() {
    bytes_.clear();
    at_ = 0;
    std::string text;
    if (!header_.empty()) {
      filter_.put(header_, text);
      header_.clear();
    } else if (!file_over_) {
      std::array<char, kPiece> piece;
      in_.read(piece.data(), piece.size());
      if (in_.bad()) reason_ = "blob_unreadable";
      filter_.put({piece.data(), static_cast<std::size_t>(in_.gcount())}, text);
      file_over_ = in_.gcount() == 0;
    } else {
      filter_.finish(text);
      encoder_.put(text, bytes_);
      encoder_.finish(bytes_);
      finished_ = true;
      return;
    }
    encoder_.put(text, bytes_);
    if (!encoder_.findings().none()) reason_ = "no_code";
  }

  std::string header_;
  std::ifstream in_;
  tape::Filter filter_;
  tape::Encoder encoder_;
  std::string bytes_, reason_;
  std::size_t at_ = 0;
  bool file_over_ = false, finished_ = false;
};

}  // namespace

OutgoingFacts examine(const OutgoingText& text, const PortSettings& settings) {
  OutgoingFacts facts;
  std::array<char, 65'536> piece;
  if (settings.filter.number_step > 0 && !text.file.empty()) {
    std::ifstream in(text.file, std::ios::binary);
    tape::ReferenceSearch search;
    while (in.read(piece.data(), piece.size()), in.gcount() > 0)
      search.put({piece.data(), static_cast<std::size_t>(in.gcount())});
    search.finish();
    if (search.line() != 0) {
      facts.reason = "numbers_are_used";
      facts.where = std::to_string(search.line());
      return facts;
    }
  }
  Outgoing source(text, settings);
  db::Sha256 hash;
  for (;;) {
    const auto result = source.read(piece);
    if (result.status == serial::Source::Status::failed) {
      facts.reason = source.reason();
      if (!source.findings().none()) facts.where = tape::describe(source.findings().kept().front());
      return facts;
    }
    if (result.count == 0) break;
    facts.bytes += result.count;
    hash.add({piece.data(), result.count});
  }
  const auto ending = serial::send_rules(settings.link).ending;
  facts.bytes += ending.size();
  hash.add(ending);
  facts.sha256 = hash.hex();
  return facts;
}

Tail tail_of(const OutgoingText& text, const PortSettings& settings, std::int64_t from_line,
             std::uint64_t bytes) {
  constexpr std::size_t kKept = 400;
  Tail tail;
  tail.known = true;
  tape::Filter filter(settings.filter);
  tape::Encoder encoder(serial::punch_format(settings.link));
  std::string kept;
  std::uint64_t made = 0;
  std::string thinned, coded;
  // @return whether all of this had gone out.
  const auto went = [&](std::string_view piece, bool last) {
    thinned.clear();
    coded.clear();
    if (last)
      filter.finish(thinned);
    else
      filter.put(piece, thinned);
    encoder.put(thinned, coded);
    if (last) encoder.finish(coded);
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(coded.size(), bytes - made));
    kept.append(coded, 0, count);
    if (kept.size() > 4 * kKept) kept.erase(0, kept.size() - kKept);
    made += count;
    return count == coded.size();
  };
  bool whole = text.header.empty() || went(text.header, false);
  std::ifstream in(text.file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(text.offset));
  std::int64_t line = from_line;
  std::string before;
  if (text.offset == 0)
    for (std::int64_t skipped = 1; skipped < from_line; ++skipped) std::getline(in, before);
  for (std::string one; whole && made < bytes && std::getline(in, one); ++line) {
    whole = went(one + "\n", false);
    if (whole) tail.line = line;
  }
  if (whole && made < bytes) went("", true);
  if (kept.size() > kKept) kept.erase(0, kept.size() - kKept);
  tail.text = tape::decoded(kept, serial::read_format(settings.link));
  return tail;
}

std::unique_ptr<serial::Source> outgoing(const OutgoingText& text, const PortSettings& settings) {
  return std::make_unique<Outgoing>(text, settings);
}

}  // namespace headstock::dnc

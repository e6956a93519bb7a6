// A program that arrives byte by byte.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "program/source.hpp"

namespace headstock::interp {

/// Gives `piece` bytes at a time, and nothing every second time.
class Dripping final : public program::Source {
 public:
  Dripping(std::string text, std::size_t piece) : text_(std::move(text)), piece_(piece) {}
  program::ReadResult read(std::span<char> buffer) override {
    if (waiting_ = !waiting_; waiting_) return {program::ReadStatus::wait, 0};
    if (at_ == text_.size()) return {program::ReadStatus::end, 0};
    const std::size_t bytes = std::min({piece_, text_.size() - at_, buffer.size()});
    std::copy_n(text_.data() + at_, bytes, buffer.data());
    at_ += bytes;
    return {program::ReadStatus::data, bytes};
  }
  bool seek(std::uint64_t) override { return false; }

 private:
  std::string text_;
  std::size_t piece_, at_ = 0;
  bool waiting_ = false;
};

}  // namespace headstock::interp

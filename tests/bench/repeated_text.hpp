// A program as long as wanted without being kept in memory: one piece over and over.
#pragma once

#include <algorithm>
#include <string>

#include "protocol/wire/digest.hpp"
#include "server/gateway/gateway.hpp"

namespace headstock::bench {

class RepeatedText final : public server::BlobReader {
 public:
  RepeatedText(std::string piece, std::uint64_t size) : piece_(std::move(piece)), size_(size) {}
  std::uint64_t size() const override { return size_; }
  std::size_t read(std::uint64_t offset, char* into, std::size_t at_most) override {
    const auto at = static_cast<std::size_t>(offset % piece_.size());
    const std::size_t count =
        std::min<std::size_t>({at_most, piece_.size() - at, static_cast<std::size_t>(size_ - offset)});
    piece_.copy(into, count, at);
    return count;
  }
  std::string sha256() {
    wire::Sha256 digest;
    std::string some(1 << 20, '\0');
    for (std::uint64_t at = 0; at < size_;) {
      const std::size_t got = read(at, some.data(), some.size());
      digest.update({some.data(), got});
      at += got;
    }
    return digest.hex();
  }

 private:
  std::string piece_;
  std::uint64_t size_;
};

}  // namespace headstock::bench

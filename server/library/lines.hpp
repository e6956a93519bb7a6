// Windows into texts of any size: an index of every 1,024th line, made at the first look and kept for the
// last few texts. Memory is bounded: 8 bytes per 1,024 lines, windows of at most 2,000 lines and 1 MiB.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "db/blobs.hpp"

namespace headstock::library {

/// Bytes of a line that a page gets to see.
constexpr std::size_t kLongestShown = 4'096;

struct LineText {
  std::int64_t number = 0;  ///< from 1
  std::string text;         ///< UTF-8, at most 4 KiB of it
  bool cut = false;         ///< the line is longer than that
};
struct LineWindow {
  std::vector<LineText> lines;
  std::int64_t total = 0;
};

/// Any thread (workers).
class LineReader {
 public:
  explicit LineReader(const db::Blobs& blobs) : blobs_(blobs) {}
  /// @param from first line, from 1. Past the end: no lines.
  LineWindow window(const std::string& sha256, const std::string& encoding, std::int64_t from,
                    std::int64_t count);

 private:
  struct Index {
    std::vector<std::uint64_t> every_1024th;
    std::int64_t total = 0;
  };
  std::shared_ptr<const Index> index(const std::string& sha256);

  const db::Blobs& blobs_;
  std::mutex mutex_;
  std::list<std::pair<std::string, std::shared_ptr<const Index>>> recent_;  // newest first, at most 16
};

}  // namespace headstock::library

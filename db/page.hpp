// A piece of a long list: newest first, the next piece starts below `next`.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace headstock::db {

struct Page {
  std::int64_t before = 0;  ///< only rows with a smaller id; 0: from the newest
  int limit = 100;          ///< 1…1000
};

template <class T>
struct Listed {
  std::vector<T> items;
  std::optional<std::int64_t> next;  ///< Page::before of the next piece; nothing when this was the last
};

}  // namespace headstock::db

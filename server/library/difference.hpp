// What changed between two revisions, line by line, and what kind of change it is: whether somebody reworded
// a comment or moved a tool path decides who may release it. Bounded time: texts that have too little in
// common become whole changed blocks.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace headstock::library {

enum class RowKind { same, changed, added, removed, skipped };
/// In growing order of consequence; a row with several kinds of change has the highest.
enum class ChangeClass { none, comment, feed_speed, offset, geometry, structure };

std::string_view to_string(RowKind kind);
std::string_view to_string(ChangeClass change);

struct DiffRow {
  RowKind kind = RowKind::same;
  ChangeClass change = ChangeClass::none;
  std::int64_t left_line = 0, right_line = 0;  ///< from 1; 0 where that side has none
  std::string left, right;                     ///< UTF-8
  std::int64_t skipped = 0;                    ///< RowKind::skipped: so many equal lines left out
};

struct Difference {
  std::vector<DiffRow> rows;
  std::vector<ChangeClass> classes;  ///< that occur, in growing order; empty: equal
  std::int64_t changed = 0, added = 0, removed = 0;
  bool truncated = false;  ///< more rows than max_rows: counts and classes are complete nevertheless
  bool coarse = false;     ///< effort limit reached: some blocks are shown as replaced as a whole
};

struct DiffOptions {
  std::int64_t context = -1;  ///< equal lines kept around changes; -1: all of them
  std::int64_t max_rows = 20'000;
  std::int64_t effort = 20'000'000;  ///< steps of the search
};

/// @param left,right bytes; @param left_encoding as in db::BlobRow. Any thread.
Difference compare(std::string_view left, std::string_view left_encoding, std::string_view right,
                   std::string_view right_encoding, const DiffOptions& options = {});

/// What kind of change one block is, when it becomes the other. An empty side: added or removed.
ChangeClass classify(std::string_view left, std::string_view right);

}  // namespace headstock::library

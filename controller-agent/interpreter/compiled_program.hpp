// Blocks of one program that hold macro statements or expressions, compiled once and found again by where
// they stand; blocks inside loops and sub-programs too. What is never met again is never kept: plain programs
// run through without leaving anything here.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "macro/compile.hpp"
#include "program/block.hpp"
#include "program/block_reader.hpp"

namespace headstock::interp {

/// Where a block begins: a line of the source and the bytes of that line before it.
struct BlockPlace {
  program::LinePlace line;
  std::uint32_t within = 0;
  std::uint64_t offset() const { return line.byte_offset + within; }
};

/// A Block without its empty room.
class PackedBlock {
 public:
  void pack(const program::Block& block);
  void unpack(program::Block& block) const;

 private:
  std::uint32_t words_ = 0, marked_ = 0, pointed_ = 0, negative_ = 0, repeated_ = 0, inner_slash_ = 0;
  bool m_pointed_ = false;
  std::uint8_t g_count_ = 0;
  std::vector<program::Word> word_;   // then the marked ones
  std::vector<program::Code> codes_;  // G, then M
  std::vector<program::EarlierWord> earlier_;
  std::vector<program::ComputedWord> computed_;
};

struct CompiledBlock {
  BlockPlace place, after;
  program::LinePlace next_line;  ///< of the line behind it
  bool ends_line = true;
  bool is_statement = false;
  bool is_empty = false;  ///< neither words nor codes
  bool has_sequence = false, has_number = false;
  std::uint32_t sequence = 0, number = 0, skip = 0;
  std::uint32_t column = 0;  ///< of the statement
  macro::Statement statement;
  PackedBlock block;
  std::vector<macro::Expression> expressions;

  CompiledBlock* next = nullptr;  ///< the block that follows, when it is known and kept
  // Found by reading ahead when the DO is met for the first time.
  bool loop_known = false;
  BlockPlace loop_end;    ///< of a DO: where its END stands
  BlockPlace loop_after;  ///< of a DO: what follows its END
  /// Sequence numbers this block has jumped to, and where they are.
  std::vector<std::pair<std::uint32_t, BlockPlace>> targets;
};

class CompiledProgram {
 public:
  /// Blocks kept at most, loops aside.
  static constexpr std::size_t kMost = 8'192;

  bool empty() const { return blocks_.empty(); }
  std::size_t size() const { return blocks_.size(); }
  CompiledBlock* find(std::uint64_t offset) {
    const auto found = blocks_.find(offset);
    return found == blocks_.end() ? nullptr : found->second.get();
  }
  CompiledBlock* keep(std::unique_ptr<CompiledBlock> block) {
    auto& place = blocks_[block->place.offset()];
    place = std::move(block);
    return place.get();
  }
  void clear() { blocks_.clear(); }

 private:
  std::unordered_map<std::uint64_t, std::unique_ptr<CompiledBlock>> blocks_;
};

}  // namespace headstock::interp

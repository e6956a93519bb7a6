#include "interpreter/compiled_program.hpp"

#include <algorithm>
#include <bit>

namespace headstock::interp {

void PackedBlock::pack(const program::Block& b) {
  words_ = b.words;
  marked_ = b.marked;
  pointed_ = b.pointed;
  negative_ = b.negative;
  repeated_ = b.repeated;
  inner_slash_ = b.inner_slash;
  m_pointed_ = b.m_pointed;
  g_count_ = b.g_count;
  for (std::uint32_t mask = b.words; mask != 0; mask &= mask - 1)
    word_.push_back(b.word[static_cast<std::size_t>(std::countr_zero(mask))]);
  for (std::uint32_t mask = b.marked; mask != 0; mask &= mask - 1)
    word_.push_back(b.marked_word[static_cast<std::size_t>(std::countr_zero(mask))]);
  codes_.assign(b.g.begin(), b.g.begin() + b.g_count);
  codes_.insert(codes_.end(), b.m.begin(), b.m.begin() + b.m_count);
  earlier_.assign(b.earlier.begin(), b.earlier.begin() + b.earlier_count);
  computed_.assign(b.computed.begin(), b.computed.begin() + b.computed_count);
}

void PackedBlock::unpack(program::Block& b) const {
  b.clear();
  b.words = words_;
  b.marked = marked_;
  b.pointed = pointed_;
  b.negative = negative_;
  b.repeated = repeated_;
  b.inner_slash = inner_slash_;
  b.m_pointed = m_pointed_;
  b.g_count = g_count_;
  b.m_count = static_cast<std::uint8_t>(codes_.size() - g_count_);
  b.earlier_count = static_cast<std::uint8_t>(earlier_.size());
  b.computed_count = static_cast<std::uint8_t>(computed_.size());
  const program::Word* word = word_.data();
  for (std::uint32_t mask = words_; mask != 0; mask &= mask - 1)
    b.word[static_cast<std::size_t>(std::countr_zero(mask))] = *word++;
  for (std::uint32_t mask = marked_; mask != 0; mask &= mask - 1)
    b.marked_word[static_cast<std::size_t>(std::countr_zero(mask))] = *word++;
  std::copy(codes_.begin(), codes_.begin() + g_count_, b.g.begin());
  std::copy(codes_.begin() + g_count_, codes_.end(), b.m.begin());
  std::copy(earlier_.begin(), earlier_.end(), b.earlier.begin());
  std::copy(computed_.begin(), computed_.end(), b.computed.begin());
}

}  // namespace headstock::interp

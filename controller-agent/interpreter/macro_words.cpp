// Values of expressions behind addresses, put into the block as if they had been typed.
#include <cmath>

#include "interpreter/executor.hpp"

namespace headstock::interp {

using macro::Result;

namespace {

constexpr double kNanoScale = 1e9;
constexpr double kMostWord = 1e9;

// Half away from zero (0i-D L13550).
std::int64_t nearest_step(double value, double steps) {
  return static_cast<std::int64_t>(std::copysign(std::floor(std::fabs(value) * steps + 0.5), value));
}

void forget(program::Block& block, const program::ComputedWord& word) {
  if (word.marked) {
    block.marked &= ~program::letter_bit(word.letter);
  } else if (word.place == 0) {
    block.words &= ~program::letter_bit(word.letter);
  }
}

}  // namespace

Result Executor::fill_computed(const CompiledBlock& compiled) {
  std::size_t g_removed = 0, m_removed = 0;
  macros->filled = &compiled.expressions;
  const bool h_block = is_h_block();
  for (std::size_t i = 0; i < block.computed_count; ++i) {
    const program::ComputedWord& word = block.computed[i];
    const bool is_code = word.letter == 'G' || word.letter == 'M';
    const auto letter = program::letter_index(word.letter);
    const std::uint32_t bit = program::letter_bit(word.letter);
    // Least increments a unit: what the value, and ROUND in its expression, is rounded to.
    double per_unit = 1;
    if (is_code) {
      per_unit = 10;
    } else if (axis_of[letter] >= 0 && !word.marked) {
      per_unit = kNanoScale / static_cast<double>(axes[static_cast<std::size_t>(axis_of[letter])].increment);
    } else if (word.letter == 'F' || word.letter == 'E') {
      per_unit = 1e6;
    } else if ((may_point & bit) != 0 || word.marked) {
      per_unit = kNanoScale / static_cast<double>(linear_increment);
    }
    double value = 0;
    const Result result =
        macro::evaluate(compiled.expressions[word.expression], macros->variables, is_code ? 1 : per_unit, value);
    const std::uint32_t column = is_code           ? 0
                                 : word.marked     ? block.marked_word[letter].column
                                 : word.place == 0 ? block.word[letter].column
                                                   : block.earlier[word.place - 1u].word.column;
    at.column = column;
    if (result.status == macro::Status::fault && h_block && word.letter == 'P') {
      macros->computed[i] = macro::kNull;  // P names the variable; it may be one that can only be written
      forget(block, word);
      continue;
    }
    if (!result.ok()) return result;
    macros->computed[i] = value;
    if (macro::is_null(value)) {  // the address counts as not written (L13573)
      if (word.letter == 'G') program::remove_code(block.g, block.g_count, word.place - g_removed++);
      if (word.letter == 'M') program::remove_code(block.m, block.m_count, word.place - m_removed++);
      if (!is_code) forget(block, word);
      continue;
    }
    if (!(std::fabs(value) < kMostWord)) return Result::failed(AlarmReason::too_many_digits);
    if (is_code) {
      program::Code& into =
          word.letter == 'G' ? block.g[word.place - g_removed] : block.m[word.place - m_removed];
      at.column = into.column;
      const std::int64_t tenths = nearest_step(value, 10);
      if (tenths < 0) return Result::failed(AlarmReason::minus_sign);
      if (tenths >= 1'000'000'000) return Result::failed(AlarmReason::value_range);
      into.tenths = static_cast<std::int32_t>(tenths);
      continue;
    }
    program::Word& into = word.marked       ? block.marked_word[letter]
                          : word.place == 0 ? block.word[letter]
                                            : block.earlier[word.place - 1u].word;
    const std::int64_t rounded = nearest_step(value, per_unit);
    into.digits = rounded * static_cast<std::int64_t>(kNanoScale / per_unit);
    into.decimals = program::kNanoDecimals;
    into.point = true;
    const bool negative = rounded < 0;
    if (word.marked) continue;
    if (word.place != 0) {
      block.earlier[word.place - 1u].negative = negative;
    } else if (negative) {
      block.negative |= bit;
    } else {
      block.negative &= ~bit;
    }
  }
  at.column = 0;
  return {};
}

}  // namespace headstock::interp

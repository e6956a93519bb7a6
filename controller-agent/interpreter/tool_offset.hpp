// Tool offsets in force: what T, G43/G44/H chose, and how it is carried out (dialects' ToolOffsetRules). An
// offset *by shift* moves the zero point under the standing slides. An offset *by movement* moves the zero
// point and leaves the programmed position as it is, so that the slide makes up for it: in the T block
// itself, or with the next move of its axis.
#pragma once

#include <cstdint>

#include "machine/axes.hpp"

namespace headstock::interp {

struct Executor;

/// State of one path. Slide mm; all of it is part of the axes' `zero_tool`.
struct ToolOffsetState {
  machine::AxisVector move{};           ///< by movement
  machine::AxisVector shift_wear{};     ///< wear by shift; what is left of `zero_tool` is geometry by shift
  std::int64_t geometry = 0, wear = 0;  ///< numbers in force (lathe)
  std::uint32_t length_axes = 0;        ///< bit i: G43/G44 holds axis i (mill)
  std::uint64_t seen_version = 0;       ///< of the machine data, for values that count at once
};

namespace tool_offset {

/// How many offset numbers this machine has.
std::int64_t most(const Executor& ex);

/// The offset numbers of a T word take effect. @return false after an alarm.
bool take(Executor& ex, std::int64_t geometry, std::int64_t wear, std::uint32_t column);
/// The offset of an axis is gone (reference point return of GSK).
void drop(Executor& ex, std::size_t axis);
/// The offset in force grew by `slide_mm` because its wear was measured: the position page follows at once.
void grow(Executor& ex, std::size_t axis, double slide_mm);
/// A value of the offset page in slide mm, and back.
double to_slide(const Executor& ex, std::size_t axis, double page, bool wear);
double to_page(const Executor& ex, std::size_t axis, double slide_mm, bool wear);

/// Whether the axis takes length offsets (K2000TC OFL).
bool counts_on(const Executor& ex, std::size_t axis);
/// The slides make up for an offset that changed by movement, in a block without axis words: in G00 and in
/// cycles at rapid, otherwise at F. @return false after an alarm.
bool move_alone(Executor& ex);

/// G43 G44 G49. @return false after an alarm.
bool take_length(Executor& ex, int sign);
/// H without G43 or G44. @return false after an alarm.
bool take_h(Executor& ex);
/// Before a block: a value changed on the offset page counts at once where a parameter says so.
void follow_changes(Executor& ex);

/// RESET.
void reset(Executor& ex);

}  // namespace tool_offset
}  // namespace headstock::interp

// G45-G48: a move made longer or shorter by the offset D (0i-D M series). The next absolute command leads to
// its own place again, an incremental one counts from where the tool stands.
#include <bit>
#include <cmath>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"
#include "interpreter/offset_memory.hpp"

namespace headstock::interp::handlers {

bool tool_step(Executor& ex) {
  if (!ex.compensation_is_off())
    return ex.alarm(AlarmReason::step_in_compensation, ex.code_column, std::string(ex.code->name));
  const bool straight = ex.motion_code->tenths == 0 || ex.motion_code->tenths == 10;
  if (!straight || ex.cycle.hole.code != nullptr)
    return ex.alarm(AlarmReason::g_not_now, ex.code_column, std::string(ex.code->name));
  const double offset_mm = tool_offset::radius_value(ex, ex.pipeline.d_number);
  // G45 + once, G46 − once, G47 + twice, G48 − twice.
  const int step = (ex.code->tenths - 450) / 10;
  const double factor = (step % 2 == 0 ? 1 : -1) * (step < 2 ? 1 : 2);
  for (std::uint32_t mask = ex.block.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    program::Word& word = ex.block.word[letter];
    const ProgramAxis& axis = ex.axes[static_cast<std::size_t>(ex.axis_of[letter])];
    if (axis.rotary) return ex.alarm(AlarmReason::g_not_now, word.column, std::string(ex.code->name));
    const bool by = ex.incremental || (ex.incremental_letters >> letter & 1u) != 0;
    const std::int64_t value = ex.round_to(ex.axis_value(word, axis), axis.increment);
    const std::int64_t way = by ? value : value - axis.position;
    if (way == 0 && !by) continue;  // no move: nothing to make longer
    const bool backward = way < 0 || (way == 0 && (ex.block.negative >> letter & 1u) != 0);
    const double extra = factor * (backward ? -1 : 1) * offset_mm / axis.mm_per_unit;
    word.digits = value + std::llround(extra * 1e9);
    word.decimals = 9;
    word.point = true;
  }
  ex.code = ex.motion_code;
  return ex.motion_code->tenths == 0 ? ex.rapid() : ex.feed();
}

}  // namespace headstock::interp::handlers

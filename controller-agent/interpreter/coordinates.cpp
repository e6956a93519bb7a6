// Coordinate systems: setting, local, selection, and moves in machine coordinates.
#include <algorithm>
#include <bit>
#include <iterator>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp::handlers {
namespace {

// Calls `apply(axis index, value in nano units, is incremental)` for each axis word of the block.
template <typename Apply>
bool for_axis_words(Executor& ex, const Apply& apply) {
  for (std::uint32_t mask = ex.block.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    const auto axis = static_cast<std::size_t>(ex.axis_of[letter]);
    const program::Word& word = ex.block.word[letter];
    const bool by = (ex.incremental_letters >> letter & 1u) != 0;
    if (!apply(axis, ex.axis_value(word, ex.axes[axis]), by, word)) return false;
  }
  return true;
}

// P belongs to another code of the block: a dwell, G10, a reference point, a skip, G53, or a call.
bool p_is_taken(const Executor& ex) {
  constexpr std::int16_t kTakeP[] = {40, 100, 300, 310, 530};
  if (ex.action != nullptr &&
      std::find(std::begin(kTakeP), std::end(kTakeP), ex.action->tenths) != std::end(kTakeP))
    return true;
  for (std::size_t i = 0; i < ex.block.m_count; ++i) {
    const dialects::MAction what = ex.dialect.m_action(ex.block.m[i].tenths / 10);
    if (what == dialects::MAction::call || what == dialects::MAction::return_) return true;
  }
  return false;
}

double to_slide(const Executor& ex, std::size_t axis, std::int64_t value) {
  return static_cast<double>(ex.round_to(value, ex.axes[axis].increment)) / 1e9 * ex.axes[axis].mm_per_unit;
}

}  // namespace

// G50 / G92: the present position gets these coordinates; every work system shifts by as much (0i-D 7.2).
bool set_coordinates(Executor& ex) {
  if ((ex.block.words & ex.axis_letters) == 0) return true;  // G50 S: see take_spindle
  if (ex.data.bit(ex.dialect.setting_refused_parameter)) {
    return ex.alarm(AlarmReason::illegal_g, ex.code_column, std::string(ex.code->name));
  }
  // M series: not where the length offset changes in the same block (0i-D 4.16).
  if (!ex.dialect.tools.lathe && (ex.pending_axes != 0 || ex.block.has('H')))
    return ex.alarm(AlarmReason::setting_with_length, ex.code_column, std::string(ex.code->name));
  ex.pipeline.drop_for_setting();
  return for_axis_words(ex, [&ex](std::size_t i, std::int64_t value, bool by, const program::Word&) {
    ProgramAxis& axis = ex.axes[i];
    const bool add = by || ex.incremental;
    const double wanted = (add ? ex.slide_mm(i) : 0) + to_slide(ex, i, value);
    const double zero = ex.machine_now[i] - wanted;
    const double tool = ex.dialect.setting_ignores_offset && !add ? 0 : axis.zero_tool;
    axis.zero_local = 0;
    axis.zero_shift = zero - axis.zero_external - axis.zero_work - tool;
    axis.start_point = ex.machine_now[i];
    axis.has_start_point = true;
    ex.update_zero(i);
    return true;
  });
}

// G92.1 / G50.3: back to machine origin + work offset for the axes named.
bool preset_coordinates(Executor& ex) {
  return for_axis_words(ex, [&ex](std::size_t i, std::int64_t, bool, const program::Word&) {
    ex.axes[i].zero_shift = ex.axes[i].zero_local = 0;
    ex.update_zero(i);
    return true;
  });
}

// G52: local origin in the work system; IP0 cancels.
bool local(Executor& ex) {
  return for_axis_words(ex, [&ex](std::size_t i, std::int64_t value, bool, const program::Word&) {
    ex.axes[i].zero_local = to_slide(ex, i, value);
    ex.update_zero(i);
    return true;
  });
}

// G53: rapid to machine coordinates, absolute only.
bool machine_move(Executor& ex) {
  AxisVector target = ex.machine_now;
  std::uint32_t moved = 0;
  const bool ok =
      for_axis_words(ex, [&](std::size_t i, std::int64_t value, bool by, const program::Word& word) {
        if (by || ex.incremental) {
          if (!ex.dialect.machine_incremental_is_alarm) return true;  // the word is ignored (0i-D 7.1)
          return ex.alarm(AlarmReason::machine_incremental, word.column, std::string(ex.code->name));
        }
        target[i] = to_slide(ex, i, value);
        moved |= 1u << i;
        return true;
      });
  if (!ok) return false;
  if (moved == 0) return true;
  // P1: the next rapid may begin before this one stands still (0i-D 4.19).
  bool overlap = false;
  if (ex.block.has('P') && ex.block.m_count == 0) {
    const std::int64_t p = ex.whole('P', AlarmReason::value_range);
    if (p < 0) return false;
    if (p != 1) return ex.alarm(AlarmReason::value_range, ex.block['P'].column, "P" + std::to_string(p));
    overlap = true;
  }
  if (ex.dialect.look_ahead.machine_moves) ex.hold_look_ahead();  // 0i-D 7.1
  return ex.emit_rapid_to_machine(target, moved, true, overlap);
}

// G54…G59; on a control with additional systems `G54 P` is one of those.
bool work_select(Executor& ex) {
  const bool extra_code = ex.code->tenths == 541;
  const bool may_be_extra = extra_code || (ex.code->tenths == 540 && ex.table->find(541) != nullptr);
  bool extra = extra_code;
  std::size_t index = extra_code ? 0 : static_cast<std::size_t>((ex.code->tenths - 540) / 10);
  if (may_be_extra && ex.block.has('P') && (extra_code || !p_is_taken(ex))) {
    if (p_is_taken(ex)) return ex.alarm(AlarmReason::work_number, ex.block['P'].column, "P");  // 0i-D L7080
    const std::int64_t p = ex.whole('P', AlarmReason::work_number);
    if (p < 0) return false;
    if (p < 1 || p > 48)
      return ex.alarm(AlarmReason::work_number, ex.block['P'].column, "P" + std::to_string(p));
    extra = true;
    index = static_cast<std::size_t>(p - 1);
  }
  ex.work_is_extra = extra;
  ex.work_index = index;
  if (extra) ex.modal.g[ex.code->group] = 541;
  if (ex.dialect.local_per_system) {
    for (auto& axis : ex.axes) axis.zero_local = 0;
  }
  ex.update_zeros();
  return true;
}

}  // namespace headstock::interp::handlers

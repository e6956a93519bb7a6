#include "interpreter/tool_offset.hpp"

#include <bit>
#include <cmath>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"
#include "interpreter/offset_memory.hpp"

namespace headstock::interp::tool_offset {
namespace {

constexpr double kNothing_mm = 1e-9;

const ToolOffset* row(const Executor& ex, std::int64_t number) {
  const auto index = static_cast<std::size_t>(number);
  return number > 0 && index < ex.data.tools.size() ? &ex.data.tools[index] : nullptr;
}

struct Way {
  bool geometry_moves, wear_moves;
};

Way way_of(const Executor& ex) {
  const auto& rules = ex.dialect.tool_offsets;
  if (!rules.wear_shift_parameter.empty()) {
    const bool wear_moves = !ex.data.bit(rules.wear_shift_parameter);
    const bool single = ex.data.bit(rules.single_parameter);
    return {single ? wear_moves : ex.data.bit(rules.geometry_move_parameter), wear_moves};
  }
  const bool shift = rules.shift_parameter.empty()
                         ? rules.by_shift
                         : ex.data.parameter(rules.shift_parameter, rules.shift_default) != 0;
  return {!shift, !shift};
}

// The zero point under the standing slide. A way that the slide has still to make up for stays.
void shift(Executor& ex, std::size_t axis, double by) {
  if (std::fabs(by) < kNothing_mm) return;
  const double machine = ex.machine_now[axis];
  const double owed = ex.to_machine(axis, ex.axes[axis].position) - machine;
  ex.axes[axis].zero_tool += by;
  ex.update_zero(axis);
  if (std::fabs(owed) < 1e-6 || ex.transform.active()) return;
  ex.set_axis_machine(axis, machine + owed);
  ex.machine_now[axis] = machine;
}

// The zero point and, later, the slide: the programmed position stays.
void move(Executor& ex, std::size_t axis, double by) {
  ex.axes[axis].zero_tool += by;
  ex.modal.work_zero[axis] += by;
  ex.keep_mirror_place(axis);
}

bool is_arc(const GCode& code) {
  return code.tenths == 20 || code.tenths == 30;
}

void hold_length(Executor& ex, std::size_t axis) {
  const double wanted = ex.length_sign * length_value(ex, ex.length_offset);
  const double by = wanted - ex.axes[axis].zero_tool;
  ex.tool_offset.length_axes = ex.length_sign != 0 ? ex.tool_offset.length_axes | 1u << axis
                                                   : ex.tool_offset.length_axes & ~(1u << axis);
  if (by == 0) return;
  move(ex, axis, by);
  ex.pending_axes |= 1u << axis;
}

// A row and its wear may be in range each and their sum not: such an offset is none.
bool too_large(const Executor& ex, double page) {
  return std::fabs(page) > ex.dialect.modes.largest_offset * ex.unit_mm;
}

// The axis that G43 and G44 mean in this block. -1 after an alarm.
int length_axis(Executor& ex) {
  const auto& rules = ex.dialect.tool_offsets;
  const auto refuse = [&ex](AlarmReason reason) {
    ex.alarm(reason, ex.code_column, std::string(ex.code->name));
    return -1;
  };
  if (ex.data.bit(rules.named_axis_parameter)) {  // type C
    std::uint32_t named = 0;
    for (std::uint32_t mask = ex.block.words & ex.axis_letters; mask != 0; mask &= mask - 1)
      named |= 1u << ex.axis_of[static_cast<unsigned>(std::countr_zero(mask))];
    if (named == 0) return refuse(AlarmReason::length_axis);
    const std::uint32_t others = ex.tool_offset.length_axes & ~named;
    if (std::popcount(named) > 1 || (others != 0 && !ex.data.bit(rules.several_axes_parameter)))
      return refuse(AlarmReason::length_axes);
    return std::countr_zero(named);
  }
  constexpr char kNormal[] = {'Z', 'Y', 'X'};
  const bool normal = ex.data.bit(rules.normal_axis_parameter);
  const auto axis = ex.axis_named(normal ? kNormal[static_cast<std::size_t>(ex.plane)] : 'Z');
  return axis ? static_cast<int>(*axis) : refuse(AlarmReason::length_axis);
}

bool take_h_word(Executor& ex) {
  const std::uint32_t column = ex.block['H'].column;
  std::int64_t number = ex.whole('H', AlarmReason::offset_number);
  if (number < 0 || !tool_life::take_offset(ex, 'H', number, column)) return false;
  if (number > most(ex)) return ex.alarm(AlarmReason::offset_number, column, "H");
  if (const ToolOffset* tool = row(ex, number); tool != nullptr) {
    const auto z = ex.axis_named('Z');
    const double largest = ex.dialect.modes.largest_offset;
    if (z && (std::fabs(tool->geometry[*z]) > largest || std::fabs(tool->wear[*z]) > largest))
      return ex.alarm(AlarmReason::offset_value, column, "H");
  }
  ex.length_offset = number;
  if (too_large(ex, length_value(ex, number))) return ex.alarm(AlarmReason::offset_value, column, "H");
  return true;
}

void show_number(Executor& ex) {
  ex.modal.offset = static_cast<std::int32_t>(ex.length_sign == 0 ? 0 : ex.length_offset);
  ex.tool_offset.seen_version = ex.data.version;
}

}  // namespace

bool one_value(const Executor& ex) {
  return !ex.dialect.tools.lathe && ex.data.bit(ex.dialect.tool_offsets.single_parameter);
}

double length_value(const Executor& ex, std::int64_t number) {
  const ToolOffset* tool = row(ex, number);
  const auto z = ex.axis_named('Z');
  if (tool == nullptr || !z) return 0;
  return tool->geometry[*z] + (one_value(ex) ? 0 : tool->wear[*z]);
}

double radius_value(const Executor& ex, std::int64_t number) {
  const ToolOffset* tool = row(ex, number);
  if (tool == nullptr) return 0;
  return one_value(ex) ? length_value(ex, number) : tool->radius + tool->radius_wear;
}

bool counts_on(const Executor& ex, std::size_t axis) {
  const auto& parameter = ex.dialect.tool_offsets.axis_parameter;
  return parameter.empty() || ex.data.parameter(std::string(parameter) + '/' + ex.axes[axis].name, 1) != 0;
}

std::int64_t most(const Executor& ex) {
  const auto& rules = ex.dialect.tool_offsets;
  return ex.data.bit(rules.few_parameter) ? rules.few
                                          : static_cast<std::int64_t>(ex.dialect.tools.most_offsets);
}

double to_slide(const Executor& ex, std::size_t axis, double page, bool wear) {
  const auto& rules = ex.dialect.tool_offsets;
  const bool radius =
      ex.data.bit(rules.radius_parameter) && !(wear && ex.data.bit(rules.wear_diameter_parameter));
  return radius ? page : ex.page_to_slide(axis, page);
}

double to_page(const Executor& ex, std::size_t axis, double slide_mm, bool wear) {
  return slide_mm / to_slide(ex, axis, 1, wear);
}

bool take(Executor& ex, std::int64_t geometry, std::int64_t wear, std::uint32_t column) {
  const std::int64_t last = most(ex);
  if (geometry > last || wear > last) return ex.alarm(AlarmReason::offset_number, column, "T");
  const ToolOffset* shape = row(ex, geometry);
  const ToolOffset* worn = row(ex, wear);
  const Way way = way_of(ex);
  const double sign = ex.dialect.tools.sign;
  ToolOffsetState& state = ex.tool_offset;
  const bool cuts_arc = is_arc(*ex.motion_code) && ex.action == nullptr &&
                        (ex.block.words & (ex.axis_letters | program::letters("IJKR"))) != 0;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    const bool counts = counts_on(ex, i);
    const double largest = ex.dialect.modes.largest_offset;
    if ((shape != nullptr && std::fabs(shape->geometry[i]) > largest) ||
        (worn != nullptr && std::fabs(worn->wear[i]) > largest) ||
        (counts && too_large(ex, (shape != nullptr ? shape->geometry[i] : 0) + (worn != nullptr ? worn->wear[i] : 0))))
      return ex.alarm(AlarmReason::offset_value, column, std::string(1, ex.axes[i].name));
    const double g = counts && shape != nullptr ? sign * to_slide(ex, i, shape->geometry[i], false) : 0;
    const double w = counts && worn != nullptr ? sign * to_slide(ex, i, worn->wear[i], true) : 0;
    const double by_move = (way.geometry_moves ? g : 0) + (way.wear_moves ? w : 0);
    const double by_shift = g + w - by_move;
    shift(ex, i, by_shift - (ex.axes[i].zero_tool - state.move[i]));
    state.shift_wear[i] = way.wear_moves ? 0 : w;
    const double owed = by_move - state.move[i];
    if (std::fabs(owed) < kNothing_mm) continue;
    // An arc whose start and end do not lie on one circle would be cut.
    if (cuts_arc) return ex.alarm(AlarmReason::t_not_allowed, column, std::string(ex.motion_code->name));
    move(ex, i, owed);
    state.move[i] = by_move;
    if (!ex.data.bit(ex.dialect.tool_offsets.with_next_move_parameter)) ex.pending_axes |= 1u << i;
  }
  state.geometry = geometry;
  state.wear = wear;
  return true;
}

void drop(Executor& ex, std::size_t axis) {
  ex.axes[axis].zero_tool = 0;
  ex.tool_offset.move[axis] = ex.tool_offset.shift_wear[axis] = 0;
  ex.update_zero(axis);
}

void grow(Executor& ex, std::size_t axis, double slide_mm) {
  ex.axes[axis].zero_tool += slide_mm;
  const Way way = way_of(ex);
  (way.wear_moves ? ex.tool_offset.move : ex.tool_offset.shift_wear)[axis] += slide_mm;
  ex.update_zero(axis);
}

bool move_alone(Executor& ex) {
  ex.code = ex.motion_code;
  if (ex.motion_code->tenths == 0 || ex.motion_code->cycle) return ex.rapid();
  return ex.feed();
}

bool take_length(Executor& ex, int sign) {
  if (ex.block.has('H') && !take_h_word(ex)) return false;
  if (sign == 0) {
    ex.length_sign = 0;
    for (std::uint32_t left = ex.tool_offset.length_axes; left != 0; left &= left - 1)
      hold_length(ex, static_cast<std::size_t>(std::countr_zero(left)));
    show_number(ex);
    return true;
  }
  const int axis = length_axis(ex);
  if (axis < 0) return false;
  ex.length_sign = sign;
  hold_length(ex, static_cast<std::size_t>(axis));
  show_number(ex);
  return true;
}

bool take_h(Executor& ex) {
  if (!take_h_word(ex)) return false;
  if (ex.length_sign == 0) return true;  // kept for the next G43, G44 or G37
  for (std::uint32_t left = ex.tool_offset.length_axes; left != 0; left &= left - 1)
    hold_length(ex, static_cast<std::size_t>(std::countr_zero(left)));
  show_number(ex);
  return true;
}

void follow_changes(Executor& ex) {
  if (ex.length_sign == 0 || ex.tool_offset.seen_version == ex.data.version) return;
  if (!ex.data.bit(ex.dialect.tool_offsets.at_once_parameter)) return;
  const std::uint32_t pending = ex.pending_axes;
  for (std::uint32_t left = ex.tool_offset.length_axes; left != 0; left &= left - 1)
    hold_length(ex, static_cast<std::size_t>(std::countr_zero(left)));
  ex.pending_axes = pending;  // made up for with the axis' next move
  ex.tool_offset.seen_version = ex.data.version;
}

// 0i-D digest 7 (K.14): LVC and TGC say which parts go; LVK whether G43 stays. 218T P002.6.
void reset(Executor& ex) {
  const auto& rules = ex.dialect.tool_offsets;
  ToolOffsetState& state = ex.tool_offset;
  if (!ex.dialect.tools.lathe) {
    if (rules.reset_keeps_length_parameter.empty() || ex.data.bit(rules.reset_keeps_length_parameter)) return;
    for (std::uint32_t left = state.length_axes; left != 0; left &= left - 1)
      drop(ex, static_cast<std::size_t>(std::countr_zero(left)));
    state.length_axes = 0;
    ex.length_sign = 0;
    ex.length_offset = 0;
    ex.modal.offset = 0;
    if (const GCode* off = ex.table->find(490); off != nullptr) ex.modal.g[off->group] = off->tenths;
    return;
  }
  const bool all = rules.reset_clears && !ex.data.bit(rules.reset_keeps_parameter);
  const bool wear = all || ex.data.bit(rules.reset_clears_wear_parameter);
  const bool geometry = all || ex.data.bit(rules.reset_clears_shift_parameter);
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    double& tool = ex.axes[i].zero_tool;
    const double geometry_shift = tool - state.move[i] - state.shift_wear[i];
    double left = tool;
    if (wear) left -= state.move[i] + state.shift_wear[i];
    if (geometry) left -= geometry_shift;
    if (wear) state.move[i] = state.shift_wear[i] = 0;
    if (left == tool) continue;
    tool = left;
    ex.update_zero(i);
  }
  if (wear && geometry) {
    state.geometry = state.wear = 0;
    ex.modal.offset = 0;
  }
}

}  // namespace headstock::interp::tool_offset

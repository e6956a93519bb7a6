// The 200T's coordinates: System = Reference + Offset + Comp (L804), each component seen and written by codes
// of its own. In the interpreter's terms, slide mm:
//   Reference = machine + reference_shift          Comp = -zero_tool
//   Offset    = -(zero_shift + zero_local + reference_shift)   (G50 in zero_shift, G58 in zero_local)
// The machine coordinate itself, and with it the software limits, never follows a program: safer than the
// manual, whose limits move with G52 and G59 H01.
#include <bit>
#include <string>
#include <utility>

#include "dialects/lathe-200t/language.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::dialects::lathe_200t {
namespace {

// One axis word: slide mm, and whether it is an increment.
struct Wanted {
  std::size_t axis = 0;
  double slide = 0;
  bool by = false;
};

template <typename Apply>
bool for_words(Executor& ex, const Apply& apply) {
  for (std::uint32_t mask = ex.block.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    Wanted wanted;
    wanted.axis = static_cast<std::size_t>(ex.axis_of[letter]);
    const auto& axis = ex.axes[wanted.axis];
    const std::int64_t value = ex.nano(ex.block.word[letter], axis.increment);
    wanted.slide = static_cast<double>(ex.round_to(value, axis.increment)) / 1e9 * axis.mm_per_unit;
    wanted.by = (ex.incremental_letters >> letter & 1u) != 0;
    if (!apply(wanted)) return false;
  }
  return true;
}

double system_of(const Executor& ex, std::size_t i) {
  return ex.machine_now[i] - ex.modal.work_zero[i];
}

bool write_comp(Executor& ex, std::int64_t number, std::size_t i, double change_slide) {
  auto& tools = ex.data.tools;
  const auto index = static_cast<std::size_t>(number);
  if (tools.size() <= index) tools.resize(index + 1);
  double& cell = tools[index].geometry[i];
  const double before = cell;
  cell += change_slide / ex.axes[i].diameter;
  if (cell != before) {
    ex.report_change("tool/" + std::to_string(number) + "/geometry/" + ex.axes[i].name, before, cell);
  }
  if (number == ex.modal.offset) {
    ex.axes[i].zero_tool = -cell * ex.axes[i].diameter;
    ex.update_zero(i);
  }
  return true;
}

// H of G59 and G60 (L3210).
enum class Component : std::uint8_t { reference = 1, offset = 2, comp = 3, work = 4 };

bool change_component(Executor& ex, Component which, std::size_t i, double change) {
  auto& axis = ex.axes[i];
  switch (which) {
    case Component::reference:
      language(ex).reference_shift[i] += change;
      axis.zero_shift -= change;
      break;
    case Component::offset:
      axis.zero_shift -= change;
      break;
    case Component::comp:
      if (ex.modal.offset == 0) return ex.alarm(AlarmReason::offset_number, ex.block['H'].column, "H03 T00");
      return write_comp(ex, ex.modal.offset, i, change);
    case Component::work:
      axis.zero_local -= change;
      break;
  }
  ex.update_zero(i);
  return true;
}

double component_now(Executor& ex, Component which, std::size_t i) {
  const auto& axis = ex.axes[i];
  const double reference = language(ex).reference_shift[i];
  switch (which) {
    case Component::reference:
      return ex.machine_now[i] + reference;
    case Component::offset:
      return -(axis.zero_shift + axis.zero_local + reference);
    case Component::comp:
      return -axis.zero_tool;
    case Component::work:
      break;
  }
  return -axis.zero_local;
}

template <typename Present>
bool by_component(Executor& ex, const Present& present) {
  if (!ex.block.has('H')) return ex.alarm(AlarmReason::no_data, ex.code_column, "H");
  const std::int64_t h = ex.whole('H', AlarmReason::data_value);
  if (h < 0) return false;
  if (h < 1 || h > 4) return ex.alarm(AlarmReason::data_value, ex.block['H'].column, "H");
  const auto which = static_cast<Component>(h);
  return for_words(ex, [&](const Wanted& word) {
    const double change = word.by ? word.slide : word.slide - present(which, word.axis);
    return change_component(ex, which, word.axis, change);
  });
}

// The components are modes: a RESET takes back what was only read (interpreter/modal_memory.hpp).
struct Components : interp::OwnModes {
  std::vector<double> reference_shift;
  std::vector<Language::StartPoint> start_points;
};

}  // namespace

std::unique_ptr<interp::OwnModes> Language::make_modes() const {
  return std::make_unique<Components>();
}

void Language::keep_modes(interp::OwnModes& into) const {
  auto& kept = static_cast<Components&>(into);
  kept.reference_shift = reference_shift;
  kept.start_points = start_points;
}

void Language::restore_modes(const interp::OwnModes& from) {
  const auto& kept = static_cast<const Components&>(from);
  reference_shift = kept.reference_shift;
  start_points = kept.start_points;
}

// G10: X Z make System read so by changing comp P, U W add to it (L2718). When P is not the active number,
// the difference goes to P all the same and System stays.
bool modify_offset(Executor& ex) {
  if (!ex.block.has('P')) return ex.alarm(AlarmReason::data_input, ex.code_column, "P");
  const std::int64_t number = ex.whole('P', AlarmReason::data_input);
  if (number < 0) return false;
  if (number < 1 || number > static_cast<std::int64_t>(ex.dialect.tools.most_offsets)) {
    return ex.alarm(AlarmReason::data_input, ex.block['P'].column, "P" + std::to_string(number));
  }
  return for_words(ex, [&](const Wanted& word) {
    const double change = word.by ? word.slide : word.slide - system_of(ex, word.axis);
    return write_comp(ex, number, word.axis, change);
  });
}

// G26 both axes, G27 X, G29 Z: rapid to where the last G50 stood, and its coordinates again (L2752, L3021).
bool start_point(Executor& ex) {
  const std::int16_t which = ex.code->tenths;
  machine::AxisVector target = ex.machine_now;
  std::uint32_t moved = 0;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    const char name = ex.axes[i].name;
    if ((which == 270 && name != 'X') || (which == 290 && name != 'Z')) continue;
    if (!ex.axes[i].has_start_point) {
      return ex.alarm(AlarmReason::no_start_point, ex.code_column, std::string(ex.code->name));
    }
    target[i] = ex.axes[i].start_point;
    moved |= 1u << i;
  }
  if (moved == 0) return true;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if ((moved >> i & 1u) == 0) continue;
    const auto& stored = language(ex).start_points[i];
    ex.axes[i].zero_shift = stored.shift;
    ex.axes[i].zero_local = stored.local;
    ex.update_zero(i);
  }
  return ex.emit_rapid_to_machine(target, moved, false);
}

// G28: by the intermediate point, then home; only the axes named, or all (L2767). System becomes the
// reference point's parameter (No. AX3.9, AX3.10) + Comp: Offset is gone (L2810).
bool home(Executor& ex) {
  std::uint32_t moved = 0;
  if (!ex.take_targets(moved)) return false;
  if (moved != 0) {
    auto& motion = ex.emit<interp::Rapid>();
    ex.fill_motion(motion, moved);
    motion.exact_stop = true;
  } else {
    moved = (1u << ex.axes.size()) - 1;
  }
  const bool by_switch = ex.data.bit("AX4.1");  // 1: the zero switch, whose place is the machine's
  auto& shifts = language(ex).reference_shift;
  machine::AxisVector target = ex.machine_now;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if ((moved >> i & 1u) == 0) continue;
    const double place = ex.machine.axes[i].reference_mm;
    const char name = ex.axes[i].name;
    const double page = ex.data.parameter(name == 'X'   ? "AX3.9"
                                          : name == 'Z' ? "AX3.10"
                                                        : "",
                                          place / ex.axes[i].diameter);
    const double reference = ex.page_to_slide(i, page);
    target[i] = by_switch ? place : reference - shifts[i];
    if (by_switch) shifts[i] = reference - place;
    ex.axes[i].zero_shift = -shifts[i];
    ex.axes[i].zero_local = 0;
    ex.update_zero(i);
  }
  return ex.emit_rapid_to_machine(target, moved, true);
}

// G50: System gets these values, and here is the start point from now on (L3006).
bool set_start(Executor& ex) {
  if ((ex.block.words & ex.axis_letters) == 0) return true;  // G50 S
  if (!interp::handlers::set_coordinates(ex)) return false;
  auto& stored = language(ex).start_points;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    ex.axes[i].start_point = ex.machine_now[i];
    ex.axes[i].has_start_point = true;
    stored[i] = {ex.axes[i].zero_shift, ex.axes[i].zero_local};
  }
  return true;
}

// G52: Reference gets these values, Offset and Comp stay (L3053; its heading says "clear", its example sets).
bool clear_reference(Executor& ex) {
  return for_words(ex, [&](const Wanted& word) {
    const double now = component_now(ex, Component::reference, word.axis);
    return change_component(ex, Component::reference, word.axis, word.by ? word.slide : word.slide - now);
  });
}

bool cancel_shift(Executor& ex) {
  for (auto& axis : ex.axes) axis.zero_local = 0;
  ex.update_zeros();
  return true;
}

// G58: as G50, but G53 takes it back; the start point stays (L3063).
bool shift(Executor& ex) {
  return for_words(ex, [&](const Wanted& word) {
    const double change = word.by ? word.slide : word.slide - system_of(ex, word.axis);
    return change_component(ex, Component::work, word.axis, change);
  });
}

bool system_component(Executor& ex) {
  return by_component(ex, [&](Component, std::size_t axis) { return system_of(ex, axis); });
}

bool modify_component(Executor& ex) {
  return by_component(ex, [&](Component which, std::size_t axis) { return component_now(ex, which, axis); });
}

}  // namespace headstock::dialects::lathe_200t

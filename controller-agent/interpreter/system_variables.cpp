#include "interpreter/system_variables.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "interpreter/executor.hpp"

namespace headstock::interp {

using macro::Result;
using Row = SystemVariable;

namespace {

bool applies(const Executor& ex, std::string_view when) {
  while (!when.empty()) {
    const std::string_view one = when.substr(0, when.find(' '));
    const bool wanted = one.front() != '!';
    if (ex.data.bit(wanted ? one : one.substr(1)) != wanted) return false;
    when.remove_prefix(std::min(when.size(), one.size() + 1));
  }
  return true;
}

const Row* find_row(const Executor& ex, std::uint32_t number) {
  for (const Row& row : ex.dialect.system_variables) {
    if (number >= row.first && number <= row.last && applies(ex, row.when)) return &row;
  }
  return nullptr;
}

}  // namespace

Result SystemAccess::read_system(std::uint32_t number, double& value) {
  const Row* row = find_row(executor_, number);
  if (row == nullptr) return Result::failed(AlarmReason::macro_variable);
  if (row->read == nullptr) return Result::failed(AlarmReason::macro_write_only);
  return row->read(executor_, *row, number - row->first, value);
}

Result SystemAccess::write_system(std::uint32_t number, double value) {
  const Row* row = find_row(executor_, number);
  if (row == nullptr) return Result::failed(AlarmReason::macro_variable);
  if (row->write == nullptr) return Result::failed(AlarmReason::macro_protected);
  return row->write(executor_, *row, number - row->first, value);
}

MacroState::MacroState(Executor& executor, const macro::Rules& macro_rules, bool lathe)
    : rules(macro_rules),
      environment(&offline),
      system(executor),
      variables(macro_rules, common, system),
      words(macro_rules, lathe) {}

ModalValues Executor::modal_values() const {
  ModalValues values = macros->history[macros->newest];
  values.modal = modal;
  return values;
}

void Executor::remember_modal_values() {
  ModalValues& values = macros->history[macros->newest ^ 1u];
  const ModalValues& before = macros->history[macros->newest];
  values.b = block.has('B') ? block['B'].value() : before.b;
  values.d = block.has('D') ? block['D'].value() : before.d;
  values.e = block.has('E') ? block['E'].value() : before.e;
  values.h = block.has('H') ? block['H'].value() : before.h;
  values.m = block.m_count != 0 ? block.m[block.m_count - 1u].tenths / 10 : before.m;
  values.sequence = at.sequence;
  values.program = at.program;
  values.extra_work = work_is_extra ? static_cast<std::uint32_t>(work_index + 1) : 0;
  values.modal = modal;
  macros->newest ^= 1u;
}

bool Executor::macro_alarm(double number) {
  const macro::Rules& rules = macros->rules;
  const bool plain = data.bit(rules.alarm_plain_parameter);
  const double whole = std::floor(number + 0.5);
  if (!(whole >= 0 && whole <= (plain ? rules.alarm_plain_most : rules.alarm_most)))
    return alarm(AlarmReason::macro_argument, at.column);
  char digits[24];
  std::snprintf(digits, sizeof digits, "%0*d", rules.alarm_digits,
                static_cast<int>(whole) + (plain ? 0 : rules.alarm_base));
  auto& raised = emit<Alarm>();
  raised.at = at;
  raised.code = std::string(rules.alarm_prefix) + digits;
  raised.detail = macros->comment.substr(0, rules.most_message);
  finished = true;
  return false;
}

namespace system_variables {
namespace {

bool must_stand_still(const Executor& ex) {
  return !ex.at_standstill && ex.macros->environment->takes_time();
}

// What waiting loops look at counts as a change: with a running machine it may come any time.
void looked_at_machine(Executor& ex) {
  if (!ex.macros->environment->takes_time()) return;
  ++ex.macros->variables.writes;
  ex.jumps = 0;
}

double unit_of(const Executor& ex, std::size_t axis) {
  return ex.axes[axis].rotary ? 1 : ex.unit_mm;
}

Result checked_axis(const Executor& ex, std::size_t axis) {
  return axis < ex.axes.size() ? Result{} : Result::failed(AlarmReason::macro_variable);
}

std::string axis_text(const Executor& ex, std::size_t axis) {
  return std::string(1, ex.axes[axis].name);
}

void store(Executor& ex, double& cell, double value, const std::string& what) {
  const double before = cell;
  cell = value;
  if (before != value) ex.report_change(what, before, value);
}

double signed_word(const Executor& ex, unsigned first, bool outputs) {
  std::uint32_t word = 0;
  for (unsigned bit = 0; bit < 32; ++bit) {
    const bool on =
        outputs ? ex.macros->environment->output(first + bit) : ex.macros->environment->input(first + bit);
    word |= on ? 1u << bit : 0u;
  }
  return static_cast<double>(static_cast<std::int32_t>(word));
}

}  // namespace

Result read_null(Executor&, const Row&, std::uint32_t, double& value) {
  value = macro::kNull;
  return {};
}

Result read_constant(Executor&, const Row& row, std::uint32_t index, double& value) {
  value = row.detail + static_cast<int>(index) == 0 ? std::numbers::pi : std::numbers::e;
  return {};
}

Result read_input(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  if (!ex.macros->environment->has_signals()) return Result::failed(AlarmReason::macro_variable);
  if (must_stand_still(ex)) return Result::later();
  looked_at_machine(ex);
  value = ex.macros->environment->input(static_cast<unsigned>(row.detail) + index) ? 1 : 0;
  return {};
}

Result read_input_word(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  if (!ex.macros->environment->has_signals()) return Result::failed(AlarmReason::macro_variable);
  if (must_stand_still(ex)) return Result::later();
  looked_at_machine(ex);
  value = signed_word(ex, static_cast<unsigned>(row.detail) + 32 * index, false);
  return {};
}

Result read_output(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  if (!ex.macros->environment->has_signals()) return Result::failed(AlarmReason::macro_variable);
  if (must_stand_still(ex)) return Result::later();
  value = ex.macros->environment->output(static_cast<unsigned>(row.detail) + index) ? 1 : 0;
  return {};
}

// Not before everything that stands before it has been carried out: an output must not run ahead of a move.
Result write_output(Executor& ex, const Row& row, std::uint32_t index, double value) {
  if (!ex.macros->environment->has_signals()) return Result::failed(AlarmReason::macro_variable);
  if (must_stand_still(ex)) return Result::later();
  ex.macros->environment->set_output(static_cast<unsigned>(row.detail) + index, std::fabs(value) >= 1e-8);
  return {};
}

Result read_output_word(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  if (!ex.macros->environment->has_signals()) return Result::failed(AlarmReason::macro_variable);
  if (must_stand_still(ex)) return Result::later();
  value = signed_word(ex, static_cast<unsigned>(row.detail) + 32 * index, true);
  return {};
}

Result write_output_word(Executor& ex, const Row& row, std::uint32_t index, double value) {
  if (!ex.macros->environment->has_signals()) return Result::failed(AlarmReason::macro_variable);
  if (must_stand_still(ex)) return Result::later();
  const double whole = std::floor(value + 0.5);
  if (!(std::fabs(whole) < 4294967296.0)) return Result::failed(AlarmReason::macro_integer);
  const auto word = static_cast<std::uint32_t>(static_cast<std::int64_t>(whole));
  for (unsigned bit = 0; bit < 32; ++bit) {
    ex.macros->environment->set_output(static_cast<unsigned>(row.detail) + 32 * index + bit,
                                       (word >> bit & 1u) != 0);
  }
  return {};
}

// ---- tool offsets

Result read_tool(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  const auto cell = static_cast<ToolCell>(row.detail >> 8);
  const char letter = static_cast<char>(row.detail & 0xff);
  const auto axis = ex.axis_named(letter);
  value = 0;
  const std::size_t number = index + 1;
  if (number > ex.dialect.tools.most_offsets) return Result::failed(AlarmReason::macro_variable);
  if (number >= ex.data.tools.size()) return {};
  const ToolOffset& tool = ex.data.tools[number];
  switch (cell) {
    case ToolCell::geometry:
    case ToolCell::single:
      value = axis ? tool.geometry[*axis] : 0;
      if (cell == ToolCell::single && axis) value += tool.wear[*axis];
      break;
    case ToolCell::wear:
      value = axis ? tool.wear[*axis] : 0;
      break;
    case ToolCell::radius:
      value = tool.radius;
      break;
    case ToolCell::radius_wear:
      value = tool.radius_wear;
      break;
    case ToolCell::tip:
      value = tool.tip;
      return {};
  }
  value /= ex.unit_mm;
  return {};
}

Result write_tool(Executor& ex, const Row& row, std::uint32_t index, double value) {
  const auto cell = static_cast<ToolCell>(row.detail >> 8);
  const char letter = static_cast<char>(row.detail & 0xff);
  const auto axis = ex.axis_named(letter);
  const std::size_t number = index + 1;
  if (number > ex.dialect.tools.most_offsets) return Result::failed(AlarmReason::macro_variable);
  if (!(std::fabs(value) < 1e6)) return Result::failed(AlarmReason::value_range);
  const bool of_axis = cell == ToolCell::geometry || cell == ToolCell::wear || cell == ToolCell::single;
  if (of_axis && !axis) return Result::failed(AlarmReason::macro_variable);
  if (ex.data.tools.size() <= number) ex.data.tools.resize(number + 1);
  ToolOffset& tool = ex.data.tools[number];
  const std::string place = "tool/" + std::to_string(number) + "/";
  const double mm = value * ex.unit_mm;
  switch (cell) {
    case ToolCell::geometry:
      store(ex, tool.geometry[*axis], mm, place + "geometry/" + letter);
      break;
    case ToolCell::wear:
      store(ex, tool.wear[*axis], mm, place + "wear/" + letter);
      break;
    case ToolCell::single:  // one number for everything: length, radius and no wear
      store(ex, tool.geometry[*axis], mm, place + "geometry/" + letter);
      store(ex, tool.wear[*axis], 0, place + "wear/" + letter);
      if (!ex.dialect.tools.lathe) store(ex, tool.radius, mm, place + "radius");
      break;
    case ToolCell::radius:
      store(ex, tool.radius, mm, place + "radius");
      break;
    case ToolCell::radius_wear:
      store(ex, tool.radius_wear, mm, place + "radius_wear");
      break;
    case ToolCell::tip: {
      const double whole = std::floor(value + 0.5);
      if (!(whole >= 0 && whole <= 9)) return Result::failed(AlarmReason::value_range);
      const int before = std::exchange(tool.tip, static_cast<int>(whole));
      if (before != tool.tip) ex.report_change(place + "tip", before, tool.tip);
      break;
    }
  }
  return {};
}

Result read_tool_in_force(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  const char letter = static_cast<char>(row.detail & 0xff);
  const auto named = letter == 0 ? std::optional<std::size_t>(index) : ex.axis_named(letter);
  if (!named || *named >= ex.axes.size()) return Result::failed(AlarmReason::macro_variable);
  const std::size_t axis = *named;
  if (!ex.dialect.tools.lathe) {
    value = ex.axes[axis].zero_tool / ex.axes[axis].mm_per_unit;
    return {};
  }
  const auto wear = static_cast<std::size_t>(std::max(ex.modal.offset, 0));
  const bool by_tool = ex.data.bit(ex.dialect.tools.geometry_by_tool_parameter) && wear != 0;
  const auto shape = by_tool ? static_cast<std::size_t>(std::max(ex.modal.tool, 0)) : wear;
  const auto& tools = ex.data.tools;
  const double worn = wear < tools.size() ? tools[wear].wear[axis] : 0;
  const double formed = shape < tools.size() ? tools[shape].geometry[axis] : 0;
  const bool both = (row.detail & 512) != 0;
  value = ((row.detail & 256) != 0 ? formed : both ? worn + formed : worn) / unit_of(ex, axis);
  return {};
}

// ---- work offsets

namespace {

double* work_cell(Executor& ex, std::int32_t detail, std::uint32_t index, std::size_t& axis,
                  std::string& name) {
  std::size_t system = 0;
  if (detail > 0) {
    axis = static_cast<std::size_t>(detail - 1);
    system = index;
  } else {
    axis = index;
    system = static_cast<std::size_t>(-detail);
  }
  if (axis >= ex.axes.size() || system > 6) return nullptr;
  name = system == 0 ? "work/EXT/" : "work/G" + std::to_string(53 + system) + "/";
  name += ex.axes[axis].name;
  return system == 0 ? &ex.data.work_external[axis] : &ex.data.work[system - 1][axis];
}

double* extra_cell(Executor& ex, std::uint32_t index, std::size_t& axis, std::string& name) {
  const std::size_t p = index / 20;
  axis = index % 20;
  if (p >= 48 || axis >= ex.axes.size()) return nullptr;
  name = "work/G54.1P" + std::to_string(p + 1) + "/" + ex.axes[axis].name;
  return &ex.data.work_extra[p][axis];
}

Result store_work(Executor& ex, double* cell, std::size_t axis, const std::string& name, double value) {
  if (cell == nullptr) return Result::failed(AlarmReason::macro_variable);
  if (!(std::fabs(value) < 1e6)) return Result::failed(AlarmReason::value_range);
  store(ex, *cell, value * unit_of(ex, axis), name);
  ex.update_zeros();
  return {};
}

}  // namespace

Result read_work(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  std::size_t axis = 0;
  std::string name;
  const double* cell = work_cell(ex, row.detail, index, axis, name);
  if (cell == nullptr) return Result::failed(AlarmReason::macro_variable);
  value = *cell / unit_of(ex, axis);
  return {};
}

Result write_work(Executor& ex, const Row& row, std::uint32_t index, double value) {
  std::size_t axis = 0;
  std::string name;
  double* cell = work_cell(ex, row.detail, index, axis, name);
  return store_work(ex, cell, axis, name, value);
}

Result read_extra_work(Executor& ex, const Row&, std::uint32_t index, double& value) {
  std::size_t axis = 0;
  std::string name;
  const double* cell = extra_cell(ex, index, axis, name);
  if (cell == nullptr) return Result::failed(AlarmReason::macro_variable);
  value = *cell / unit_of(ex, axis);
  return {};
}

Result write_extra_work(Executor& ex, const Row&, std::uint32_t index, double value) {
  std::size_t axis = 0;
  std::string name;
  double* cell = extra_cell(ex, index, axis, name);
  return store_work(ex, cell, axis, name, value);
}

Result read_work_shift(Executor& ex, const Row& row, std::uint32_t, double& value) {
  const auto axis = ex.axis_named(static_cast<char>(row.detail));
  if (!axis) return Result::failed(AlarmReason::macro_variable);
  value = ex.data.work_shift[*axis] / unit_of(ex, *axis);
  return {};
}

Result write_work_shift(Executor& ex, const Row& row, std::uint32_t, double value) {
  const auto axis = ex.axis_named(static_cast<char>(row.detail));
  if (!axis) return Result::failed(AlarmReason::macro_variable);
  return store_work(ex, &ex.data.work_shift[*axis], *axis, "work/shift/" + axis_text(ex, *axis), value);
}

// ---- control

Result raise_alarm(Executor& ex, const Row&, std::uint32_t, double value) {
  ex.macro_alarm(value);
  return Result::failed(AlarmReason::macro_argument);  // the alarm is out already
}

Result stop_with_message(Executor& ex, const Row&, std::uint32_t, double) {
  auto& message = ex.emit<Message>();
  message.at = ex.at;
  message.text = ex.macros->comment.substr(0, ex.macros->rules.most_message);
  auto& stop = ex.emit<Stop>();
  stop.at = ex.at;
  stop.modal = ex.modal;
  ex.hold_look_ahead();
  return {};
}

Result read_clock(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  if (must_stand_still(ex)) return Result::later();
  looked_at_machine(ex);
  ++ex.macros->variables.writes;  // it goes on: a loop that waits for it ends
  value = row.detail + static_cast<int>(index) == 0 ? ex.macros->environment->clock_ms()
                                                    : ex.macros->environment->clock_hours();
  return {};
}

Result write_clock(Executor& ex, const Row& row, std::uint32_t index, double value) {
  if (must_stand_still(ex)) return Result::later();
  if (row.detail + static_cast<int>(index) == 0) {
    ex.macros->environment->set_clock_ms(value);
  } else {
    ex.macros->environment->set_clock_hours(value);
  }
  return {};
}

Result read_control(Executor& ex, const Row& row, std::uint32_t, double& value) {
  value = row.detail == 0 ? ex.macros->control & 0xfu : ex.macros->control >> 4;
  return {};
}

Result write_control(Executor& ex, const Row& row, std::uint32_t, double value) {
  const double whole = std::floor(value + 0.5);
  if (!(whole >= 0 && whole <= (row.detail == 0 ? 3 : 7))) return Result::failed(AlarmReason::value_range);
  const auto bits = static_cast<std::uint32_t>(whole);
  std::uint32_t& control = ex.macros->control;
  control = row.detail == 0 ? (control & ~0xfu) | bits : (control & 0xfu) | bits << 4;
  ex.modal.macro_control = control;
  return {};
}

Result read_settings(Executor& ex, const Row&, std::uint32_t, double& value) {
  constexpr std::uint32_t kInch = 1u << 2;
  const std::uint32_t others = ex.macros->environment->settings() & ~kInch;
  value = others | (ex.modal.inch ? kInch : 0u);
  return {};
}

Result write_settings(Executor& ex, const Row&, std::uint32_t, double value) {
  const double whole = std::floor(value + 0.5);
  if (!(whole >= 0 && whole < 65'536)) return Result::failed(AlarmReason::value_range);
  const auto bits = static_cast<std::uint32_t>(whole);
  if (((bits >> 2 & 1u) != 0) != ex.modal.inch)
    return Result::failed(AlarmReason::macro_protected);  // G20/G21
  ex.macros->environment->set_settings(bits);
  return {};
}

Result read_mirror(Executor& ex, const Row&, std::uint32_t, double& value) {
  if (must_stand_still(ex)) return Result::later();
  value = ex.macros->environment->mirror_image();
  return {};
}

Result read_restarting(Executor& ex, const Row&, std::uint32_t, double& value) {
  value = ex.restarting || ex.macros->environment->restarting() ? 1 : 0;
  return {};
}

Result read_date(Executor& ex, const Row&, std::uint32_t index, double& value) {
  value = index == 0 ? ex.macros->environment->date() : ex.macros->environment->time();
  return {};
}

Result read_parts(Executor& ex, const Row&, std::uint32_t index, double& value) {
  if (must_stand_still(ex)) return Result::later();
  value = index == 0 ? ex.macros->environment->parts_made() : ex.macros->environment->parts_required();
  return {};
}

Result write_parts(Executor& ex, const Row&, std::uint32_t index, double value) {
  if (must_stand_still(ex)) return Result::later();
  if (!(value >= 0 && value <= 999'999'999)) return Result::failed(AlarmReason::value_range);
  if (index == 0) {
    ex.macros->environment->set_parts_made(std::floor(value + 0.5));
  } else {
    ex.macros->environment->set_parts_required(std::floor(value + 0.5));
  }
  return {};
}

Result read_offset_memory(Executor& ex, const Row&, std::uint32_t, double& value) {
  value = ex.data.bit("8136#6") ? 0 : 2;
  return {};
}

Result read_main_program(Executor& ex, const Row&, std::uint32_t, double& value) {
  value = ex.frames.empty() ? 0 : ex.frames.front().number;
  return {};
}

Result read_kept(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  value = ex.data.parameter("#" + std::to_string(row.first + index));
  return {};
}

Result write_kept(Executor& ex, const Row& row, std::uint32_t index, double value) {
  const std::string name = std::to_string(row.first + index);
  double& cell = ex.data.parameters["#" + name];
  store(ex, cell, value, "variable/" + name);
  return {};
}

// ---- modal values

namespace {

// The block before the macro statement has been read and buffered: its state is the interpreter's own. The
// one before that is being executed (0i-D E12): with a look-ahead of thousands of blocks the program shall
// see what it sees on the control.
const ModalSnapshot& snapshot(const Executor& ex, Which which) {
  if (which == Which::interrupted) return ex.macros->interrupted.modal;
  if (which == Which::preceding) return ex.modal;
  return ex.macros->history[ex.macros->newest ^ 1u].modal;
}

const ModalValues& values_of(const Executor& ex, Which which) {
  if (which == Which::interrupted) return ex.macros->interrupted;
  return ex.macros->history[which == Which::preceding ? ex.macros->newest : ex.macros->newest ^ 1u];
}

}  // namespace

Result read_group(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  const ModalSnapshot& modal = snapshot(ex, static_cast<Which>(row.detail >> 8));
  const std::size_t group = index + static_cast<std::size_t>(row.detail & 0xff);
  const int tenths = group < kModalGroups ? modal.g[group] : -1;
  value = tenths < 0 ? 0 : tenths / 10.0;
  return {};
}

Result read_modal(Executor& ex, const Row& row, std::uint32_t, double& value) {
  const auto which = static_cast<Which>(row.detail >> 8);
  const ModalValues& values = values_of(ex, which);
  const ModalSnapshot& modal = snapshot(ex, which);
  switch (row.detail & 0xff) {
    case 'B':
      value = values.b;
      break;
    case 'D':
      value = values.d;
      break;
    case 'E':
      value = values.e;
      break;
    case 'F':
      value = modal.feed;
      break;
    case 'H':
      value = values.h;
      break;
    case 'M':
      value = values.m;
      break;
    case 'N':
      value = which == Which::preceding ? ex.at.sequence : values.sequence;
      break;
    case 'O':
      value = which == Which::preceding ? ex.at.program : values.program;
      break;
    case 'P':
      value = which == Which::preceding ? (ex.work_is_extra ? static_cast<double>(ex.work_index + 1) : 0)
                                        : values.extra_work;
      break;
    case 'S':
      value = modal.spindle_speed;
      break;
    case 'T':
      value = modal.tool;
      if (ex.dialect.tools.lathe) {
        int digits = static_cast<int>(
            ex.data.parameter(ex.dialect.tools.offset_digits_parameter, ex.dialect.tools.offset_digits));
        if (digits < 1 || digits > 3) digits = ex.dialect.tools.offset_digits;
        value = modal.tool * static_cast<double>(program::kPowerOfTen[static_cast<std::size_t>(digits)]) +
                modal.offset;
      }
      break;
    default:
      value = 0;
  }
  return {};
}

// ---- positions

Result read_block_end(Executor& ex, const Row&, std::uint32_t index, double& value) {
  if (const Result axis = checked_axis(ex, index); !axis.ok()) return axis;
  value = ex.work_now[index];
  return {};
}

namespace {

AxisVector machine_position(Executor& ex) {
  return ex.macros->environment->machine_position().value_or(ex.machine_now);
}

// Workpiece coordinates with the tool offset in them: where the tool's mounting point is, not its tip.
double with_offset(const Executor& ex, std::size_t axis, double machine) {
  const double zero = ex.modal.work_zero[axis] - ex.axes[axis].zero_tool;
  return (machine - zero) / ex.axes[axis].mm_per_unit;
}

}  // namespace

Result read_machine_position(Executor& ex, const Row&, std::uint32_t index, double& value) {
  if (const Result axis = checked_axis(ex, index); !axis.ok()) return axis;
  if (must_stand_still(ex)) return Result::later();
  value = machine_position(ex)[index] / ex.axes[index].mm_per_unit;
  return {};
}

Result read_work_position(Executor& ex, const Row&, std::uint32_t index, double& value) {
  if (const Result axis = checked_axis(ex, index); !axis.ok()) return axis;
  if (must_stand_still(ex)) return Result::later();
  value = with_offset(ex, index, machine_position(ex)[index]);
  return {};
}

Result read_skip_position(Executor& ex, const Row&, std::uint32_t index, double& value) {
  if (const Result axis = checked_axis(ex, index); !axis.ok()) return axis;
  if (must_stand_still(ex)) return Result::later();
  const AxisVector position = ex.macros->environment->skip_position().value_or(ex.skip.machine);
  value = with_offset(ex, index, position[index]);
  return {};
}

Result read_deviation(Executor& ex, const Row&, std::uint32_t index, double& value) {
  if (const Result axis = checked_axis(ex, index); !axis.ok()) return axis;
  if (must_stand_still(ex)) return Result::later();
  value = ex.macros->environment->servo_deviation(index) / ex.axes[index].mm_per_unit;
  return {};
}

Result read_handle_interruption(Executor& ex, const Row&, std::uint32_t index, double& value) {
  if (const Result axis = checked_axis(ex, index); !axis.ok()) return axis;
  if (must_stand_still(ex)) return Result::later();
  value = ex.macros->environment->handle_interruption(index) / ex.axes[index].mm_per_unit;
  return {};
}

Result read_distance_to_go(Executor& ex, const Row&, std::uint32_t index, double& value) {
  if (const Result axis = checked_axis(ex, index); !axis.ok()) return axis;
  if (must_stand_still(ex)) return Result::later();
  value = ex.macros->environment->distance_to_go(index) / ex.axes[index].mm_per_unit;
  return {};
}

}  // namespace system_variables
}  // namespace headstock::interp

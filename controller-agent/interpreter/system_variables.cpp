#include "interpreter/system_variables.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "interpreter/executor.hpp"
#include "interpreter/system_variable_access.hpp"

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
      environment(executor.environment),
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

bool MacroState::keeps_locals(const MachineData& machine_data) const {
  return !rules.clear_locals_parameter.empty() && !machine_data.bit(rules.clear_locals_parameter);
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

Result read_null(Executor&, const Row&, std::uint32_t, double& value) {
  value = macro::kNull;
  return {};
}

Result read_constant(Executor&, const Row& row, std::uint32_t index, double& value) {
  value = row.detail + static_cast<int>(index) == 0 ? std::numbers::pi : std::numbers::e;
  return {};
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


}  // namespace system_variables
}  // namespace headstock::interp

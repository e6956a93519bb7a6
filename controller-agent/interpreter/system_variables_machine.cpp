// System variables that the running machine answers: signals, clocks, switches, counters, positions.
#include <cmath>

#include "interpreter/system_variable_access.hpp"

namespace headstock::interp::system_variables {
namespace {

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
  value = ex.macros->environment->mirror_image() | ex.mirror_setting.axes;
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

}  // namespace headstock::interp::system_variables

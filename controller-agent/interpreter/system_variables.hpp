// System variables: what each number from 1000 up reads and writes. A dialect lists its rows; the functions are
// shared. Values in programming units, diameters where the axis is diameter-programmed, as the pages show them.
#pragma once

#include <cstdint>
#include <string_view>

#include "macro/value.hpp"

namespace headstock::interp {

struct Executor;

/// One number, or a range of alike ones.
struct SystemVariable {
  using Read = macro::Result (*)(Executor&, const SystemVariable&, std::uint32_t index, double& value);
  using Write = macro::Result (*)(Executor&, const SystemVariable&, std::uint32_t index, double value);

  std::uint32_t first = 0, last = 0;
  Read read = nullptr;          ///< nullptr: may not be read (PS1115)
  Write write = nullptr;        ///< nullptr: may not be written (PS0116)
  std::int32_t detail = 0;      ///< for the functions
  std::string_view when = {};   ///< bit that must be 1, or 0 with `!` before it; several parted by a blank
};

namespace system_variables {

// `index` is the number minus `first`; see the functions for `detail`.
macro::Result read_null(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result read_constant(Executor&, const SystemVariable&, std::uint32_t, double&);  ///< 0: pi, 1: e
macro::Result read_input(Executor&, const SystemVariable&, std::uint32_t, double&);     ///< bit detail + index
macro::Result read_input_word(Executor&, const SystemVariable&, std::uint32_t, double&);  ///< bits of a word: detail
macro::Result read_output(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result write_output(Executor&, const SystemVariable&, std::uint32_t, double);
macro::Result read_output_word(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result write_output_word(Executor&, const SystemVariable&, std::uint32_t, double);

/// Cells of the tool offset page; `detail` = tool_cell(…), index 0 is offset 1.
enum class ToolCell : std::uint8_t { geometry, wear, radius, radius_wear, tip, single };
constexpr std::int32_t tool_cell(ToolCell cell, char axis = 'Z') {
  return static_cast<std::int32_t>(cell) << 8 | axis;
}
macro::Result read_tool(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result write_tool(Executor&, const SystemVariable&, std::uint32_t, double);
/// Offset in force: detail = axis letter (0: the axis of the index) | 256 for geometry | 512 for both.
macro::Result read_tool_in_force(Executor&, const SystemVariable&, std::uint32_t, double&);

/// Work offsets. detail > 0: axis number, index 0 EXT, 1 G54 …; detail ≤ 0: system −detail (0 EXT), index axis.
macro::Result read_work(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result write_work(Executor&, const SystemVariable&, std::uint32_t, double);
/// G54.1: index = (P − 1) × 20 + axis; detail 1: 20 numbers a system.
macro::Result read_extra_work(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result write_extra_work(Executor&, const SystemVariable&, std::uint32_t, double);
macro::Result read_work_shift(Executor&, const SystemVariable&, std::uint32_t, double&);  ///< detail: axis letter
macro::Result write_work_shift(Executor&, const SystemVariable&, std::uint32_t, double);

macro::Result raise_alarm(Executor&, const SystemVariable&, std::uint32_t, double);    ///< #3000
macro::Result stop_with_message(Executor&, const SystemVariable&, std::uint32_t, double);  ///< #3006
macro::Result read_clock(Executor&, const SystemVariable&, std::uint32_t, double&);  ///< index 0 ms, 1 hours
macro::Result write_clock(Executor&, const SystemVariable&, std::uint32_t, double);
macro::Result read_control(Executor&, const SystemVariable&, std::uint32_t, double&);  ///< #3003, #3004
macro::Result write_control(Executor&, const SystemVariable&, std::uint32_t, double);
macro::Result read_settings(Executor&, const SystemVariable&, std::uint32_t, double&);  ///< #3005
macro::Result write_settings(Executor&, const SystemVariable&, std::uint32_t, double);
macro::Result read_mirror(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result read_restarting(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result read_date(Executor&, const SystemVariable&, std::uint32_t, double&);  ///< index 0 date, 1 time
macro::Result read_parts(Executor&, const SystemVariable&, std::uint32_t, double&);  ///< index 0 made, 1 required
macro::Result write_parts(Executor&, const SystemVariable&, std::uint32_t, double);
macro::Result read_offset_memory(Executor&, const SystemVariable&, std::uint32_t, double&);  ///< #3980
macro::Result read_main_program(Executor&, const SystemVariable&, std::uint32_t, double&);
/// A number kept with the machine's data: #5900.
macro::Result read_kept(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result write_kept(Executor&, const SystemVariable&, std::uint32_t, double);

/// Modal values. `detail` = which block × 256 + what: a group for G (index added), or a letter.
enum class Which : std::uint8_t { preceding, executing, interrupted };
constexpr std::int32_t modal_value(Which which, char letter) {
  return static_cast<std::int32_t>(which) << 8 | letter;
}
macro::Result read_modal(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result read_group(Executor&, const SystemVariable&, std::uint32_t, double&);  ///< group 1 + index

/// Positions, index = axis.
macro::Result read_block_end(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result read_machine_position(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result read_work_position(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result read_skip_position(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result read_deviation(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result read_handle_interruption(Executor&, const SystemVariable&, std::uint32_t, double&);
macro::Result read_distance_to_go(Executor&, const SystemVariable&, std::uint32_t, double&);

}  // namespace system_variables

}  // namespace headstock::interp

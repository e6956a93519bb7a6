// The variables of GSK 2000TB/TC and its calls (manual L5014-5623). Its headline claims statement macros
// (L172, L306) without describing them: they are carried out as on the FANUC controls it follows.
#include "macro/rules.hpp"

#include "dialects/build.hpp"
#include "interpreter/system_variables.hpp"
#include "program/block.hpp"

namespace headstock::dialects {
namespace {

using namespace interp::system_variables;
using interp::SystemVariable;

constexpr SystemVariable kVariables[] = {
    {1000, 1015, read_input, nullptr, 0},
    {1032, 1032, read_input_word, nullptr, 0},
    {1100, 1115, read_output, write_output, 0},
    {1132, 1133, read_output_word, write_output_word, 0},
    {1500, 1531, read_tool, write_tool, tool_cell(ToolCell::geometry, 'X')},
    {1600, 1631, read_tool, write_tool, tool_cell(ToolCell::geometry, 'Z')},
    {1700, 1731, read_tool, write_tool, tool_cell(ToolCell::geometry, 'Y')},
    {1800, 1831, read_tool, write_tool, tool_cell(ToolCell::radius)},
    {1900, 1931, read_tool, write_tool, tool_cell(ToolCell::wear, 'X')},
    {2000, 2031, read_tool, write_tool, tool_cell(ToolCell::wear, 'Z')},
    {2100, 2131, read_tool, write_tool, tool_cell(ToolCell::wear, 'Y')},
    {2200, 2231, read_tool, write_tool, tool_cell(ToolCell::radius_wear)},
    {3000, 3000, nullptr, raise_alarm},
    {4001, 4003, read_group, nullptr, 1},
    {4005, 4007, read_group, nullptr, 5},
    {4016, 4016, read_group, nullptr, 16},
    {4120, 4120, read_modal, nullptr, modal_value(Which::preceding, 'F')},
    {4121, 4121, read_modal, nullptr, modal_value(Which::preceding, 'M')},
    {4122, 4122, read_modal, nullptr, modal_value(Which::preceding, 'N')},
    {4123, 4123, read_modal, nullptr, modal_value(Which::preceding, 'O')},
    {4124, 4124, read_modal, nullptr, modal_value(Which::preceding, 'S')},
    {4125, 4125, read_modal, nullptr, modal_value(Which::preceding, 'T')},
    {5001, 5005, read_block_end},
    {5006, 5010, read_machine_position},
    {5011, 5015, read_work_position},
    {5201, 5205, read_work, write_work, 0},
    {5206, 5210, read_work, write_work, -1},
    {5211, 5215, read_work, write_work, -2},
    {5216, 5220, read_work, write_work, -3},
    {5221, 5225, read_work, write_work, -4},
    {5226, 5230, read_work, write_work, -5},
    {5231, 5235, read_work, write_work, -6},
};

macro::Rules make_rules() {
  macro::Rules r;
  r.statements = true;
  r.locals = 50;
  r.common = {{{100, 199, false}, {500, 999, true}}};
  r.clear_volatile_parameter = "S173.0";
  r.clear_locals_parameter = "S173.1";
  r.single_block_parameter = "S207.6";
  r.signed_angles_parameter = "S180.7";
  r.alarm_prefix = "";
  r.alarm_digits = 1;
  r.macro_nesting = 4;
  r.all_nesting = 8;
  r.most_repeats = 9'999;
  r.type_two = false;  // the last one wins (L5577)
  r.macro_calls = r.h_codes = true;
  r.whole_arguments = program::letters("HMQST");
  return r;
}

}  // namespace

void add_gsk_2000tc_macros(Dialect& d) {
  static const macro::Rules rules = make_rules();
  d.macros = &rules;
  d.system_variables = kVariables;
}

}  // namespace headstock::dialects

// The macro language of FANUC Series 0i-D: its rules and its system variables (0i-D chapter 14).
#include "macro/rules.hpp"

#include "dialects/build.hpp"
#include "interpreter/system_variables.hpp"
#include "program/block.hpp"

namespace headstock::dialects {
namespace {

using namespace interp::system_variables;
using interp::SystemVariable;
using program::letters;

macro::Rules make_rules(bool lathe) {
  macro::Rules r;
  r.statements = true;
  r.common = {{{100, 199, false}, {500, 999, true}}};
  r.retained_start_at_zero = true;  // K.17
  r.keep_volatile_parameter = "6001#6";
  r.single_block_parameter = "6000#5";
  r.switched_single_block_parameter = "6000#7";
  r.fast_goto_first_parameter = "6000#1";
  r.fast_goto_recent_parameter = "6000#4";
  r.sequence_call_parameter = "6005#0";
  r.external_in_mdi_parameter = "11630#1";
  r.protect_first = "6031";
  r.protect_last = "6032";
  r.signed_angles_parameter = "6004#0";
  r.eight_digits_parameter = "6008#0";
  r.converted_arguments_parameter = "6007#4";
  r.alarm_plain_parameter = "6008#1";
  r.type_one_parameter = "6008#7";
  r.macro_calls = r.modal_calls = true;
  r.whole_arguments = lathe ? letters("DHMQST") : letters("BDEHMSTUVW");
  r.lone_cancel_parameter = "6000#0";
  r.typed_arguments_parameter = "3452#7";
  if (lathe) r.decimal_d_parameter = "6019#2";
  r.g_macros = {"6050", 10, 9010};
  r.g_macro_block = {"6038", "6039", "6040"};
  r.m_macros = {"6080", 10, 9020};
  r.m_macro_block = {"6047", "6048", "6049"};
  r.m_subs = {"6071", 9, 9001};
  r.m_sub_block = {"6044", "6045", "6046"};
  r.t_sub_parameter = "6001#5";
  r.address_parameters = {"6090", "6091"};
  r.address_programs = {9004, 9005};
  r.address_variables = {146, 147};
  r.nested_codes_parameter = "6008#6";
  r.external_call = true;
  r.external_m_parameter = "6030";
  r.interruption = true;
  r.interruption_codes_parameter = "6003#4";
  r.interruption_on_parameter = "6033";
  r.interruption_off_parameter = "6034";
  r.interruption_same_locals_parameter = "6003#5";
  r.printing = true;
  r.print_plain_parameter = "6001#1";
  r.print_cr_parameter = "6001#4";
  r.names = true;
  return r;
}

constexpr char kAxisOfIndex = 0;

// Both series. The M codes' values B D H and G54.1 exist on the M series only: kMillVariables.
#define BOTH_SERIES                                                                                         \
  {1000, 1015, read_input, nullptr, 0}, {1016, 1031, read_input, nullptr, 16, "6001#0"},                    \
      {1032, 1032, read_input_word, nullptr, 0}, {1033, 1035, read_input_word, nullptr, 32, "6001#0"},      \
      {1100, 1115, read_output, write_output, 0}, {1116, 1131, read_output, write_output, 16, "6001#0"},    \
      {1132, 1133, read_output_word, write_output_word, 0},                                                 \
      {1134, 1135, read_output_word, write_output_word, 64, "6001#0"}, {3000, 3000, nullptr, raise_alarm},   \
      {3001, 3001, read_clock, write_clock, 0}, {3002, 3002, read_clock, write_clock, 1},                   \
      {3003, 3003, read_control, write_control, 0}, {3004, 3004, read_control, write_control, 1},           \
      {3005, 3005, read_settings, write_settings}, {3006, 3006, nullptr, stop_with_message},                \
      {3007, 3007, read_mirror}, {3008, 3008, read_restarting}, {3011, 3012, read_date},                    \
      {3100, 3100, read_null}, {3101, 3101, read_constant, nullptr, 0},                                     \
      {3102, 3102, read_constant, nullptr, 1}, {3901, 3902, read_parts, write_parts},                       \
      {4000, 4000, read_main_program}, {5001, 5005, read_block_end}, {5021, 5025, read_machine_position},   \
      {5041, 5045, read_work_position}, {5061, 5065, read_skip_position}, {5101, 5105, read_deviation},     \
      {5181, 5185, read_distance_to_go}, {5201, 5205, read_work, write_work, 0, "!8136#0"},                 \
      {5221, 5225, read_work, write_work, -1, "!8136#0"}, {5241, 5245, read_work, write_work, -2, "!8136#0"}, \
      {5261, 5265, read_work, write_work, -3, "!8136#0"}, {5281, 5285, read_work, write_work, -4, "!8136#0"}, \
      {5301, 5305, read_work, write_work, -5, "!8136#0"}, {5321, 5325, read_work, write_work, -6, "!8136#0"}, \
      {5900, 5900, read_kept, write_kept}, MODAL_ROWS(4000, Which::preceding),                              \
      MODAL_ROWS(4200, Which::executing), MODAL_ROWS(4400, Which::interrupted)
#define MODAL_ROWS(base, which)                                                                     \
  {(base) + 1, (base) + 30, read_group, nullptr, static_cast<std::int32_t>(which) << 8 | 1},        \
      {(base) + 108, (base) + 108, read_modal, nullptr, modal_value(which, 'E')},                   \
      {(base) + 109, (base) + 109, read_modal, nullptr, modal_value(which, 'F')},                   \
      {(base) + 113, (base) + 113, read_modal, nullptr, modal_value(which, 'M')},                   \
      {(base) + 114, (base) + 114, read_modal, nullptr, modal_value(which, 'N')},                   \
      {(base) + 115, (base) + 115, read_modal, nullptr, modal_value(which, 'O')},                   \
      {(base) + 119, (base) + 119, read_modal, nullptr, modal_value(which, 'S')},                   \
      {(base) + 120, (base) + 120, read_modal, nullptr, modal_value(which, 'T')}
#define MILL_MODAL_ROWS(base, which)                                                                \
  {(base) + 102, (base) + 102, read_modal, nullptr, modal_value(which, 'B')},                       \
      {(base) + 107, (base) + 107, read_modal, nullptr, modal_value(which, 'D')},                   \
      {(base) + 111, (base) + 111, read_modal, nullptr, modal_value(which, 'H')},                   \
      {(base) + 130, (base) + 130, read_modal, nullptr, modal_value(which, 'P')}

constexpr SystemVariable kMillVariables[] = {
    BOTH_SERIES,
    MILL_MODAL_ROWS(4000, Which::preceding),
    MILL_MODAL_ROWS(4200, Which::executing),
    MILL_MODAL_ROWS(4400, Which::interrupted),
    {3980, 3980, read_offset_memory},
    // Memory A (NGW 8136#6): one number; memory C: length and radius, geometry and wear. V10 6000#3 and D10
    // 6004#5 choose the numbers (L13829-13923).
    {2001, 2200, read_tool, write_tool, tool_cell(ToolCell::single), "8136#6"},
    {10001, 10400, read_tool, write_tool, tool_cell(ToolCell::single), "8136#6"},
    {2001, 2200, read_tool, write_tool, tool_cell(ToolCell::wear), "!8136#6 !6000#3"},
    {2201, 2400, read_tool, write_tool, tool_cell(ToolCell::geometry), "!8136#6 !6000#3"},
    {10001, 10400, read_tool, write_tool, tool_cell(ToolCell::wear), "!8136#6 !6000#3"},
    {11001, 11400, read_tool, write_tool, tool_cell(ToolCell::geometry), "!8136#6 !6000#3"},
    {12001, 12400, read_tool, write_tool, tool_cell(ToolCell::radius_wear), "!8136#6 !6000#3"},
    {13001, 13400, read_tool, write_tool, tool_cell(ToolCell::radius), "!8136#6 !6000#3"},
    {2001, 2200, read_tool, write_tool, tool_cell(ToolCell::geometry), "!8136#6 6000#3"},
    {2201, 2400, read_tool, write_tool, tool_cell(ToolCell::wear), "!8136#6 6000#3"},
    {2401, 2600, read_tool, write_tool, tool_cell(ToolCell::radius), "!8136#6 6000#3 6004#5"},
    {2601, 2800, read_tool, write_tool, tool_cell(ToolCell::radius_wear), "!8136#6 6000#3 6004#5"},
    {10001, 10400, read_tool, write_tool, tool_cell(ToolCell::geometry), "!8136#6 6000#3"},
    {11001, 11400, read_tool, write_tool, tool_cell(ToolCell::wear), "!8136#6 6000#3"},
    {12001, 12400, read_tool, write_tool, tool_cell(ToolCell::radius), "!8136#6 6000#3"},
    {13001, 13400, read_tool, write_tool, tool_cell(ToolCell::radius_wear), "!8136#6 6000#3"},
    {2500, 2506, read_work, write_work, 1, "!6004#5 !8136#0"},
    {2600, 2606, read_work, write_work, 2, "!6004#5 !8136#0"},
    {2700, 2706, read_work, write_work, 3, "!6004#5 !8136#0"},
    {2800, 2806, read_work, write_work, 4, "!6004#5 !8136#0"},
    {5081, 5085, read_tool_in_force, nullptr, kAxisOfIndex},
    {5121, 5125, read_handle_interruption},
    {7001, 7945, read_extra_work, write_extra_work, 0, "!8136#2"},
    {14001, 14945, read_extra_work, write_extra_work, 0, "!8136#2"},
};

constexpr SystemVariable kLatheVariables[] = {
    BOTH_SERIES,
    // Without geometry and wear memory (NGW 8136#6) one value an axis, else both (L13937-14060).
    {2001, 2064, read_tool, write_tool, tool_cell(ToolCell::single, 'X'), "8136#6"},
    {10001, 10200, read_tool, write_tool, tool_cell(ToolCell::single, 'X'), "8136#6"},
    {2101, 2164, read_tool, write_tool, tool_cell(ToolCell::single, 'Z'), "8136#6"},
    {11001, 11200, read_tool, write_tool, tool_cell(ToolCell::single, 'Z'), "8136#6"},
    {2201, 2264, read_tool, write_tool, tool_cell(ToolCell::radius), "8136#6"},
    {12001, 12200, read_tool, write_tool, tool_cell(ToolCell::radius), "8136#6"},
    {2401, 2449, read_tool, write_tool, tool_cell(ToolCell::single, 'Y'), "8136#6"},
    {14001, 14200, read_tool, write_tool, tool_cell(ToolCell::single, 'Y'), "8136#6"},
    {2301, 2364, read_tool, write_tool, tool_cell(ToolCell::tip)},
    {13001, 13200, read_tool, write_tool, tool_cell(ToolCell::tip)},
    {2001, 2064, read_tool, write_tool, tool_cell(ToolCell::wear, 'X'), "!8136#6"},
    {10001, 10200, read_tool, write_tool, tool_cell(ToolCell::wear, 'X'), "!8136#6"},
    {2101, 2164, read_tool, write_tool, tool_cell(ToolCell::wear, 'Z'), "!8136#6"},
    {11001, 11200, read_tool, write_tool, tool_cell(ToolCell::wear, 'Z'), "!8136#6"},
    {2201, 2264, read_tool, write_tool, tool_cell(ToolCell::radius_wear), "!8136#6"},
    {12001, 12200, read_tool, write_tool, tool_cell(ToolCell::radius_wear), "!8136#6"},
    {2401, 2449, read_tool, write_tool, tool_cell(ToolCell::wear, 'Y'), "!8136#6"},
    {14001, 14200, read_tool, write_tool, tool_cell(ToolCell::wear, 'Y'), "!8136#6"},
    {2451, 2499, read_tool, write_tool, tool_cell(ToolCell::geometry, 'Y'), "!8136#6"},
    {19001, 19200, read_tool, write_tool, tool_cell(ToolCell::geometry, 'Y'), "!8136#6"},
    {2701, 2749, read_tool, write_tool, tool_cell(ToolCell::geometry, 'X'), "!8136#6"},
    {15001, 15200, read_tool, write_tool, tool_cell(ToolCell::geometry, 'X'), "!8136#6"},
    {2801, 2849, read_tool, write_tool, tool_cell(ToolCell::geometry, 'Z'), "!8136#6"},
    {16001, 16200, read_tool, write_tool, tool_cell(ToolCell::geometry, 'Z'), "!8136#6"},
    {2901, 2964, read_tool, write_tool, tool_cell(ToolCell::radius), "!8136#6"},
    {17001, 17200, read_tool, write_tool, tool_cell(ToolCell::radius), "!8136#6"},
    {2501, 2501, read_work_shift, write_work_shift, 'X'},
    {2601, 2601, read_work_shift, write_work_shift, 'Z'},
    {2550, 2556, read_work, write_work, 1, "!8136#0"},
    {2650, 2656, read_work, write_work, 2, "!8136#0"},
    {2750, 2756, read_work, write_work, 3, "!8136#0"},
    {2850, 2856, read_work, write_work, 4, "!8136#0"},
    {5081, 5081, read_tool_in_force, nullptr, 'X'},
    {5082, 5082, read_tool_in_force, nullptr, 'Z'},
    {5083, 5083, read_tool_in_force, nullptr, 'Y'},
    {5121, 5121, read_tool_in_force, nullptr, 'X' | 256, "!6004#2 !8136#6"},
    {5122, 5122, read_tool_in_force, nullptr, 'Z' | 256, "!6004#2 !8136#6"},
    {5123, 5123, read_tool_in_force, nullptr, 'Y' | 256, "!6004#2 !8136#6"},
    {5121, 5125, read_handle_interruption, nullptr, 0, "6004#2"},
};

}  // namespace

void add_fanuc_macros(Dialect& d) {
  static const macro::Rules mill = make_rules(false), lathe = make_rules(true);
  d.macros = d.tools.lathe ? &lathe : &mill;
  d.system_variables = d.tools.lathe ? std::span<const SystemVariable>(kLatheVariables)
                                     : std::span<const SystemVariable>(kMillVariables);
  using R = AlarmReason;
  for (const auto& [reason, code] : std::initializer_list<std::pair<R, std::string_view>>{
           {R::macro_syntax, "PS0125"},        {R::offset_name, "PS1096"},
                 {R::macro_integer, "PS0110"},
           {R::macro_overflow, "PS0111"},      {R::macro_divide, "PS0112"},
           {R::expression, "PS0114"},          {R::macro_expression, "PS1125"},
           {R::macro_variable, "PS0115"},      {R::macro_protected, "PS0116"},
           {R::macro_write_only, "PS1115"},    {R::macro_brackets, "PS0118"},
           {R::macro_argument, "PS0119"},      {R::macro_digits, "PS0012"},
           {R::macro_two_arguments, "PS1120"}, {R::macro_open_bracket, "PS1131"},
           {R::macro_close_bracket, "PS1132"}, {R::macro_equals, "PS1133"},
           {R::macro_comma, "PS1134"},         {R::macro_if_form, "PS1137"},
           {R::macro_while_form, "PS1138"},    {R::macro_loop_number, "PS0126"},
           {R::macro_loop_end, "PS0124"},      {R::macro_loop_begin, "PS1124"},
           {R::macro_goto_range, "PS1128"},    {R::macro_goto_target, "PS0128"},
           {R::macro_dnc, "PS0123"},           {R::macro_with_words, "PS0127"},
           {R::macro_g_argument, "PS0129"},    {R::macro_groups, "PS1095"},
           {R::macro_nesting, "PS0122"},       {R::macro_call_twice, "PS1092"},
           {R::sub_call_twice, "PS1091"},      {R::macro_m99_with_words, "PS1093"},
           {R::macro_cancel, "PS1100"},        {R::macro_no_name, "PS1098"},
           {R::macro_name_long, "PS1097"},     {R::macro_subscript, "PS1099"},
           {R::macro_names_form, "PS1139"},    {R::macro_name_character, "PS1141"},
           {R::macro_set_name_long, "PS1142"}, {R::macro_print_form, "PS1143"},
           {R::external_not_found, "PS1079"},  {R::external_in_mdi, "PS1081"},
           {R::mdi_jump, "PS0377"},            {R::interrupted_cycle, "PS0324"},
           {R::external_in_dnc, "PS0210"},
           {R::mdi_compensation, "PS5257"},
           {R::macro_word_unknown, "PS0199"},  {R::call_in_hole_cycle, "PS5329"},  {R::external_twice, "PS1080"}}) {
    d.set_alarm_code(reason, code);
  }
  if (!d.tools.lathe) d.set_alarm_code(R::interrupted_cycle, "PS1101");  // PS0324 is the T series'
}

}  // namespace headstock::dialects

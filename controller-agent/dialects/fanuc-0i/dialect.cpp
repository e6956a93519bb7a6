// FANUC Series 0i-D: what the T and the M series share, and both of them. Rules: manual B-64304CM, parts as
// in the digest.
#include "dialects/build.hpp"
#include "program/block.hpp"
#include "tables/gcodes_fanuc_0i_m.hpp"
#include "tables/gcodes_fanuc_0i_t.hpp"

namespace headstock::dialects {
namespace {

using program::letters;
using R = AlarmReason;

// Parameters with one value an axis: G10 L52 needs P for them (spec: parameter table, "axis type").
constexpr ParameterRange kAxisParameters[] = {
    {1003, 1003}, {1005, 1009}, {1012, 1013}, {1015, 1015}, {1020, 1025}, {1220, 1226}, {1240, 1244},
    {1250, 1250}, {1260, 1260}, {1310, 1310}, {1320, 1327}, {1408, 1408}, {1420, 1425}, {1427, 1428},
    {1430, 1434}, {1465, 1465}, {1610, 1610}, {1620, 1627}, {1660, 1661}, {1730, 1738}, {1769, 1769},
    {1783, 1785}, {1815, 1821}, {1825, 1838}, {1850, 1852}, {1880, 1884}, {3115, 3115}, {3455, 3455},
    {3620, 3627}, {5401, 5401}, {5421, 5421}, {5440, 5440}, {6287, 6287}, {7310, 7310}};
constexpr ParameterRange kSpindleParameters[] = {{3700, 4999}};

constexpr Option kOptions[] = {{"8136#0", 520, 520},
                               {"8136#0", 540, 590},
                               {"8136#1", 921, 921},
                               {"8136#1", 503, 503},
                               {"8136#2", 541, 541}};

void set_common_modes(ModeRules& modes) {
  modes.options = kOptions;
  modes.tenfold_unit_parameter = "1004#7";
  modes.axis_decimal_parameter = "3455#0";
  modes.flow_codes_alone = true;
  modes.compensation_group = 7;
  modes.unit_group = 6;
  modes.work_group = 14;
  modes.kept_group_parameters = {"3406", "3407", "3408", "3409"};
  modes.reset_work_parameter = "1201#7";
  modes.reset_local_parameter = "1202#3";
  modes.diameter_parameter = "1006#3";
  modes.rotary_parameter = "1006#0";
  modes.roll_over_parameter = "1008#0";
  modes.roll_over_by_sign_parameter = "1008#1";
  modes.turn_parameter = "1260";
  modes.most_axes_at_once = 4;
  modes.first_reference_parameter = "1240";
  modes.imaginary_circle_parameter = "1408#0";
  modes.imaginary_radius_parameter = "1465";
  modes.skip_signals = {"6202", "6203", "6204", "6205", "6206"};
  modes.skip_feed_parameter = "6207#1";
  modes.skip_step_feed_parameter = "6207#2";
  modes.skip_override_parameter = "6200#7";
  modes.skip_off_parameter = "6201#7";
  modes.inch_parameter = "0000#2";
  modes.rotary_linear_parameter = "1006#1";
  modes.mdi_form_parameter = "3401#4";
  modes.mdi_absolute_parameter = "3401#5";
  modes.scale_enable_parameter = "5401#0";
  modes.fine_angle_parameter = "11630#0";
  modes.skip_low_parameter = "6200#1";
  modes.dwell_p_scales = true;
  modes.dwell_ms_parameter = "1015#7";
  modes.stroke_2_most = "1322";
  modes.stroke_2_least = "1323";
  modes.stroke_2_outside_parameter = "1300#0";
  modes.unit_at_reference_parameter = "14000#2";
  modes.unit_anywhere_parameter = "11222#0";
  modes.unit_clears_shift_parameter = "11222#1";
  modes.highest_speed_parameter = "3772";
  modes.surface_axis_parameter = "3770";
  modes.spindle_digits_parameter = "3031";
  modes.tool_digits_parameter = "3032";
  modes.auxiliary_digits_parameter = "3033";
  modes.auxiliary_enable_parameter = "8132#2";
  modes.auxiliary_address_parameter = "3460";
  modes.auxiliary_decimal_parameter = "3450#0";
  modes.auxiliary_inch_parameter = "3405#0";
  modes.auxiliary_unit_parameter = "3450#7";    // BDX
  modes.several_spindles_parameter = "8133#3";  // MSP
  modes.spindle_by_p_parameter = "3703#3";      // MPP
  modes.spindle_p_parameter = "3781";
  modes.one_spindle_parameter = "3702#1";  // EMS
  modes.parameter_input = true;
  modes.largest_offset = 9'999.9999;
  modes.surface_speed_zero_refused = true;
  modes.mirror_setting_parameter = "0012#0";
  modes.axis_parameters = kAxisParameters;
  modes.spindle_parameters = kSpindleParameters;
}

// Tool life (0i-D 10.2).
void set_common_life(ToolLifeRules& life) {
  life.enable_parameter = "8132#0";
  life.most_groups_parameter = "6813";
  life.split_low_parameter = "6800#0";
  life.split_high_parameter = "6800#1";
  life.by_time_parameter = "6800#2";
  life.tenths_word_parameter = "6805#1";
  life.tenths_count_parameter = "6805#0";
  life.round_up_parameter = "6805#6";
  life.restart_parameter = "6811";
  life.restart_large_parameter = "13221";
  life.stop_at_m99_parameter = "6802#0";
  life.notice_uses_parameter = "6844";
  life.notice_time_parameter = "6845";
  life.notice_equal_parameter = "6802#7";
}

Dialect make_common() {
  Dialect d;
  d.reference_refused_in_cycle = true;  // PS0044
  set_alarm_codes(d, "PS0010",
                  {{R::no_address, "PS0004"},
                   {R::no_data, "PS0005"},
                   {R::minus_sign, "PS0006"},
                   {R::decimal_point, "PS0007"},
                   {R::too_many_digits, "PS0003"},
                   {R::value_range, "PS0003"},
                   {R::illegal_address, "PS0009"},
                   {R::duplicate_word, "PS5074"},
                   {R::block_too_long, "PS1016"},
                   {R::program_number, "PS1014"},
                   {R::end_of_record, "PS5010"},
                   {R::input_failed, "PS0086"},
                   {R::expression, "PS0114"},
                   {R::statement_unavailable, "PS0113"},
                   {R::g_same_group, "PS5074"},
                   {R::too_many_m, "PS5074"},
                   {R::t_not_allowed, "PS0245"},
                   {R::feed_missing, "PS0011"},
                   {R::arc_radius, "PS0020"},
                   {R::arc_no_center, "PS0022"},
                   {R::arc_negative_r, "PS0023"},
                   {R::arc_r_too_small, "PS0020"},
                   {R::arc_plane, "PS0021"},
                   {R::thread_lead, "PS0011"},
                   {R::reference_check, "PS0092"},
                   {R::reference_number, "PS0046"},
                   {R::no_intermediate, "PS0305"},
                   {R::length_axis, "PS0027"},
                   {R::length_axes, "PS0336"},
                   {R::step_in_compensation, "PS0042"},
                   {R::measure_signal, "PS0080"},
                   {R::measure_number, "PS0081"},
                   {R::measure_with_offset, "PS0082"},
                   {R::measure_axis, "PS0083"},
                   {R::reference_in_cycle, "PS0044"},
                   {R::compensation_no_avoidance, "PS5446"},
                   {R::compensation_danger, "PS5447"},
                   {R::compensation_again, "PS5448"},
                   {R::offset_number, "PS0030"},
                   {R::work_number, "PS0030"},
                   {R::data_input, "PS1144"},
                   {R::data_value, "PS0032"},
                   {R::call_without_p, "PS0076"},
                   {R::program_not_found, "PS0076"},
                   {R::sequence_not_found, "PS0078"},
                   {R::life_format, "PS0149"},
                   {R::life_group_number, "PS0150"},
                   {R::life_group_missing, "PS0151"},
                   {R::life_too_many_tools, "PS0152"},
                   {R::life_no_t, "PS0153"},
                   {R::life_not_in_use, "PS0154"},
                   {R::life_wrong_t, "PS0155"},
                   {R::life_no_p_l, "PS0156"},
                   {R::life_too_many_groups, "PS0157"},
                   {R::life_value, "PS0158"},
                   {R::life_data, "PS0159"},
                   {R::nesting, "PS0077"},
                   {R::call_count, "PS0076"},
                   {R::g_not_now, "PS0412"},
                   {R::cylinder_axis, "PS0175"},
                   {R::cylinder_code, "PS0176"},
                   {R::skip_not_allowed, "PS0035"},
                   {R::skip_format, "PS0369"},
                   {R::skip_number, "PS0370"},
                   {R::unit_change, "PS1298"},
                   {R::unit_change_place, "PS5362"},
                   {R::increment_limit, "PS0337"},
                   {R::data_number, "PS0031"},
                   {R::parameter_format, "PS0231"},
                   {R::parameter_word_missing, "PS1301"},
                   {R::parameter_number, "PS1302"},
                   {R::parameter_axis, "PS1303"},
                   {R::parameter_axis_missing, "PS1306"},
                   {R::parameter_no_axis, "PS1300"},
                   {R::parameter_range, "PS1305"},
                   {R::parameter_sign, "PS1307"},
                   {R::surface_axis, "PS0190"},
                   {R::helix_axes, "PS0232"},
                   {R::arc_foreign_axis, "PS0028"},
                   {R::too_many_axes, "PS0015"},
                   {R::spindle_number, "PS5305"},
                   {R::m_combination, "PS5016"},
                   {R::position_overflow, "PS1160"},
                   {R::transform_overflow, "PS0143"},
                   {R::compensated_overflow, "PS5007"},
                   {R::surface_speed_zero, "PS1541"},
                   {R::number_place, "PS1013"},
                   {R::too_many_words, "PS5006"},
                   {R::interrupted_transform, "PS1101"},
                   {R::arc_increments, "PS5064"}});
  d.m_rules = usual_m_rules();
  d.m_rules.push_back({6, MAction::machine});
  d.m_rules.push_back({29, MAction::rigid_tapping});
  d.m_rules.push_back({198, MAction::unavailable});  // call from an external device
  d.numbers.decimal_parameter = "3401#0";            // DPI
  d.numbers.coarse_increment_parameter = "1013#0";
  d.numbers.fine_increment_parameter = "1013#1";
  d.arcs.tolerance_mm = 0.03;
  d.arcs.tolerance_parameter = "3410";
  d.calls = {.nesting = 10, .l_repeats = true, .most_repeats = 99'999'999, .by_name = false};
  d.threads.f_is_feed_too = true;
  d.reset_clears_parameter = "3402#6";
  d.setting_refused_parameter = "1202#2";
  d.no_count_parameter = "6700#0";
  d.linear_rapid_parameter = "1401#1";
  d.part_count_m_parameter = "6710";
  d.rigid_m_parameter = "5210";
  d.interruption.between_parameter = "6003#2";
  d.interruption.level_parameter = "6003#3";
  d.look_ahead = {.stops = true,
                  .machine_moves = true,
                  .held_m = "3411",
                  .held_m_ranges = "3421",
                  .held_m_count = 10,
                  .held_m_range_count = 12};
  d.dwell_turns_parameter = "3405#1";
  d.more_m_parameter = "3404#7";
  d.repeated_alarm_parameter = "3403#6";
  d.arcs.feed_on_arc = true;
  d.arcs.feed_on_path_parameter = "1403#5";  // HTG
  set_common_modes(d.modes);
  set_common_life(d.life);
  return d;
}

void set_changer_life(ToolLifeRules& life) {
  life.form = ToolLifeRules::Form::changer;
  life.ignore_parameter = "6810";
  life.next_in_change_parameter = "6800#7";
  life.count_in_change_parameter = "6801#7";
  life.change_without_t_parameter = "6805#7";
  life.any_returned_parameter = "6800#6";
  life.h_parameter = "13265";
  life.d_parameter = "13266";
}

}  // namespace

Dialect make_fanuc_0i_t() {
  Dialect d = make_common();
  d.profile = "fanuc-0i-t";
  d.life.form = ToolLifeRules::Form::turret;
  d.life.per_offset_parameter = "6801#1";
  d.set_alarm_code(R::no_intermediate, "PS0010");  // M alarms: no G29, no G43 here
  d.set_alarm_code(R::length_axis, "PS0010");
  d.set_alarm_code(R::length_axes, "PS0010");  // both M only, as G43-G48 are
  d.set_alarm_code(R::step_in_compensation, "PS0010");
  d.set_alarm_code(R::polar_axis, "PS0145");
  d.set_alarm_code(R::polar_code, "PS0146");
  d.set_alarm_code(R::look_ahead_format, "PS0109");
  d.set_alarm_code(R::polygon_again, "PS0217");
  d.set_alarm_code(R::polygon_words, "PS0218");
  d.set_alarm_code(R::polygon_alone, "PS0219");
  d.set_alarm_code(R::polygon_axis, "PS0314");
  d.modes.polygon_axis_parameter = "7610";
  d.modes.system_b_parameter = "3401#6";
  d.modes.system_c_parameter = "3401#7";
  d.modes.fine_feed_per_minute_parameter = "1404#2";
  d.set_alarm_code(R::thread_lead_change, "PS0313");
  add_g_codes(d, tables::gcodes_fanuc_0i_t);
  d.incremental_letters[0] = true;  // U W V H (8.1)
  d.hole_clamp_parameter = "5110";
  d.arcs.negative_r = false;  // PS0023 is a T alarm
  d.tools = {.lathe = true,
             .offset_digits = 2,
             .offset_digits_parameter = "5028",
             .geometry_by_tool_parameter = "5002#1",
             .sign = 1,
             .most_offsets = 200};
  // 0i-D parameters 5002, 5004, 5006, 5040; digests d1 7.1, d2 7.
  d.tool_offsets.wear_shift_parameter = "5002#2";          // LWT
  d.tool_offsets.geometry_move_parameter = "5002#4";       // LGT
  d.tool_offsets.with_next_move_parameter = "5002#6";      // LWM
  d.tool_offsets.radius_parameter = "5004#1";              // ORC
  d.tool_offsets.wear_diameter_parameter = "5040#0";       // OWD
  d.tool_offsets.single_parameter = "8136#6";              // NGW
  d.tool_offsets.reset_clears_wear_parameter = "5006#3";   // LVC
  d.tool_offsets.reset_clears_shift_parameter = "5003#7";  // TGC
  d.tool_offsets.few_parameter = "8136#5";                 // NDO
  d.tool_offsets.few = 64;
  d.measure = {.feed = {"6241", {}, "6242"},
               .gamma = {"6251", {}, "6252"},
               .epsilon = {"6254", {}, "6255"},
               .axis = {'X', 'Z'},
               .subtract_parameter = "6210#6"};
  d.corner_words = letters("IJKRCA");
  d.t_refused_with_actions = true;  // PS0245
  d.modes.stroke_group = 9;
  d.modes.polar_linear_parameter = "5460";
  d.modes.polar_rotary_parameter = "5461";
  d.modes.polar_unsupported = {"5450#2", "5464"};  // shift function and rotary centre beside the axis
  d.modes.watch_delay_parameter = "4914";
  d.modes.watch_reached_parameter = "4911";
  d.modes.watch_ratio_parameter = "4912";
  d.modes.watch_width_parameter = "4913";
  d.modes.watch_fine_parameter = "4900#0";
  d.power_on_switches = {{"3402#0", {10, 10, 10}},
                         {"3402#3", {-1, 910, 910}},
                         {"3402#4", {980, 940, 940}},
                         {"3402#7", {230, 230, 230}}};
  add_fanuc_macros(d);
  d.numbers.addresses = letters("ABCDEFHIJKLPQRSTUVWXYZ");
  d.numbers.pointed = letters("ABCFIJKRUVWXYZE");
  d.numbers.negative = letters("ABCIJKRUVWXYZ");
  return d;
}

Dialect make_fanuc_0i_m() {
  Dialect d = make_common();
  d.profile = "fanuc-0i-m";
  set_changer_life(d.life);
  d.set_alarm_code(R::scale_value, "PS0142");
  d.set_alarm_code(R::scaling_code, "PS0300");
  d.set_alarm_code(R::rotation_plane, "PS0144");
  d.set_alarm_code(R::arc_in_rapid, "PS0025");
  d.set_alarm_code(R::setting_with_length, "PS5391");
  d.set_alarm_code(R::arc_negative_r, "PS0010");  // a T alarm: negative R is legal here
  d.kind = machine::Kind::mill;
  d.small_hole_parameter = "8132#4";  // SPK
  d.small_hole_m_parameter = "5163";
  d.modes.stroke_group = 4;
  d.modes.fine_feed_per_revolution_parameter = "1405#1";
  d.threads.q_parameter = "3451#0";
  d.modes.gear_speeds = {"3741", "3742", "3743"};
  d.modes.gears_by_machine_parameter = "3706#4";
  d.modes.rotation_group = 16;
  d.modes.scaling_group = 11;
  d.modes.mirror_group = 22;
  d.modes.polar_group = 17;
  d.modes.scale_unit_parameter = "5400#7";
  d.modes.scale_each_parameter = "5400#6";
  d.modes.scale_parameter = "5411";
  d.modes.scale_axis_parameter = "5421";
  d.modes.rotation_parameter = "5410";
  d.modes.rotation_incremental_parameter = "5400#0";
  d.modes.approach_parameter = "5440";
  d.modes.approach_modal_parameter = "5431#0";
  d.modes.one_digit_feed = {.enable = "8131#1", .first = 1451, .most_1_to_4 = "1460", .most_5_to_9 = "1461"};
  add_g_codes(d, tables::gcodes_fanuc_0i_m);
  d.tools = {.lathe = false,
             .offset_digits = 2,
             .offset_digits_parameter = {},
             .geometry_by_tool_parameter = {},
             .sign = 1,
             .most_offsets = 400};
  d.tool_offsets.few_parameter = "8136#5";  // NDO
  d.tool_offsets.few = 32;
  d.tool_offsets.single_parameter = "8136#6";              // NGW: memory A
  d.tool_offsets.normal_axis_parameter = "5001#1";         // TLB
  d.tool_offsets.named_axis_parameter = "5001#0";          // TLC
  d.tool_offsets.several_axes_parameter = "5001#3";        // TAL
  d.tool_offsets.at_once_parameter = "5001#6";             // EVO
  d.tool_offsets.reset_keeps_length_parameter = "5003#6";  // LVK
  d.measure = {.feed = {"6241", "6242", "6243"},
               .gamma = {"6251", "6252", "6253"},
               .epsilon = {"6254", "6255", "6256"},
               .subtract_parameter = "6210#6"};
  d.power_on_switches = {{"3402#0", {10, 10, 10}},
                         {"3402#1", {180, 180, 180}},
                         {"3402#2", {190, 190, 190}},
                         {"3402#3", {910, 910, 910}},
                         {"3402#7", {230, 230, 230}}};
  add_fanuc_macros(d);
  d.numbers.feed_per_revolution_unit_mm = 0.01;  // FR3(1405#1) = 0
  d.numbers.feed_per_revolution_unit_inch = 0.0001;
  d.numbers.addresses = letters("ABCDEFHIJKLPQRSTUVWXYZ");
  d.numbers.pointed = letters("ABCFIJKQRUVWXYZ");
  d.numbers.negative = letters("ABCIJKQRUVWXYZ");
  return d;
}

}  // namespace headstock::dialects

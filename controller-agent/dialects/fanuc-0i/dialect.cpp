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

Dialect make_common() {
  Dialect d;
  set_alarm_codes(d, "PS0010", {{R::no_address, "PS0004"},         {R::no_data, "PS0005"},
                                {R::minus_sign, "PS0006"},         {R::decimal_point, "PS0007"},
                                {R::too_many_digits, "PS0003"},    {R::value_range, "PS0003"},
                                {R::illegal_address, "PS0009"},    {R::duplicate_word, "PS5074"},
                                {R::block_too_long, "PS1016"},     {R::program_number, "PS1014"},
                                {R::end_of_record, "PS5010"},      {R::input_failed, "PS0086"},
                                {R::expression, "PS0114"},         {R::statement_unavailable, "PS0113"},
                                {R::g_same_group, "PS5074"},       {R::too_many_m, "PS5074"},
                                {R::t_not_allowed, "PS0245"},      {R::feed_missing, "PS0011"},
                                {R::arc_radius, "PS0020"},         {R::arc_no_center, "PS0022"},
                                {R::arc_negative_r, "PS0023"},     {R::arc_r_too_small, "PS0020"},
                                {R::arc_plane, "PS0021"},          {R::thread_lead, "PS0011"},
                                {R::reference_check, "PS0092"},    {R::reference_number, "PS0046"},
                                {R::no_intermediate, "PS0305"},    {R::length_axis, "PS0027"},
                                {R::offset_number, "PS0030"},      {R::work_number, "PS0030"},
                                {R::data_input, "PS1144"},         {R::data_value, "PS0032"},
                                {R::call_without_p, "PS0076"},     {R::program_not_found, "PS0076"},
                                {R::sequence_not_found, "PS0078"}, {R::nesting, "PS0077"},
                                {R::call_count, "PS0076"}});
  d.m_rules = usual_m_rules();
  d.m_rules.push_back({6, MAction::machine});
  d.m_rules.push_back({29, MAction::unavailable});   // rigid tapping needs its cycle
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
  d.dwell_turns_parameter = "3405#1";
  d.more_m_parameter = "3404#7";
  d.repeated_alarm_parameter = "3403#6";
  return d;
}

}  // namespace

Dialect make_fanuc_0i_t() {
  Dialect d = make_common();
  d.profile = "fanuc-0i-t";
  d.set_alarm_code(R::no_intermediate, "PS0010");  // M alarms: no G29, no G43 here
  d.set_alarm_code(R::length_axis, "PS0010");
  add_g_codes(d, tables::gcodes_fanuc_0i_t);
  d.incremental_letters[0] = true;  // U W V H (8.1)
  d.arcs.negative_r = false;        // PS0023 is a T alarm
  d.tools = {.lathe = true,
             .offset_digits = 2,
             .offset_digits_parameter = "5028",
             .geometry_by_tool_parameter = "5002#1",
             .sign = 1,
             .most_offsets = 200};
  d.corner_words = letters("IJKRCA");
  d.t_refused_with_actions = true;  // PS0245
  d.power_on_switches = {{"3402#0", {10, 10, 10}}, {"3402#3", {-1, 910, 910}}, {"3402#4", {980, 940, 940}}};
  add_fanuc_macros(d);
  d.numbers.addresses = letters("ABCDEFHIJKLPQRSTUVWXYZ");
  d.numbers.pointed = letters("ABCFIJKRUVWXYZE");
  d.numbers.negative = letters("ABCIJKRUVWXYZ");
  return d;
}

Dialect make_fanuc_0i_m() {
  Dialect d = make_common();
  d.profile = "fanuc-0i-m";
  d.set_alarm_code(R::arc_negative_r, "PS0010");  // a T alarm: negative R is legal here
  d.kind = machine::Kind::mill;
  add_g_codes(d, tables::gcodes_fanuc_0i_m);
  d.tools = {.lathe = false,
             .offset_digits = 2,
             .offset_digits_parameter = {},
             .geometry_by_tool_parameter = {},
             .sign = 1,
             .most_offsets = 400};
  d.power_on_switches = {{"3402#0", {10, 10, 10}},
                         {"3402#1", {180, 180, 180}},
                         {"3402#2", {190, 190, 190}},
                         {"3402#3", {910, 910, 910}}};
  add_fanuc_macros(d);
  d.numbers.feed_per_revolution_unit_mm = 0.01;  // FR3(1405#1) = 0
  d.numbers.feed_per_revolution_unit_inch = 0.0001;
  d.numbers.addresses = letters("ABCDEFHIJKLPQRSTUVWXYZ");
  d.numbers.pointed = letters("ABCFIJKQRUVWXYZ");
  d.numbers.negative = letters("ABCIJKQRUVWXYZ");
  return d;
}

}  // namespace headstock::dialects

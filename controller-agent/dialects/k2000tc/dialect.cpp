// K2000TCi. Numbers it does not print are those of the FANUC scheme it follows.
#include "dialects/build.hpp"
#include "dialects/k2000tc/language.hpp"
#include "dialects/k2000tc/modes.hpp"
#include "program/block.hpp"
#include "tables/gcodes_k2000tc.hpp"

namespace headstock::dialects {
namespace k2000tc {
namespace {

constexpr OwnHandler kOwn[] = {
    {"macro_call", Phase::setting, macro_call},
    {"rapid_k2000", Phase::motion, rapid},
    {"feed_k2000", Phase::motion, feed},
    {"arc_cw_k2000", Phase::motion, arc_cw},
    {"arc_ccw_k2000", Phase::motion, arc_ccw},
    {"three_point_arc", Phase::motion, three_point_arc},
    {"plane_archimedean_cw", Phase::motion, plane_archimedean_cw},
    {"plane_archimedean_ccw", Phase::motion, plane_archimedean_ccw},
    {"space_archimedean_cw", Phase::motion, space_archimedean_cw},
    {"space_archimedean_ccw", Phase::motion, space_archimedean_ccw},
    {"plane_logarithmic_cw", Phase::motion, plane_logarithmic_cw},
    {"plane_logarithmic_ccw", Phase::motion, plane_logarithmic_ccw},
    {"space_logarithmic_cw", Phase::motion, space_logarithmic_cw},
    {"space_logarithmic_ccw", Phase::motion, space_logarithmic_ccw},
    {"dwell_k2000", Phase::action, dwell},
    {"modify_parameters", Phase::action, modify_parameters},
    {"hypothetical_axis", Phase::action, hypothetical_axis},
    {"spindle_thread", Phase::action, spindle_thread},
    {"spindle_thread_cycle", Phase::motion, spindle_thread_cycle},
    {"cylinder_k2000", Phase::action, cylinder},
    {"polar_interpolation_on_k2000", Phase::action, polar_interpolation_on},
    {"polar_interpolation_off_k2000", Phase::setting, polar_interpolation_off},
    {"diameter_or_radius", Phase::action, diameter_or_radius},
    {"machine_move_k2000", Phase::action, machine_move},
    {"fast_machine_move", Phase::action, fast_machine_move},
    {"assign_axes", Phase::action, assign_axes},
    {"mirror_x_on", Phase::setting, mirror_x_on},
    {"mirror_x_off", Phase::setting, mirror_x_off},
    {"rotation_on_k2000", Phase::action, rotation_on},
    {"rotation_off_k2000", Phase::setting, rotation_off},
    {"polar_on_k2000", Phase::setting, polar_on},
    {"skip_k2000", Phase::action, skip},
    {"inch_k2000", Phase::setting, inch},
    {"metric_k2000", Phase::setting, metric},
    {"data_input_k2000", Phase::action, data_input},
};

std::unique_ptr<interp::OwnLanguage> make_language(Executor& ex) {
  return std::make_unique<Language>(ex);
}

}  // namespace
}  // namespace k2000tc

Dialect make_k2000tc() {
  using program::letters;
  Dialect d;
  d.profile = "k2000tc";
  set_alarm_codes(d, "PS1205",
                  {{AlarmReason::no_address, "PS0004"},
                   {AlarmReason::no_data, "PS0005"},
                   {AlarmReason::minus_sign, "PS0006"},
                   {AlarmReason::decimal_point, "PS1202"},
                   {AlarmReason::too_many_digits, "PS1204"},
                   {AlarmReason::value_range, "PS1204"},
                   {AlarmReason::illegal_address, "PS0004"},
                   {AlarmReason::duplicate_word, "PS0004"},
                   {AlarmReason::absolute_and_incremental, "PS0004"},
                   {AlarmReason::block_too_long, "PS1204"},
                   {AlarmReason::slash_position, "PS1109"},
                   {AlarmReason::program_number, "PS0004"},
                   {AlarmReason::input_failed, "PS0086"},
                   {AlarmReason::expression, "PS0114"},
                   {AlarmReason::statement_unavailable, "PS0114"},
                   {AlarmReason::too_many_m, "PS0004"},
                   {AlarmReason::feed_missing, "PS0011"},
                   {AlarmReason::arc_radius, "PS0200"},
                   {AlarmReason::arc_no_center, "PS0329"},
                   {AlarmReason::arc_r_too_small, "PS0200"},
                   {AlarmReason::arc_plane, "PS0021"},
                   {AlarmReason::thread_lead, "PS0014"},
                   {AlarmReason::thread_f_and_i, "PS0014"},
                   {AlarmReason::reference_check, "PS0092"},
                   {AlarmReason::reference_number, "PS0094"},
                   {AlarmReason::no_intermediate, "PS0093"},
                   {AlarmReason::machine_incremental, "PS0241"},
                   {AlarmReason::offset_number, "PS0030"},
                   {AlarmReason::measure_signal, "PS0080"},
                   {AlarmReason::measure_number, "PS0081"},
                   {AlarmReason::measure_with_offset, "PS0082"},
                   {AlarmReason::measure_axis, "PS0083"},
                   {AlarmReason::data_input, "PS0032"},
                   {AlarmReason::data_value, "PS0032"},
                   {AlarmReason::call_without_p, "PS0078"},
                   {AlarmReason::program_not_found, "PS0078"},
                   {AlarmReason::sequence_not_found, "PS0128"},
                   {AlarmReason::nesting, "PS0077"},
                   {AlarmReason::polar_axis, "PS0120"},
                   {AlarmReason::polar_code, "PS0009"},
                   {AlarmReason::cylinder_axis, "PS0108"},
                   {AlarmReason::cylinder_code, "PS0009"},
                   {AlarmReason::call_count, "PS0078"}});
  add_g_codes(d, tables::gcodes_k2000tc, k2000tc::kOwn);
  d.make_own = k2000tc::make_language;
  d.incremental_letters[0] = true;
  d.m_rules = usual_m_rules();
  for (const std::int32_t own : {6, 91, 92, 93, 94, 96, 97}) d.m_rules.push_back({own, MAction::own});
  d.interruption = {.between_parameter = {},
                    .inside_parameter = "P4100.3",  // INTT
                    .level_parameter = "P4100.2",   // TSE: which value is which is not printed; as on 0i-D
                    .resets_modes = true,
                    .repeats_block = true};
  d.power_on_switches = {{"P2500.7", {10, 10, 10}}};
  d.modes.compensation_group = 7;
  d.modes.free_surfaces = true;
  d.modes.reference_parameters = {"P0511", "P0512", ""};
  d.modes.scale_in_thousandths = true;
  d.modes.scale_by_words = true;
  d.modes.scale_axis_parameter = "P3611";
  d.numbers.decimal_parameter = "P2500.3";  // PODI
  d.numbers.linear_decimals_parameter = "P0042";
  d.numbers.rotary_decimals_parameter = "P0045";
  d.numbers.rounding = Rounding::truncate;  // L7160
  d.numbers.most_digits = 17;               // only the digits left after cutting count
  d.numbers.addresses = letters("ABCDEFHIJKLPQRSTUVWXYZ");
  d.numbers.pointed = letters("ABCEFHIJKQRUVWXYZ");
  d.numbers.pointed_counts_parameter = "P3300.1";  // PQDOT
  d.numbers.negative = letters("ABCHIJKQRUVWXYZ");
  d.arcs = {.tolerance_mm = 0.01, .tolerance_parameter = "P6450"};
  d.threads = {.inch_word = true, .f_and_i_is_alarm = true, .f_is_feed_too = true};
  d.calls = {.nesting = 63, .l_repeats = false, .most_repeats = 9'999};
  d.tools = {.lathe = true, .offset_digits = 2, .sign = 1, .most_offsets = 32};
  d.tool_offsets.by_shift = false;  // L15039: the T block moves
  d.tool_offsets.radius_parameter = "P3200.4";
  d.tool_offsets.axis_parameter = "P3201.0";
  d.measure = {.feed = {"P4610", {}, {}},
               .gamma = {"P4611", {}, {}},
               .epsilon = {"P4612", {}, {}},
               .axis = {'X', 'Z'},
               .subtract_parameter = {},
               .into_geometry = true};
  d.corner_words = letters("IJKRCA");
  d.both_forms = BothForms::alarm;
  d.end_of_text = EndOfText::end;  // `%` without M30: reset state (L9340)
  d.inner_slash_is_alarm = true;
  d.local_per_system = true;
  d.first_g10_work = 0;
  d.machine_incremental_is_alarm = true;
  d.linear_rapid_parameter = "P0004.1";
  d.look_ahead.stops = true;          // L8655
  d.look_ahead.machine_moves = true;  // G53, L5669
  return d;
}

}  // namespace headstock::dialects

#include "dialects/gsk/family.hpp"

#include "dialects/build.hpp"

namespace headstock::dialects::gsk {

// The 2000TC manual prints few alarm numbers; where it has none, the alarm has the number of the 218T.
Dialect family() {
  using R = AlarmReason;
  Dialect d;
  set_alarm_codes(d, "010",
                  {{R::no_address, "004"},
                   {R::no_data, "005"},
                   {R::minus_sign, "006"},
                   {R::decimal_point, "007"},
                   {R::too_many_digits, "012"},
                   {R::value_range, "130"},
                   {R::illegal_address, "009"},
                   {R::duplicate_word, "129"},
                   {R::absolute_and_incremental, "132"},
                   {R::block_too_long, "019"},
                   {R::slash_position, "009"},
                   {R::program_number, "074"},
                   {R::end_of_record, "142"},
                   {R::input_failed, "032"},
                   {R::expression, "115"},
                   {R::statement_unavailable, "081"},
                   {R::m_unavailable, "181"},
                   {R::illegal_m, "181"},
                   {R::t_not_allowed, "183"},
                   {R::feed_missing, "011"},
                   {R::arc_radius, "026"},
                   {R::arc_no_center, "028"},
                   {R::arc_negative_r, "023"},
                   {R::arc_r_too_small, "026"},
                   {R::arc_r_and_center, "027"},
                   {R::arc_plane, "026"},
                   {R::thread_lead, "018"},
                   {R::thread_f_and_i, "134"},
                   {R::thread_lead_change, "018"},
                   {R::spindle_reversed, "047"},
                   {R::spindle_gear, "182"},
                   {R::surface_speed_gear, "141"},
                   {R::gear_change, "180"},
                   {R::no_start_point, "021"},
                   {R::offset_number, "030"},
                   {R::data_value, "043"},
                   {R::reference_number, "130"},
                   {R::dwell_words, "168"},
                   {R::call_without_p, "076"},
                   {R::program_not_found, "078"},
                   {R::sequence_not_found, "078"},
                   {R::nesting, "077"},
                   {R::macro_goto_target, "128"},
                   {R::macro_goto_range, "128"},
                   {R::macro_divide, "017"},
                   {R::macro_with_words, "081"},
                   {R::macro_variable, "115"},
                   {R::macro_protected, "115"},
                   {R::macro_write_only, "115"},
                   {R::macro_argument, "079"},
                   {R::h_code, "114"},
                   {R::h_target, "147"},
                   {R::h_operand, "169"},
                   {R::call_count, "163"},
                   {R::arc_r_too_large, "024"},
                   {R::surface_speed_zero, "155"}});
  for (bool& by_letter : d.incremental_letters) by_letter = true;
  d.m_rules = usual_m_rules();
  d.numbers.decimal = Decimal::pocket;  // all examples write millimetres without a point
  d.arcs = {.tolerance_mm = 0.01};
  d.modes.surface_speed_zero_refused = true;
  d.threads.inch_word = true;
  d.calls = {.nesting = 4};
  d.tools = {.lathe = true, .offset_digits = 2, .sign = 1};
  d.repeated_words = Repeated::alarm;
  d.one_shot_with_motion_is_alarm = true;
  d.reversal_needs_stop = true;
  return d;
}

}  // namespace headstock::dialects::gsk

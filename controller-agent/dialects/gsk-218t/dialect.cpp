// GSK 218T lathe control.
#include "dialects/build.hpp"
#include "program/block.hpp"
#include "tables/gcodes_gsk_218t.hpp"

namespace headstock::dialects {

Dialect make_gsk_218t() {
  using program::letters;
  using R = AlarmReason;
  Dialect d;
  d.profile = "gsk-218t";
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
                   {R::g_same_group, "131"},
                   {R::g_one_shot_and_motion, "131"},
                   {R::too_many_m, "129"},
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
                   {R::no_start_point, "021"},
                   {R::offset_number, "030"},
                   {R::data_value, "043"},
                   {R::dwell_words, "168"},
                   {R::call_without_p, "076"},
                   {R::program_not_found, "078"},
                   {R::sequence_not_found, "078"},
                   {R::nesting, "077"},
                   {R::call_count, "163"}});
  add_g_codes(d, tables::gcodes_gsk_218t);
  for (bool& by_letter : d.incremental_letters) by_letter = true;
  d.m_rules = usual_m_rules();
  // No M01, M02 on this control (L805); output pairs M51…M70 go to the machine.
  std::erase_if(d.m_rules, [](const MRule& rule) { return rule.code == 1 || rule.code == 2; });
  d.m_rules.push_back({1, MAction::unavailable});
  d.m_rules.push_back({2, MAction::unavailable});
  d.numbers.decimal = Decimal::pocket;    // POD = 1
  d.numbers.most_increments = 9'999'999;  // ±9999.999 (L322)
  d.numbers.addresses = letters("FHIJKLPQRSTUWXZ");
  d.numbers.pointed = letters("FIJKPQRUWXZ");
  d.numbers.negative = letters("IKRUWXZ");
  d.arcs = {.tolerance_mm = 0.01, .negative_r = false, .r_and_center_is_alarm = true};
  d.threads = {.inch_word = true, .f_and_i_is_alarm = true, .lead_along_path = true};
  d.calls = {.nesting = 4, .l_repeats = false, .most_repeats = 999};
  d.tools = {.lathe = true, .offset_digits = 2, .sign = 1, .most_offsets = 64};
  d.repeated_words = Repeated::alarm;
  d.same_group = Repeated::alarm;
  d.one_shot_with_motion_is_alarm = true;
  d.both_forms = BothForms::alarm;
  d.longest_block = 255;
  d.setting_ignores_offset = true;  // E11: L1349
  add_gsk_218t_macros(d);
  return d;
}

}  // namespace headstock::dialects

// GSK 2000TB/TC. The manual prints few alarm numbers (34, 131); the others are those of the same family's
// 218T.
#include "dialects/build.hpp"
#include "program/block.hpp"
#include "tables/gcodes_gsk_2000tc.hpp"

namespace headstock::dialects {

Dialect make_gsk_2000tc() {
  using program::letters;
  using R = AlarmReason;
  Dialect d;
  d.profile = "gsk-2000tc";
  set_alarm_codes(d, "010",
                  {{R::no_address, "004"},
                   {R::no_data, "005"},
                   {R::minus_sign, "006"},
                   {R::decimal_point, "007"},
                   {R::too_many_digits, "012"},
                   {R::value_range, "130"},
                   {R::illegal_address, "009"},
                   {R::duplicate_word, "129"},
                   {R::block_too_long, "019"},
                   {R::slash_position, "009"},
                   {R::program_number, "074"},
                   {R::end_of_record, "142"},
                   {R::input_failed, "032"},
                   {R::expression, "115"},
                   {R::statement_unavailable, "081"},
                   {R::m_unavailable, "010"},
                   {R::too_many_m, "129"},
                   {R::illegal_m, "010"},
                   {R::feed_missing, "011"},
                   {R::arc_radius, "026"},
                   {R::arc_no_center, "028"},
                   {R::arc_negative_r, "023"},
                   {R::arc_r_too_small, "026"},
                   {R::arc_plane, "026"},
                   {R::thread_lead, "018"},
                   {R::no_start_point, "021"},
                   {R::offset_number, "030"},
                   {R::reference_number, "130"},
                   {R::dwell_words, "130"},
                   {R::call_without_p, "076"},
                   {R::program_not_found, "078"},
                   {R::sequence_not_found, "078"},
                   {R::nesting, "077"},
                   {R::call_count, "130"}});
  add_g_codes(d, tables::gcodes_gsk_2000tc);
  for (bool& by_letter : d.incremental_letters) by_letter = true;
  d.m_rules = usual_m_rules();
  for (const std::int32_t after : {11, 13, 33}) d.m_rules.push_back({after, MAction::machine_after});  // L940
  d.m_rules.push_back({29, MAction::unavailable});
  d.numbers.decimal = Decimal::pocket;  // all examples write millimetres without a point
  d.numbers.most_increments = 999'999'999;
  d.numbers.power_on_feed_mm_min = 300;  // P076
  d.numbers.addresses = letters("BCDFHIJKLPQRSTUVWXYZ");
  d.numbers.pointed = letters("BCDFIJKLPQRUVWXYZ");
  d.numbers.negative = letters("BCIJKRUVWXYZ");
  d.arcs = {.tolerance_mm = 0.01, .tolerance_parameter = "P154"};
  d.threads.inch_word = true;
  d.calls = {.nesting = 4, .l_repeats = true, .most_repeats = 9'999};  // E5
  d.tools = {.lathe = true, .offset_digits = 2, .sign = 1, .most_offsets = 32};
  d.corner_words = letters("LD");      // L2270
  d.repeated_words = Repeated::alarm;  // S177.7 = 1
  d.may_repeat = letters("STHL");
  d.one_shot_with_motion_is_alarm = true;   // L1716
  d.both_forms = BothForms::absolute_wins;  // L572
  d.end_of_text = EndOfText::end;
  d.reference_cancels_offset = true;  // L2500
  d.m99_main_counts_part = true;      // L7412
  d.linear_rapid_parameter = "S172.0";
  d.dwell_turns_parameter = "S212.7";
  add_gsk_2000tc_macros(d);
  return d;
}

}  // namespace headstock::dialects

// GSK 2000TB/TC. The manual prints few alarm numbers (34, 131); the others are those of the same family's
// 218T.
#include "dialects/build.hpp"
#include "dialects/gsk/family.hpp"
#include "dialects/gsk/h_codes.hpp"
#include "dialects/gsk/language.hpp"
#include "program/block.hpp"
#include "tables/gcodes_gsk_2000tc.hpp"

namespace headstock::dialects {

Dialect make_gsk_2000tc() {
  using program::letters;
  Dialect d = gsk::family();
  d.profile = "gsk-2000tc";
  d.set_alarm_code(AlarmReason::too_many_m, "135");  // L972
  static constexpr OwnHandler kOwn[] = {{"stroke_zone_on", Phase::action, gsk::stroke_zone_on},
                                        {"stroke_zone_off", Phase::action, gsk::stroke_zone_off},
                                        {"h_code", Phase::action, gsk::run_h_code_2000tc}};
  add_g_codes(d, tables::gcodes_gsk_2000tc, kOwn);
  for (const std::int32_t after : {11, 13, 33}) d.m_rules.push_back({after, MAction::machine_after});  // L940
  d.m_rules.push_back({29, MAction::rigid_tapping});
  d.m_rules.push_back({9'000, MAction::own, 9'999});
  d.make_own = [](interp::Executor&) {
    return gsk::make_language({"S001.4", {}, {}, {}, "S187.1", "S188.0", "S188.1"});
  };
  d.threads.runout = true;  // L4150
  d.threads.change_word = 'R';
  d.threads.first_lead_changed = true;  // E28: F3.8 R0.2 begins with 4.0
  d.repeated_alarm_parameter = "S177.7";
  d.modes.inch_parameter = "S001.0";
  d.modes.x_radius_parameter = "S001.2";
  d.modes.reference_parameters = {"X:P122 Z:P123", "X:P124 Z:P125", "X:P126 Z:P127"};
  d.modes.surface_letter_parameter = "P237";
  d.power_on_switches = {{"S174.6", {10, 10, 10}}};
  d.modes.compensation_group = 7;
  d.numbers.most_increments = 999'999'999;
  d.numbers.power_on_feed_mm_min = 300;  // P076
  d.numbers.addresses = letters("BCDFHIJKLPQRSTUVWXYZ");
  d.numbers.pointed = letters("BCDFIJKLPQRUVWXYZ");
  d.numbers.negative = letters("BCIJKRUVWXYZ");
  d.arcs.tolerance_parameter = "P154";
  d.arcs.largest_r = 999'999.9999;
  d.calls.l_repeats = true;  // E5
  d.calls.most_repeats = 9'999;
  d.tools.most_offsets = 32;
  d.tool_offsets.shift_parameter = "S003.4";
  d.tool_offsets.shift_default = 1;
  d.tool_offsets.radius_parameter = "S004.4";
  d.tool_offsets.moves_first = true;  // L1637
  d.corner_words = letters("LD");     // L2270
  d.may_repeat = letters("STHL");
  d.both_forms = BothForms::absolute_wins;  // L572
  d.end_of_text = EndOfText::end;
  d.reference_cancels_offset = true;  // L2500
  d.m99_main_counts_part = true;      // L7412
  // Only the bits are in the manual (L11946): the form is that of the family's other lathes (see README).
  d.life = {.form = ToolLifeRules::Form::turret,
            .enable_parameter = "S002.0",
            .most_groups = 32,
            .tools_in_group = 8,  // rows of the page (L7546)
            .every_use_parameter = "S002.2",
            .next_group_parameter = "S002.4"};
  d.linear_rapid_parameter = "S172.0";
  d.dwell_turns_parameter = "S212.7";
  add_gsk_2000tc_macros(d);
  return d;
}

}  // namespace headstock::dialects

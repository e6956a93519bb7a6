// GSK 218T lathe control.
#include "dialects/build.hpp"
#include "dialects/gsk/family.hpp"
#include "program/block.hpp"
#include "tables/gcodes_gsk_218t.hpp"

namespace headstock::dialects {

Dialect make_gsk_218t() {
  using program::letters;
  using R = AlarmReason;
  Dialect d = gsk::family();
  d.profile = "gsk-218t";
  for (const auto& [reason, code] : {std::pair{R::g_same_group, "131"},
                                     {R::g_one_shot_and_motion, "131"},
                                     {R::too_many_m, "129"},
                                     {R::dwell_words, "168"}})
    d.set_alarm_code(reason, code);
  add_g_codes(d, tables::gcodes_gsk_218t);
  // No M01, M02 on this control (L805); output pairs M51…M70 go to the machine.
  std::erase_if(d.m_rules, [](const MRule& rule) { return rule.code == 1 || rule.code == 2; });
  d.m_rules.push_back({1, MAction::unavailable});
  d.m_rules.push_back({2, MAction::unavailable});
  d.numbers.most_increments = 9'999'999;  // ±9999.999 (L322)
  d.numbers.addresses = letters("FHIJKLPQRSTUWXZ");
  d.numbers.pointed = letters("FIJKPQRUWXZ");
  d.numbers.negative = letters("IKRUWXZ");
  d.arcs.negative_r = false;
  d.arcs.r_and_center_is_alarm = true;
  d.threads.f_and_i_is_alarm = true;
  d.threads.lead_along_path = true;
  d.calls.most_repeats = 999;
  d.tools.most_offsets = 64;
  d.same_group = Repeated::alarm;
  d.both_forms = BothForms::alarm;
  d.longest_block = 255;
  d.setting_ignores_offset = true;  // E11: L1349
  add_gsk_218t_macros(d);
  return d;
}

}  // namespace headstock::dialects

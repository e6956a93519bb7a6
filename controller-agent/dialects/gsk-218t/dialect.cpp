// GSK 218T lathe control.
#include "dialects/build.hpp"
#include "dialects/gsk-218t/reference_return.hpp"
#include "dialects/gsk/family.hpp"
#include "dialects/gsk/h_codes.hpp"
#include "dialects/gsk/language.hpp"
#include "program/block.hpp"
#include "tables/gcodes_gsk_218t.hpp"

namespace headstock::dialects {

Dialect make_gsk_218t() {
  using program::letters;
  Dialect d = gsk::family();
  d.profile = "gsk-218t";
  for (const auto& [reason, code] : {std::pair{AlarmReason::g_same_group, "131"},
                                     {AlarmReason::g_one_shot_and_motion, "131"},
                                     {AlarmReason::too_many_m, "129"},
                                     {AlarmReason::dwell_words, "168"}})
    d.set_alarm_code(reason, code);
  static constexpr OwnHandler kOwn[] = {{"h_code", Phase::action, gsk::run_h_code_218t},
                                        {"reference_return_218t", Phase::action, gsk_218t::reference_return}};
  add_g_codes(d, tables::gcodes_gsk_218t, kOwn);
  // All other codes, M01 and M02 too (L805), are an alarm or call a sub-program.
  std::erase_if(d.m_rules, [](const MRule& rule) { return rule.code == 1 || rule.code == 2; });
  for (const MRule rule : {MRule{8, MAction::machine, 13},
                           {32, MAction::machine, 33},
                           {51, MAction::machine, 70},
                           {0, MAction::own, 99'999'999}})
    d.m_rules.push_back(rule);
  d.make_own = [](interp::Executor&) {
    return gsk::make_language({"P001.4", "P010.7", "P004.2", "P081", {}, {}, {}});
  };
  d.numbers.standard_when_clear_parameter = "P011.0";  // POD
  d.numbers.most_increments = 9'999'999;               // ±9999.999 (L322)
  d.numbers.addresses = letters("FHIJKLPQRSTUWXZ");
  d.numbers.pointed = letters("FIJKPQRUWXZ");
  d.numbers.negative = letters("IKRUWXZ");
  d.modes.inch_parameter = "P001.6";
  d.modes.x_radius_parameter = "P001.2";
  d.set_alarm_code(AlarmReason::computed_number, "146");
  d.set_alarm_code(AlarmReason::call_p_value, "162");
  d.arcs.negative_r = false;
  d.arcs.largest_r = 9'999.999;
  d.modes.largest_offset = 9'999.999;
  d.arcs.r_and_center_is_alarm = true;
  d.threads.f_and_i_is_alarm = true;
  d.threads.lead_along_path = true;
  d.calls.most_repeats = 999;
  d.tools.most_offsets = 64;
  d.tool_offsets.shift_parameter = "P002.0";
  d.tool_offsets.radius_parameter = "P002.5";
  d.tool_offsets.reset_clears = true;
  d.tool_offsets.reset_keeps_parameter = "P002.6";
  d.same_group = Repeated::alarm;
  d.both_forms = BothForms::alarm;
  d.longest_block = 255;
  d.setting_ignores_offset = true;  // E11: L1349
  add_gsk_218t_macros(d);
  return d;
}

}  // namespace headstock::dialects

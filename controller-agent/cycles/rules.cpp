#include "cycles/rules.hpp"

#include <initializer_list>
#include <utility>

#include "dialects/dialect.hpp"

namespace headstock::cycles {
namespace {

using F = Fault;
using Codes = std::initializer_list<std::pair<Fault, std::string_view>>;

constexpr std::int64_t kTips[] = {0, 29, 30, 55, 60, 80, -1};
constexpr std::int64_t kTips200[] = {0, 29, 30, 40, 55, 60, 80, -1};

void set_alarms(Rules& rules, std::string_view otherwise, Codes codes) {
  rules.alarms.fill(otherwise);
  for (const auto& [fault, code] : codes) rules.alarms[static_cast<std::size_t>(fault)] = code;
}

Rules fanuc_t() {
  Rules r;
  r.profile = "fanuc-0i-t";
  set_alarms(r, "PS0010",
             {{F::no_range, "PS0061"},
              {F::range_number, "PS0063"},
              {F::range_order, "PS0063"},
              {F::not_found, "PS0063"},
              {F::not_following, "PS0063"},
              {F::not_stored, "PS0067"},
              {F::too_long, "PS0066"},
              {F::first_block, "PS0065"},
              {F::first_block_axis, "PS0323"},
              {F::last_block, "PS0069"},
              {F::last_open, "PS0326"},
              {F::modal_state, "PS0327"},
              {F::radius_side, "PS0328"},
              {F::forbidden, "PS0066"},
              {F::forbidden_call, "PS0325"},
              {F::not_monotonic_along, "PS0064"},
              {F::not_monotonic_across, "PS0329"},
              {F::above_start, "PS0322"},
              {F::wrong_plane, "PS0021"},
              {F::depth, "PS0062"},
              {F::passes, "PS0321"},
              {F::value, "PS0062"},
              {F::peck, "PS0320"},
              {F::peck_step, "PS0319"},
              {F::peck_relief, "PS0318"},
              {F::taper, "PS0062"},
              {F::box_axis, "PS0330"},
              {F::thread_lead, "PS0011"},
              {F::thread_height, "PS0317"},
              {F::thread_first_depth, "PS0317"},
              {F::thread_depths, "PS0316"},
              {F::thread_angle, "PS0315"},
              {F::thread_finish, "PS0062"},
              {F::thread_clear, "PS0062"},
              {F::hole_axis, "PS1196"},
              {F::thread_in_vain, "PS0062"},
              {F::hole_depth, "PS0062"},
              {F::hole_peck, "PS0045"},
              {F::rigid_speed, "PS0200"},
              {F::rigid_feed, "PS0201"},
              {F::rigid_program, "PS0203"},
              {F::rigid_move, "PS0204"},
              {F::rigid_distance, "PS0207"}});
  r.parameters = {.depth = "5132",
                  .retract = "5133",
                  .relief_across = "5135",
                  .relief_along = "5136",
                  .passes = "5137",
                  .peck_retract = "5139",
                  .peck_full_retract = {},
                  .runout = "5130",
                  .runout_angle = "5131",
                  .finish_passes = "5142",
                  .tip_angle = "5143",
                  .least_depth = "5140",
                  .finish_allowance = "5141",
                  .thread_start = {},
                  .thread_method = {},
                  .tolerance_along = "5145",
                  .tolerance_across = "5146",
                  .no_contour_1 = "5105#1",
                  .no_contour_2 = "5105#2",
                  .peck_clearance = "5115",
                  .peck_back = "5114"};
  r.shapes = Shapes::by_first_block;
  r.return_by_allowance = true;
  r.radius_in_roughing = true;  // K.49
  r.one_block_form = true;
  r.one_block_parameter = "0001#1";
  r.tip_angles = kTips;
  r.holes = HoleFamily::turning;
  r.r_from_initial = true;
  r.angle_word = true;
  return r;
}

Rules gsk_2000tc() {
  Rules r;
  r.profile = "gsk-2000tc";
  set_alarms(r, "130",
             {{F::no_range, "063"},
              {F::range_number, "063"},
              {F::range_order, "063"},
              {F::not_found, "063"},
              {F::not_following, "063"},
              {F::not_stored, "063"},
              {F::too_long, "066"},
              {F::first_block, "065"},
              {F::first_block_axis, "065"},
              {F::last_block, "066"},
              {F::forbidden, "066"},
              {F::forbidden_call, "066"},
              {F::not_monotonic_along, "150"},
              {F::not_monotonic_across, "150"},
              {F::above_start, "150"},
              {F::thread_lead, "018"},
              {F::thread_height, "052"},
              {F::thread_first_depth, "056"},
              {F::peck, "144"},
              {F::peck_step, "144"},
              {F::tap_lead, "020"},
              {F::last_open, "066"},
              {F::tap_word, "010"}});
  r.parameters = {.depth = "P051",
                  .retract = "P052",
                  .relief_across = "P053",
                  .relief_along = "P054",
                  .passes = "P055",
                  .peck_retract = "P056",
                  .peck_full_retract = {},
                  .runout = "P019",
                  .runout_angle = {},
                  .finish_passes = "P057",
                  .tip_angle = "P058",
                  .least_depth = "P059",
                  .finish_allowance = "P060",
                  .thread_start = {},
                  .thread_method = {},
                  .tolerance_along = {},
                  .tolerance_across = {},
                  .no_contour_1 = {},
                  .no_contour_2 = {},
                  .peck_clearance = {},
                  .peck_back = {}};
  r.stops = Stops::traverses;  // L3130
  r.refused_in_mdi = true;     // 193
  r.radius_in_boxes = true;
  r.tip_in_boxes = false;  // L6036
  r.check = Check::by_k_word;
  r.rigid_tap_parameter = "S213.0";
  r.level_cut_at_start = false;
  r.must_follow = true;
  r.least_passes = 2;
  r.one_shot_in_profile = true;
  r.peck_across_diameter = true;
  r.runout_default = 5;
  r.starts_word = true;
  r.runout_form = RunoutForm::lengths;
  r.peck_needed = true;
  r.least_from_root = true;
  return r;
}

Rules gsk_218t() {
  Rules r = gsk_2000tc();
  r.profile = "gsk-218t";
  r.most_sequence = 9'999;
  set_alarms(r, "145",
             {{F::no_range, "053"},
              {F::range_number, "166"},
              {F::range_order, "158"},
              {F::not_found, "063"},
              {F::not_following, "156"},
              {F::not_stored, "156"},
              {F::too_long, "137"},
              {F::first_block, "065"},
              {F::first_block_axis, "065"},
              {F::last_block, "066"},
              {F::forbidden, "066"},
              {F::forbidden_call, "067"},
              {F::not_monotonic_along, "150"},
              {F::not_monotonic_across, "150"},
              {F::above_start, "151"},
              {F::depth, "062"},
              {F::passes, "062"},
              {F::peck, "054"},
              {F::peck_step, "054"},
              {F::tap_lead, "020"},
              {F::thread_finish, "055"},
              {F::thread_clear, "144"},
              {F::last_open, "066"},
              {F::taper, "152"},
              {F::thread_lead, "153"},
              {F::thread_height, "052"},
              {F::thread_first_depth, "052"},
              {F::thread_depths, "051"},
              {F::thread_angle, "050"},
              {F::thread_in_vain, "144"},
              {F::tap_word, "010"}});
  r.parameters.depth = "P071";
  r.parameters.retract = "P072";
  r.parameters.relief_across = "P073";
  r.parameters.relief_along = "P074";
  r.parameters.passes = "P075";
  r.parameters.peck_retract = "P076";
  r.parameters.finish_passes = "P077";
  r.parameters.tip_angle = "P078";
  r.parameters.least_depth = "P079";
  r.parameters.finish_allowance = "P080";
  r.parameters.runout = "P068";
  r.stops = Stops::passes;
  r.tip_in_boxes = true;
  r.check = Check::always;
  r.rigid_tap_parameter = {};
  r.level_cut_at_start = true;
  r.least_passes = 1;
  r.most_blocks = 30;
  r.peck_unit_mm = 0;
  r.depth_unit_mm = 0;
  r.tip_angles = kTips;
  r.half_runout_is_45 = true;
  r.least_from_root = false;
  return r;
}

Rules k2000tc() {
  Rules r;
  r.profile = "k2000tc";
  set_alarms(r, "PS1204",
             {{F::no_range, "PS0004"},
              {F::range_number, "PS1202"},
              {F::range_order, "PS1202"},
              {F::not_found, "PS0128"},
              {F::not_following, "PS0128"},
              {F::not_stored, "PS0128"},
              {F::too_long, "PS1204"},
              {F::first_block, "PS0065"},
              {F::first_block_axis, "PS0065"},
              {F::last_block, "PS0051"},
              {F::forbidden, "PS0065"},
              {F::forbidden_call, "PS0065"},
              {F::not_monotonic_along, "PS0381"},
              {F::not_monotonic_across, "PS0381"},
              {F::above_start, "PS0381"},
              {F::wrong_plane, "PS0391"},
              {F::thread_lead, "PS0014"},
              {F::thread_height, "PS0259"},
              {F::thread_first_depth, "PS0259"},
              {F::thread_depths, "PS0259"},
              {F::thread_clear, "PS9002"},
              {F::tap_lead, "PS0014"},
              {F::tap_block, "PS0012"},
              {F::last_open, "PS0051"},
              {F::hole_k, "PS0195"},
              {F::rigid_speed, "PS0011"},
              {F::rigid_feed, "PS0011"},
              {F::rigid_distance, "PS0187"}});
  r.parameters = {.depth = "P3312",
                  .retract = "P3313",
                  .relief_across = "P3314",
                  .relief_along = "P3315",
                  .passes = "P3316",
                  .peck_retract = "P3317",
                  .peck_full_retract = "P3300.2",
                  .runout = {},
                  .runout_angle = {},
                  .finish_passes = "P3320",
                  .tip_angle = "P3321",
                  .least_depth = "P3318",
                  .finish_allowance = "P3319",
                  .thread_start = "P3323",
                  .thread_method = "P3322",
                  .thread_arc_in = "P3324",
                  .thread_arc_out = "P3325",
                  .tolerance_along = {},
                  .tolerance_across = {},
                  .no_contour_1 = {},
                  .no_contour_2 = {},
                  .peck_clearance = "P3311",
                  .peck_back = "P3310"};
  r.shapes = Shapes::pockets;
  r.check = Check::unless_parameter;
  r.check_off_parameter = "P3301.5";
  r.holes = HoleFamily::k2000;
  r.driven_m = 13;          // L8499
  r.taps_down_only = true;  // L12106
  r.r_as_axis = true;
  r.contour_pass = false;  // L13389: the contour has been followed on the way
  r.contour_out_parameter = "P3301.7";
  r.angle_word = true;
  r.starts_word = true;
  r.starts_parameter = "P6300.6";
  r.runout_form = RunoutForm::width;
  r.runout_width_parameter = "P6300.7";
  r.runout_default = 10;
  return r;
}

Rules lathe_200t() {
  Rules r;
  r.profile = "lathe-200t";
  set_alarms(
      r, "A23",
      {{F::thread_lead, "A19"}, {F::tap_lead, "A19"}, {F::thread_in_vain, "A19"}, {F::thread_clear, "A19"}});
  // No numbered parameters: the values of G76's first block are kept under names of ours.
  r.parameters.finish_passes = "G76.m";
  r.parameters.tip_angle = "G76.a";
  r.parameters.least_depth = "G76.Q";
  r.parameters.finish_allowance = "G76.R";
  r.depth_unit_mm = 0;
  r.peck_unit_mm = 0;
  r.holes = HoleFamily::lathe_200t;
  r.starts_word = true;
  r.runout_form = RunoutForm::position;
  r.steps_from_last_end = true;
  r.tip_angles = kTips200;
  r.infer_angle_60 = true;
  return r;
}

Rules fanuc_m() {
  Rules r = fanuc_t();
  r.profile = "fanuc-0i-m";
  r.holes = HoleFamily::mill;
  for (const Fault lathe_only : {F::value, F::hole_depth})  // PS0062 is none of the M series
    r.alarms[static_cast<std::size_t>(lathe_only)] = "PS0010";
  r.r_from_initial = false;
  return r;
}

}  // namespace

const Rules& rules_of(const dialects::Dialect& dialect) {
  static const std::array<Rules, 6> all = {fanuc_t(),  fanuc_m(), gsk_2000tc(),
                                           gsk_218t(), k2000tc(), lathe_200t()};
  for (const Rules& rules : all) {
    if (rules.profile == dialect.profile) return rules;
  }
  return all[0];
}

}  // namespace headstock::cycles

// Chamfers, drawing dimensions and radius compensation of the six profiles, side by side: what differs
// between them is easier to see in one place than in six. 200T has none of it (digest 16).
#include <string_view>
#include <utility>
#include <vector>

#include "dialects/build.hpp"
#include "program/block.hpp"

namespace headstock::dialects {
namespace {

using comp::CompensationRules;
using comp::CornerRules;
using program::letters;
using R = AlarmReason;
using Codes = std::vector<std::pair<AlarmReason, std::string_view>>;

const Codes kFanucCodes = {{R::corner_words, "PS0053"},
                           {R::corner_thread, "PS0050"},
                           {R::corner_no_move, "PS0051"},
                           {R::corner_not_feed, "PS0052"},
                           {R::corner_taper, "PS0054"},
                           {R::corner_axis, "PS0306"},
                           {R::corner_too_large, "PS0055"},
                           {R::corner_comma, "PS0312"},
                           {R::corner_profile_end, "PS0069"},
                           {R::corner_unavailable, "PS0010"},
                           {R::drawing_no_end, "PS0056"},
                           {R::drawing_no_solution, "PS0057"},
                           {R::drawing_parallel, "PS0058"},
                           {R::drawing_blocks, "PS0312"},
                           {R::drawing_incremental, "PS0312"},
                           {R::compensation_no_crossing, "PS0033"},
                           {R::compensation_start_arc, "PS0034"},
                           {R::compensation_side, "PS0033"},
                           {R::compensation_number, "PS0030"},
                           {R::compensation_plane, "PS0037"},
                           {R::compensation_arc_centre, "PS0038"},
                           {R::compensation_overcut, "PS0041"},
                           {R::compensation_corner, "PS0039"},
                           {R::compensation_interference, "PS0041"},
                           {R::compensation_quiet_blocks, "PS0041"},
                           {R::compensation_refused, "PS0010"},
                           {R::compensation_call, "PS0010"},
                           {R::rigid_tap_move, "PS0204"},
                           {R::rigid_tap_plane, "PS0206"},
                           {R::offset_value, "PS0029"},
                           {R::corner_arc_with_move, "PS5445"}};

// The M series has chamfers at any angle only: its numbers for a wrong next block are one (0i-D K.53).
const Codes kFanucMillCodes = {{R::normal_direction, "PS1470"},    {R::normal_direction_axis, "PS0009"},
                               {R::corner_not_feed, "PS0051"},     {R::corner_words, "PS0010"},
                               {R::corner_taper, "PS0051"},        {R::corner_profile_end, "PS0051"},
                               {R::corner_axis, "PS0051"},         {R::corner_comma, "PS0010"},
                               {R::drawing_no_end, "PS0010"},      {R::drawing_no_solution, "PS0010"},
                               {R::drawing_parallel, "PS0010"},    {R::drawing_blocks, "PS0010"},
                               {R::drawing_incremental, "PS0010"}, {R::compensation_corner, "PS0041"}};

const Codes kGskCodes = {{R::compensation_no_crossing, "033"},  {R::compensation_start_arc, "034"},
                         {R::compensation_arc_centre, "038"},   {R::compensation_overcut, "041"},
                         {R::compensation_interference, "041"}, {R::compensation_quiet_blocks, "041"}};

const Codes kGsk218tCodes = {{R::compensation_side, "035"},
                             {R::compensation_number, "036"},
                             {R::compensation_quiet_blocks, "039"},
                             {R::compensation_refused, "064"},
                             {R::compensation_call, "149"},
                             {R::compensation_plane, "040"},
                             {R::compensation_corner, "040"},
                             {R::compensation_arc_again, "042"},
                             {R::two_cycles, "133"},
                             {R::call_with_cycle, "165"},
                             {R::offset_value, "029"}};

const Codes kGsk2000tcCodes = {{R::corner_too_large, "192"},     {R::corner_no_move, "191"},
                               {R::corner_not_feed, "191"},      {R::corner_chamfer_size, "190"},
                               {R::corner_short_line, "191"},    {R::compensation_interference, "197"},
                               {R::compensation_groove, "198"},  {R::compensation_arc_end, "199"},
                               {R::compensation_refused, "131"}, {R::compensation_call, "149"},
                               {R::compensation_plane, "131"},   {R::compensation_corner, "131"},
                               {R::rigid_tap_move, "195"},       {R::rigid_tap_again, "196"},
                               {R::rigid_tap_axis, "194"},       {R::mdi_cycle, "193"}};

const Codes kK2000Codes = {{R::corner_words, "PS9003"},
                           {R::corner_thread, "PS0052"},
                           {R::corner_no_move, "PS0052"},
                           {R::corner_not_feed, "PS0052"},
                           {R::corner_taper, "PS0052"},
                           {R::corner_axis, "PS0052"},
                           {R::corner_too_large, "PS0055"},
                           {R::corner_comma, "PS0052"},
                           {R::corner_profile_end, "PS0051"},
                           {R::corner_unavailable, "PS1205"},
                           {R::drawing_no_end, "PS0426"},
                           {R::drawing_no_solution, "PS0425"},
                           {R::drawing_parallel, "PS0428"},
                           {R::drawing_blocks, "PS0426"},
                           {R::drawing_incremental, "PS0427"},
                           {R::compensation_no_crossing, "PS0033"},
                           {R::compensation_start_arc, "PS0034"},
                           {R::compensation_side, "PS0033"},
                           {R::compensation_number, "PS0033"},
                           {R::compensation_plane, "PS0040"},
                           {R::compensation_arc_centre, "PS0038"},
                           {R::compensation_overcut, "PS9008"},
                           {R::compensation_groove, "PS9008"},
                           {R::compensation_corner, "PS0297"},
                           {R::measure_no_length, "PS0237"},
                           {R::arc_r_too_small, "PS9001"},
                           {R::compensation_interference, "PS0041"},
                           {R::compensation_quiet_blocks, "PS0041"},
                           {R::compensation_refused, "PS0048"},
                           {R::compensation_call, "PS0036"},
                           {R::corner_arc_with_move, "PS9004"},
                           {R::drawing_unit, "PS0429"},
                           {R::drawing_polar, "PS0430"},
                           {R::drawing_mirror, "PS0431"},
                           {R::drawing_plane, "PS0432"}};

// Reasons that only some controls have a number of their own for: the others print that of the second.
constexpr std::pair<R, R> kFiner[] = {
    {R::measure_no_length, R::measure_axis},
    {R::offset_value, R::offset_number},
    {R::corner_chamfer_size, R::corner_too_large},
    {R::corner_short_line, R::corner_too_large},
    {R::compensation_groove, R::compensation_interference},
    {R::compensation_arc_end, R::arc_radius},
    {R::compensation_arc_again, R::compensation_start_arc},
    {R::call_with_cycle, R::compensation_call},
    {R::rigid_tap_axis, R::rigid_tap_again},
    {R::rigid_tap_plane, R::rigid_tap_again},
    {R::two_cycles, R::g_same_group},
    {R::normal_direction_axis, R::illegal_address},
    {R::drawing_unit, R::drawing_blocks},
    {R::drawing_polar, R::drawing_blocks},
    {R::drawing_mirror, R::drawing_blocks},
    {R::drawing_plane, R::drawing_blocks},
};

struct PathRules {
  std::string_view profile;
  CornerRules corners;
  CompensationRules compensation;
  std::uint32_t corner_words = 0;
  std::vector<const Codes*> codes;
};

std::vector<PathRules> make_table() {
  std::vector<PathRules> table;
  {
    PathRules r;
    r.profile = "fanuc-0i-t";
    r.corners.comma_letters = letters("ACR");
    r.corners.bare_parameter = "3405#4";  // CCR
    r.corners.perpendicular_words = true;
    r.corner_words = letters("IJKRCA");
    r.compensation.vector_words = comp::VectorWords::cancel;
    r.compensation.off_parameter = "8136#7";        // NCR
    r.compensation.mdi_alarm_parameter = "5008#4";  // MCR
    r.compensation.type_b_parameter = "5003#0";
    r.compensation.type_c_parameter = "5003#1";     // SUV
    r.compensation.avoid_parameter = "19607#5";     // CAV
    r.compensation.no_check_parameter = "5008#3";   // CNV
    r.compensation.arcs_only_parameter = "5008#1";  // CNC
    r.compensation.stop_parameter = "5000#0";       // SBK
    r.corners.stop_parameter = "5105#0";            // SBC
    r.compensation.start_by_normal = true;
    r.compensation.circular_parameter = "19607#2";
    r.compensation.read_ahead_parameter = "19625";
    r.compensation.again_is_perpendicular = true;
    r.compensation.keeps_to_intermediate = true;  // K.45: always CCN = 1
    r.codes = {&kFanucCodes};
    table.push_back(r);

    r.profile = "fanuc-0i-m";
    r.corners = {};
    r.corners.comma_letters = letters("CR");
    r.corners.stop_parameter = "5105#0";  // SBC
    r.corners.arcs = true;
    r.corner_words = letters("IJK");
    r.compensation.vector_words = comp::VectorWords::all;
    r.compensation.by_d = true;
    r.compensation.off_parameter = {};
    r.compensation.diameter_parameter = "5004#2";  // ODI
    r.codes = {&kFanucCodes, &kFanucMillCodes};
    table.push_back(r);
  }
  {
    PathRules r;
    r.profile = "gsk-2000tc";
    r.corners.chamfer_word = 'L';
    r.corners.round_word = 'D';
    r.corners.chamfer_size = comp::ChamferSize::own_length;
    r.corners.ignored_above_mm = 1'000;
    r.corners.arcs = true;
    r.corner_words = letters("LD");
    r.compensation.enable_parameter = "S002.1";
    r.compensation.type_b_parameter = "S172.3";
    r.compensation.check_parameter = "S207.0";
    r.compensation.to_intermediate_parameter = "S172.4";  // CCN
    r.compensation.tips_in_all_planes = false;
    r.compensation.threads_refused = true;
    r.compensation.calls_refused = true;  // L6020 ff.
    r.codes = {&kGskCodes, &kGsk2000tcCodes};
    table.push_back(r);
  }
  {
    PathRules r;
    r.profile = "gsk-218t";
    r.compensation.enable_parameter = "P002.3";  // CCMP
    r.compensation.zero_number_is_alarm = true;
    r.compensation.side_change_after_start_is_alarm = true;
    r.compensation.most_quiet_blocks = 30;
    r.compensation.calls_refused = true;
    r.codes = {&kGskCodes, &kGsk218tCodes};
    table.push_back(r);
  }
  {
    PathRules r;
    r.profile = "k2000tc";
    r.corners.comma_letters = letters("ACR");
    r.corners.comma_parameter = "P2500.2";  // CENCW
    r.corners.named_letters = letters("ACR");
    r.corners.enable_parameter = "P0003.3";  // CCR
    r.corners.angle_parameter = "P0003.7";   // ANGPM
    r.corners.chamfer_ijk_parameter = "P2501.0";
    r.corners.round_r_parameter = "P2501.1";
    r.corners.arcs = true;
    r.corners.parallel_deg = 1;
    r.corner_words = letters("IJKRCA");
    r.compensation.vector_words = comp::VectorWords::cancel;
    r.compensation.enable_parameter = "P0002.1";  // CRC
    r.compensation.start = comp::StartType::b;
    r.compensation.near_parameter = "P3210";
    r.compensation.calls_refused = true;  // L16047
    r.compensation.again_is_perpendicular = true;
    r.codes = {&kK2000Codes};
    table.push_back(r);
  }
  return table;
}

}  // namespace

void set_path_rules(Dialect& dialect) {
  static const std::vector<PathRules> table = make_table();
  for (const PathRules& row : table) {
    if (row.profile != dialect.profile) continue;
    dialect.corners = row.corners;
    dialect.compensation = row.compensation;
    dialect.corner_words = row.corner_words;
    for (const Codes* codes : row.codes) {
      for (const auto& [reason, code] : *codes) dialect.set_alarm_code(reason, code);
    }
    for (const auto& [fine, coarse] : kFiner) {
      bool own = false;
      for (const Codes* codes : row.codes) {
        for (const auto& code : *codes) own = own || code.first == fine;
      }
      if (!own) dialect.set_alarm_code(fine, dialect.alarm_code(coarse));
    }
  }
}

}  // namespace headstock::dialects

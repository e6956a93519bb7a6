#include "interpreter/handlers.hpp"

#include <algorithm>

#include "interpreter/executor.hpp"

namespace headstock::interp::handlers {

namespace {

bool rapid(Executor& ex) {
  return ex.rapid();
}
bool feed(Executor& ex) {
  return ex.feed();
}
bool arc_cw(Executor& ex) {
  return ex.arc(Turn::cw);
}
bool arc_ccw(Executor& ex) {
  return ex.arc(Turn::ccw);
}

template <Plane plane>
bool select_plane(Executor& ex) {
  if (plane != ex.plane && (ex.cycle.rigid_next || ex.cycle.hole.rigid))
    return ex.alarm(AlarmReason::rigid_tap_plane, ex.code_column, std::string(ex.code->name));
  return ex.one_axis_a_role() && (ex.select_plane(plane), true);
}

template <bool inch>
bool unit(Executor& ex) {
  return select_unit(ex, inch);
}

template <bool incremental>
bool select_distance(Executor& ex) {
  ex.incremental = incremental;
  return true;
}

template <FeedUnit unit>
bool select_feed(Executor& ex) {
  if (ex.feed_unit != unit) ex.feed_mm = -1;  // F must be commanded again in the new unit
  ex.feed_unit = unit;
  ex.modal.per_revolution = unit == FeedUnit::mm_per_revolution;
  return true;
}

template <CuttingMode mode>
bool cutting_mode(Executor& ex) {
  ex.exact_stop_mode = mode == CuttingMode::exact_stop;
  ex.cutting_mode = mode;
  return true;
}

// G10 on a control that has nothing but tool life to put in.
bool tool_life_input(Executor& ex) {
  const std::int64_t l = ex.block.has('L') ? ex.whole('L', AlarmReason::data_input) : 0;
  if (l < 0) return false;
  return l == 3 ? tool_life::input(ex) : ex.alarm(AlarmReason::g_unavailable, ex.code_column, "G10");
}

// G65 P and G66 P are taken before the block's words are looked at (macro_call.cpp). What comes here is a
// form of G65 that is no call: the pattern screens of G65 H90-H94.
bool macro_call(Executor& ex) {
  return ex.alarm(AlarmReason::g_unavailable, ex.code_column, std::string(ex.code->name));
}

constexpr Named kHandlers[] = {
    {"macro_call", Phase::action, macro_call},
    {"macro_cancel", Phase::setting, nullptr},
    {"rapid", Phase::motion, rapid},
    {"feed", Phase::motion, feed},
    {"arc_cw", Phase::motion, arc_cw},
    {"arc_ccw", Phase::motion, arc_ccw},
    {"thread", Phase::motion, thread},
    {"thread_variable", Phase::motion, thread_variable},
    {"mode", Phase::setting, nullptr},
    {"plane_xy", Phase::setting, select_plane<Plane::xy>},
    {"plane_zx", Phase::setting, select_plane<Plane::zx>},
    {"plane_yz", Phase::setting, select_plane<Plane::yz>},
    {"inch", Phase::setting, unit<true>},
    {"metric", Phase::setting, unit<false>},
    {"absolute", Phase::setting, select_distance<false>},
    {"incremental", Phase::setting, select_distance<true>},
    {"feed_per_minute", Phase::setting, select_feed<FeedUnit::mm_per_minute>},
    {"feed_per_revolution", Phase::setting, select_feed<FeedUnit::mm_per_revolution>},
    {"feed_inverse_time", Phase::setting, select_feed<FeedUnit::inverse_time>},
    {"surface_speed", Phase::setting, surface_speed_on},
    {"spindle_speed", Phase::setting, surface_speed_off},
    {"normal_direction_on", Phase::setting, normal_direction_on},
    {"normal_direction_off", Phase::setting, normal_direction_off},
    {"exact_stop_mode", Phase::setting, cutting_mode<CuttingMode::exact_stop>},
    {"cutting_mode", Phase::setting, cutting_mode<CuttingMode::cutting>},
    {"corner_override_mode", Phase::setting, cutting_mode<CuttingMode::corner_override>},
    {"tapping_mode", Phase::setting, cutting_mode<CuttingMode::tapping>},
    {"length_offset", Phase::setting, length_offset},
    {"work_select", Phase::setting, work_select},
    {"compensation_cancel", Phase::setting, compensation_cancel},
    {"compensation_left", Phase::setting, compensation_left},
    {"compensation_right", Phase::setting, compensation_right},
    {"corner_arc", Phase::action, corner_arc},
    {"exact_stop", Phase::modifier, nullptr},
    {"dwell", Phase::action, dwell},
    {"data_input", Phase::action, data_input},
    {"tool_life_input", Phase::action, tool_life_input},
    {"data_input_end", Phase::action, data_input_end},
    {"skip", Phase::action, skip},
    {"measure", Phase::action, measure},
    {"tool_step", Phase::action, tool_step},
    {"mirror_on", Phase::action, mirror_on},
    {"mirror_off", Phase::action, mirror_off},
    {"scaling_on", Phase::action, scaling_on},
    {"scaling_off", Phase::setting, scaling_off},
    {"rotation_on", Phase::action, rotation_on},
    {"rotation_off", Phase::setting, rotation_off},
    {"polar_on", Phase::setting, polar_on},
    {"polar_off", Phase::setting, polar_off},
    {"stroke_check_on", Phase::action, stroke_check_on},
    {"stroke_check_off", Phase::action, stroke_check_off},
    {"spindle_watch_on", Phase::action, spindle_watch_on},
    {"spindle_watch_off", Phase::action, spindle_watch_off},
    {"contour_by_q", Phase::action, contour_by_q},
    {"contour_by_p", Phase::action, contour_by_p},
    {"increment_limit", Phase::action, increment_limit},
    {"single_direction", Phase::action, single_direction},
    {"cylinder", Phase::action, cylinder},
    {"polygon_on", Phase::action, polygon_on},
    {"polygon_off", Phase::action, polygon_off},
    {"servo_mode", Phase::action, servo_mode},
    {"polar_interpolation_on", Phase::action, polar_interpolation_on},
    {"polar_interpolation_off", Phase::setting, polar_interpolation_off},
    {"reference_check", Phase::action, reference_check},
    {"reference_return", Phase::action, reference_return},
    {"reference_return_n", Phase::action, reference_return_n},
    {"reference_from", Phase::action, reference_from},
    {"set_coordinates", Phase::action, set_coordinates},
    {"preset_coordinates", Phase::action, preset_coordinates},
    {"local", Phase::action, local},
    {"machine_move", Phase::action, machine_move},
};

}  // namespace

// G43/G44 H, G49: tool length, by moving the zero point; an axis without a word moves by the change.
bool length_offset(Executor& ex) {
  const std::int32_t tenths = ex.code->tenths;
  return tool_offset::take_length(ex, tenths == 430 ? 1 : tenths == 440 ? -1 : 0);
}

bool thread(Executor& ex) {
  return ex.thread(false);
}
bool thread_variable(Executor& ex) {
  return ex.thread(true);
}

const Named* find(std::string_view name) {
  const auto* found = std::find_if(std::begin(kHandlers), std::end(kHandlers),
                                   [name](const Named& named) { return named.name == name; });
  return found == std::end(kHandlers) ? nullptr : found;
}

}  // namespace headstock::interp::handlers

#include <fmt/format.h>

#include "machine/machine.hpp"

namespace headstock::machine {
namespace {

std::string toml_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string points_to_toml(std::string_view key, const std::vector<PitchError>& points) {
  if (points.empty()) return {};
  std::string out = fmt::format("{} = [\n", key);
  for (const PitchError& point : points)
    out += fmt::format("  [{}, {}],\n", point.position_mm, point.error_um);
  return out + "]\n";
}

std::string letter_to_toml(std::string_view key, char axis) {
  return axis == 0 ? std::string() : fmt::format("{} = \"{}\"\n", key, axis);
}

std::string axis_to_toml(const Axis& axis) {
  // {} prints the shortest digits that read back as the same double.
  std::string out = fmt::format(
      "\n[axis.{}]\n"
      "rotary = {}\n"
      "designation = {}\n"
      "rapid_mm_min = {}\n"
      "max_feed_mm_min = {}\n"
      "max_acceleration_mm_s2 = {}\n"
      "max_jerk_mm_s3 = {}\n"
      "min_mm = {}\n"
      "max_mm = {}\n"
      "reference_mm = {}\n"
      "backlash_um = {}\n",
      axis.name, axis.rotary, toml_string(axis.designation == Designation::diameter ? "diameter" : "radius"),
      axis.rapid_mm_min, axis.max_feed_mm_min, axis.max_acceleration_mm_s2, axis.max_jerk_mm_s3, axis.min_mm,
      axis.max_mm, axis.reference_mm, axis.backlash_um);
  out += fmt::format(
      "emergency_deceleration_mm_s2 = {}\nhoming = {}\ndog_mm = {}\ndog_width_mm = {}\ngrid_mm = {}\n"
      "home_negative = {}\ncreep_mm_min = {}\nin_position_um = {}\nfollowing_error_mm = {}\n"
      "following_error_stopped_mm = {}\nposition_gain_per_s = {}\ntorque_reserve = {}\nfriction_mm_s2 = {}\n"
      "inertia_ratio = {}\nencoder_um = {}\ngear_numerator = {}\ngear_denominator = {}\n"
      "synchronous_error_mm = {}\ninclined_deg = {}\nplc = {}\n",
      axis.emergency_deceleration_mm_s2, toml_string(axis.homing == Homing::dog ? "dog" : "absolute"),
      axis.dog_mm, axis.dog_width_mm, axis.grid_mm, axis.home_negative, axis.creep_mm_min,
      axis.in_position_um, axis.following_error_mm, axis.following_error_stopped_mm, axis.position_gain_per_s,
      axis.torque_reserve, axis.friction_mm_s2, axis.inertia_ratio, axis.encoder_um, axis.gear_numerator,
      axis.gear_denominator, axis.synchronous_error_mm, axis.inclined_deg, axis.plc);
  out += letter_to_toml("follows", axis.follows) + letter_to_toml("inclined_to", axis.inclined_to);
  out += points_to_toml("pitch_error", axis.pitch_error);
  return out + points_to_toml("pitch_error_negative", axis.pitch_error_negative);
}

}  // namespace

std::string to_toml(const Machine& machine) {
  std::string out = fmt::format(
      "[machine]\nname = {}\nprofile = {}\nkind = {}\nperiod_us = {}\nsecond_auxiliary = {}\nskip_input = "
      "{}\ninterruption_input = {}\n"
      "{}\n[path]\ntolerance_mm = {}\ntolerance_deg = {}\n",
      toml_string(machine.name), toml_string(machine.profile),
      toml_string(machine.kind == Kind::mill ? "mill" : "lathe"), machine.period_us, machine.second_auxiliary,
      machine.skip_input, machine.interruption_input, letter_to_toml("polygon_axis", machine.polygon_axis), machine.tolerance_mm,
      machine.tolerance_deg);
  for (const Axis& axis : machine.axes) out += axis_to_toml(axis);
  out += fmt::format(
      "\n[spindle]\nmax_rpm = {}\nmin_rpm = {}\nacceleration_rpm_s = {}\nencoder_lines = {}\n"
      "tap_rpm = {}\ntap_acceleration_rpm_s = {}\nposition_error_deg = {}\norient_m = {}\norient_deg = {}\n"
      "orient_rpm = {}\ncontour_on_m = {}\ncontour_off_m = {}\n{}"
      "\n[drive]\ntype = {}\n"
      "\n[memory]\nprograms_kb = {}\n",
      machine.spindle.max_rpm, machine.spindle.min_rpm, machine.spindle.acceleration_rpm_s,
      machine.spindle.encoder_lines, machine.spindle.tap_rpm, machine.spindle.tap_acceleration_rpm_s,
      machine.spindle.position_error_deg, machine.spindle.orient_m, machine.spindle.orient_deg,
      machine.spindle.orient_rpm, machine.spindle.contour_on_m, machine.spindle.contour_off_m,
      letter_to_toml("contour_axis", machine.spindle.contour_axis), toml_string(machine.drive),
      machine.program_memory_bytes / 1024);
  return out;
}

}  // namespace headstock::machine

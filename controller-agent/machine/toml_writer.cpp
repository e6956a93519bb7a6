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
  if (axis.pitch_error.empty()) return out;
  out += "pitch_error = [\n";
  for (const PitchError& point : axis.pitch_error)
    out += fmt::format("  [{}, {}],\n", point.position_mm, point.error_um);
  return out + "]\n";
}

}  // namespace

std::string to_toml(const Machine& machine) {
  std::string out = fmt::format(
      "[machine]\nname = {}\nprofile = {}\nkind = {}\nperiod_us = {}\n"
      "\n[path]\ntolerance_mm = {}\n",
      toml_string(machine.name), toml_string(machine.profile), toml_string(machine.kind == Kind::mill ? "mill" : "lathe"),
      machine.period_us, machine.tolerance_mm);
  for (const Axis& axis : machine.axes) out += axis_to_toml(axis);
  out += fmt::format(
      "\n[spindle]\nmax_rpm = {}\nmin_rpm = {}\nacceleration_rpm_s = {}\nencoder_lines = {}\n"
      "\n[drive]\ntype = {}\n"
      "\n[memory]\nprograms_kb = {}\n",
      machine.spindle.max_rpm, machine.spindle.min_rpm, machine.spindle.acceleration_rpm_s,
      machine.spindle.encoder_lines, toml_string(machine.drive), machine.program_memory_bytes / 1024);
  return out;
}

}  // namespace headstock::machine

// Planes, the role of axes in them, and the parameters that say what a word means.
#include <cmath>

#include "interpreter/executor.hpp"

namespace headstock::interp {
namespace {

// First and second axis of XY, ZX and YZ as roles.
constexpr int kRoles[3][2] = {{1, 2}, {3, 1}, {2, 3}};

constexpr int basic_role(int role) {
  return role > 4 ? role - 4 : role;
}

}  // namespace

int Executor::role_of(std::size_t axis) const {
  if (roles_given) return given_roles[axis];
  const char name = axes[axis].name;
  const std::string parameter = std::string("1022/") + name;
  if (const auto set = data.parameters.find(parameter); set != data.parameters.end())
    return static_cast<int>(set->second);
  constexpr std::string_view kBasic = "XYZ", kParallel = "UVW";
  if (const auto basic = kBasic.find(name); basic != kBasic.npos) return static_cast<int>(basic) + 1;
  if (const auto parallel = kParallel.find(name); parallel != kParallel.npos && !axes[axis].rotary)
    return static_cast<int>(parallel) + 5;
  return 0;
}

// G17/G18/G19: the plane's axes are those of the block's words, the basic ones where there are none
// (0i-D 7.4).
void Executor::select_plane(Plane wanted) {
  plane = wanted;
  const auto& roles = kRoles[static_cast<std::size_t>(wanted)];
  const auto find = [this](int role) {
    int found = -1;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const int its = role_of(i);
      if (basic_role(its) != role) continue;
      if (block.has(axes[i].name)) return static_cast<int>(i);
      if (its == role || found < 0) found = its == role ? static_cast<int>(i) : found;
    }
    return found;
  };
  plane_index = {find(roles[0]), find(roles[1])};
}

// X and its parallel U both in the block with G17: which of them the plane has is not said (PS0021).
bool Executor::one_axis_a_role() {
  std::uint32_t roles = 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const int role = block.has(axes[i].name) ? basic_role(role_of(i)) : 0;
    if (role == 0) continue;
    if ((roles >> role & 1u) != 0)
      return alarm(AlarmReason::arc_plane, block[axes[i].name].column, std::string(1, axes[i].name));
    roles |= 1u << role;
  }
  return true;
}

double Executor::dwell_units_a_second() const {
  if (data.bit(dialect.numbers.coarse_increment_parameter)) return 100;
  return data.bit(dialect.numbers.fine_increment_parameter) ? 10'000 : 1'000;
}

// Diameter programming and the kind of an axis come from the machine's description; a parameter overrules it.
void Executor::take_parameters() {
  read_look_ahead_parameters();
  const auto& rules = dialect.modes;
  any_rolls_over = any_on_circle = false;
  for (ProgramAxis& axis : axes) {
    const auto set = [&](std::string_view number) -> std::optional<bool> {
      if (number.empty()) return std::nullopt;
      const auto found = data.parameters.find(std::string(number) + '/' + axis.name);
      return found == data.parameters.end() ? std::nullopt : std::optional(found->second != 0);
    };
    if (const auto diameter = set(rules.diameter_parameter)) axis.diameter = *diameter ? 0.5 : 1;
    if (axis.name == 'X' && data.parameters.contains(rules.x_radius_parameter))
      axis.diameter = data.bit(rules.x_radius_parameter) ? 1 : 0.5;
    if (const auto rotary = set(rules.rotary_parameter)) axis.rotary = *rotary;
    axis.on_circle = axis.rotary && set(rules.imaginary_circle_parameter).value_or(false);
    axis.circle_mm = data.parameter(std::string(rules.imaginary_radius_parameter) + '/' + axis.name);
    any_on_circle = any_on_circle || axis.on_circle;
    axis.rolls_over = axis.rotary && set(rules.roll_over_parameter).value_or(false) &&
                      !set(rules.rotary_linear_parameter).value_or(false);
    axis.by_sign = set(rules.roll_over_by_sign_parameter).value_or(false);
    any_rolls_over = any_rolls_over || axis.rolls_over;
    if (axis.rolls_over)
      axis.turn =
          std::llround(data.parameter(std::string(rules.turn_parameter) + '/' + axis.name, 360) * 1e9);
  }
  set_switches(switches);
  if (const auto inch = data.parameters.find(rules.inch_parameter);  // a setting: G20 and G21 come after it
      inch != data.parameters.end() && inch->second != inch_setting) {
    inch_setting = inch->second;
    modal.inch = inch_setting != 0;
    for (const GCode& row : table->rows())
      if (row.tenths == (modal.inch ? 200 : 210) && row.group != 0) modal.g[row.group] = row.tenths;
  }
  set_units(modal.inch);
  update_zeros();
  linear_rapid = data.bit(dialect.linear_rapid_parameter);
  auxiliary_letter = second_auxiliary();
  absent_codes.clear();
  for (const auto& option : rules.options) {
    if (data.bit(option.absent_parameter)) absent_codes.push_back({option.first, option.last});
  }
  one_digit_feed = data.bit(rules.one_digit_feed.enable);
}

}  // namespace headstock::interp

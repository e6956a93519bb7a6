#include "interpreter/transform.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp {
namespace {

using machine::AxisVector;

constexpr std::uint32_t bit_of(std::size_t axis) {
  return 1u << axis;
}

template <typename Apply>
void each(std::uint32_t axes, const Apply& apply) {
  for (; axes != 0; axes &= axes - 1) apply(static_cast<std::size_t>(std::countr_zero(axes)));
}

}  // namespace

AxisVector Transform::apply(AxisVector p) const {
  each(mirrored, [&](std::size_t i) { p[i] = 2 * mirror_at[i] - p[i]; });
  each(scaled, [&](std::size_t i) { p[i] = scale_center[i] + factor[i] * (p[i] - scale_center[i]); });
  if (rotated) {
    const double a = p[first] - center_1, b = p[second] - center_2;
    p[first] = center_1 + cosine * a - sine * b;
    p[second] = center_2 + sine * a + cosine * b;
  }
  if (spatial) {
    for (std::size_t i = 0; i < 3; ++i) p[spatial_axes[i]] -= spatial_center[i];
    p = turn_in_space(p, false);
    for (std::size_t i = 0; i < 3; ++i) p[spatial_axes[i]] += spatial_center[i];
  }
  return p;
}

AxisVector Transform::turn_in_space(AxisVector vector, bool back) const {
  const AxisVector from = vector;
  for (std::size_t row = 0; row < 3; ++row) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i)
      sum += matrix[back ? i * 3 + row : row * 3 + i] * from[spatial_axes[i]];
    vector[spatial_axes[row]] = sum;
  }
  return vector;
}

AxisVector Transform::undo(AxisVector p) const {
  if (spatial) {
    for (std::size_t i = 0; i < 3; ++i) p[spatial_axes[i]] -= spatial_center[i];
    p = turn_in_space(p, true);
    for (std::size_t i = 0; i < 3; ++i) p[spatial_axes[i]] += spatial_center[i];
  }
  if (rotated) {
    const double a = p[first] - center_1, b = p[second] - center_2;
    p[first] = center_1 + cosine * a + sine * b;
    p[second] = center_2 - sine * a + cosine * b;
  }
  each(scaled, [&](std::size_t i) { p[i] = scale_center[i] + (p[i] - scale_center[i]) / factor[i]; });
  each(mirrored, [&](std::size_t i) { p[i] = 2 * mirror_at[i] - p[i]; });
  return p;
}

AxisVector Transform::turn(AxisVector d) const {
  each(mirrored, [&](std::size_t i) { d[i] = -d[i]; });
  each(scaled, [&](std::size_t i) { d[i] *= factor[i]; });
  if (rotated) {
    const double a = d[first], b = d[second];
    d[first] = cosine * a - sine * b;
    d[second] = sine * a + cosine * b;
  }
  if (spatial) d = turn_in_space(d, false);
  return d;
}

bool Transform::reverses(std::size_t axis_1, std::size_t axis_2) const {
  bool reversed = false;
  for (const std::size_t i : {axis_1, axis_2}) {
    if ((mirrored & bit_of(i)) != 0) reversed = !reversed;
    if ((scaled & bit_of(i)) != 0 && factor[i] < 0) reversed = !reversed;
  }
  return reversed;
}

double Transform::radius_factor(std::size_t axis_1, std::size_t axis_2) const {
  const auto of = [this](std::size_t i) { return (scaled & bit_of(i)) != 0 ? std::fabs(factor[i]) : 1.0; };
  return std::max(of(axis_1), of(axis_2));
}

std::uint32_t Transform::also_moved(std::uint32_t written) const {
  if (spatial) {
    std::uint32_t all = 0;
    for (const std::size_t i : spatial_axes) all |= bit_of(i);
    if ((written & all) != 0) written |= all;
  }
  if (!rotated) return written;
  const std::uint32_t plane = bit_of(first) | bit_of(second);
  return (written & plane) != 0 ? written | plane : written;
}

// Right angles are exact: a figure turned by 90° must not lean by a rounding error.
void Transform::set_angle(double degrees) {
  angle_deg = degrees;
  const double quarters = degrees / 90;
  if (quarters == std::floor(quarters) && std::fabs(quarters) < 1e9) {
    constexpr double kCosine[] = {1, 0, -1, 0};
    const auto turn_of = static_cast<std::size_t>((static_cast<std::int64_t>(quarters) % 4 + 4) % 4);
    cosine = kCosine[turn_of];
    sine = kCosine[(turn_of + 3) % 4];
    return;
  }
  cosine = std::cos(degrees * std::numbers::pi / 180);
  sine = std::sin(degrees * std::numbers::pi / 180);
}

namespace handlers {
namespace {

// The block's word for an axis as a position in slide mm, always absolute; where the axis stands if there is
// none.
double center_word(const Executor& ex, std::size_t axis, const AxisVector& standing) {
  const char name = ex.axes[axis].name;
  if (!ex.block.has(name)) return standing[axis];
  const ProgramAxis& a = ex.axes[axis];
  return static_cast<double>(ex.round_to(ex.nano(ex.block[name], a.increment), a.increment)) / 1e9 *
         a.mm_per_unit;
}

// Written positions of all axes, slide mm: a centre is given in the coordinates the program writes.
AxisVector standing_at(const Executor& ex) {
  AxisVector at{};
  for (std::size_t i = 0; i < ex.axes.size(); ++i)
    at[i] = static_cast<double>(ex.axes[i].position) / 1e9 * ex.axes[i].mm_per_unit;
  return at;
}

// A program that broke into one of these modes must not begin another (0i-D 14.9 L21000).
bool may_begin(Executor& ex) {
  return !(ex.interrupting() && ex.transform.active()) ||
         ex.alarm(AlarmReason::interrupted_transform, ex.code_column, std::string(ex.code->name));
}

}  // namespace

// G51.1 IP: mirror at these coordinates.
bool mirror_on(Executor& ex) {
  if (!may_begin(ex)) return false;
  if (ex.transform.rotated || ex.transform.scaled != 0)
    return ex.alarm(AlarmReason::g_not_now, ex.code_column, std::string(ex.code->name));
  const AxisVector standing = standing_at(ex);
  Transform& t = ex.transform;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if (!ex.block.has(ex.axes[i].name)) continue;
    if ((ex.mirror_setting.axes & bit_of(i)) != 0)  // two mirrors on one axis
      return ex.alarm(AlarmReason::g_not_now, ex.block[ex.axes[i].name].column, std::string(ex.code->name));
    t.mirrored |= bit_of(i);
    t.mirror_at[i] = center_word(ex, i, standing);
  }
  ex.follow_transform();
  return true;
}

// G50.1 IP: the axes named, or all of them, are no longer mirrored.
bool mirror_off(Executor& ex) {
  if (ex.transform.rotated || ex.transform.scaled != 0)
    return ex.alarm(AlarmReason::g_not_now, ex.code_column, std::string(ex.code->name));
  std::uint32_t named = 0;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if (ex.block.has(ex.axes[i].name)) named |= bit_of(i);
  }
  ex.transform.mirrored &= (named == 0 ? 0u : ~named) | ex.mirror_setting.axes;
  ex.follow_transform();
  // Group 22 shows G51.1 as long as one axis is mirrored.
  if ((ex.transform.mirrored & ~ex.mirror_setting.axes) != 0) ex.modal.g[ex.code->group] = 511;
  return true;
}

// G51 X Y Z P, or I J K for each axis.
bool scaling_on(Executor& ex) {
  if (!may_begin(ex)) return false;
  const auto& rules = ex.dialect.modes;
  if (ex.transform.rotated || !ex.compensation_is_off())
    return ex.alarm(AlarmReason::g_not_now, ex.code_column, std::string(ex.code->name));
  Transform& t = ex.transform;
  t.scaled = 0;
  ex.follow_transform();
  const double unit = rules.scale_in_thousandths || ex.data.bit(rules.scale_unit_parameter) ? 0.001 : 0.00001;
  const bool by_words = ex.block.has('I') || ex.block.has('J') || ex.block.has('K');
  const bool per_axis = ex.data.bit(rules.scale_each_parameter) || (rules.scale_by_words && by_words);
  // As written with a point; without one in units of the parameter.
  const auto value = [&](const program::Word& word) {
    return word.point ? word.value() : word.value() * unit;
  };
  const AxisVector standing = standing_at(ex);
  const auto mirrored = [&t](std::size_t i, double v) {
    return (t.mirrored & bit_of(i)) != 0 ? 2 * t.mirror_at[i] - v : v;
  };
  std::uint32_t scaled = 0;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    const char name = ex.axes[i].name;
    const std::size_t basic = std::string_view("XYZ").find(name);
    if (ex.axes[i].rotary) continue;
    if (!rules.scale_enable_parameter.empty() &&
        ex.data.parameter(std::string(rules.scale_enable_parameter) + '/' + name, 1) == 0)
      continue;
    double factor = 1;
    std::uint32_t column = ex.code_column;
    if (per_axis) {
      if (basic > 2) continue;
      const char letter = "IJK"[basic];
      const std::string parameter = std::string(rules.scale_axis_parameter) + '/' + name;
      factor = ex.block.has(letter) ? value(ex.block[letter]) : ex.data.parameter(parameter, 1 / unit) * unit;
      if (ex.block.has(letter)) column = ex.block[letter].column;
    } else {
      factor = ex.block.has('P') ? value(ex.block['P'])
                                 : ex.data.parameter(rules.scale_parameter, 1 / unit) * unit;
      if (ex.block.has('P')) column = ex.block['P'].column;
      if (factor < 0) return ex.alarm(AlarmReason::scale_value, column, "P");
    }
    if (factor == 0 || std::fabs(factor) >= 9999.99999 + unit)
      return ex.alarm(AlarmReason::scale_value, column, std::to_string(factor));
    scaled |= bit_of(i);
    t.factor[i] = factor;
    t.scale_center[i] = mirrored(i, center_word(ex, i, standing));
  }
  t.scaled = scaled;
  ex.follow_transform();
  return true;
}

bool scaling_off(Executor& ex) {
  if (ex.transform.rotated)
    return ex.alarm(AlarmReason::g_not_now, ex.code_column, std::string(ex.code->name));
  ex.transform.scaled = 0;
  ex.follow_transform();
  return true;
}

// G68 α β R in the plane of G17/G18/G19.
bool rotation_on(Executor& ex) {
  if (!may_begin(ex)) return false;
  const auto& rules = ex.dialect.modes;
  const auto [first, second] = ex.plane_axes();
  if (first < 0 || second < 0) return ex.alarm(AlarmReason::rotation_plane, ex.code_column, "G68");
  if (!ex.compensation_is_off())
    return ex.alarm(AlarmReason::g_not_now, ex.code_column, std::string(ex.code->name));
  double angle = 0;
  if (ex.block.has('R')) {
    const program::Word& word = ex.block['R'];
    angle = static_cast<double>(ex.nano(word, program::kNano / (ex.data.bit(rules.fine_angle_parameter) ? 100'000 : 1'000))) / 1e9;
    if (std::fabs(angle) > 360) return ex.alarm(AlarmReason::value_range, word.column, "R");
    if (ex.incremental && ex.data.bit(rules.rotation_incremental_parameter) && ex.transform.rotated)
      angle +=
          ex.transform.angle_deg * (ex.transform.reverses(ex.transform.first, ex.transform.second) ? -1 : 1);
  } else {
    angle = ex.data.parameter(rules.rotation_parameter) / 1000;
  }
  Transform& t = ex.transform;
  t.rotated = false;
  ex.follow_transform();
  // The centre is written in the program's coordinates and carried through mirror and scaling.
  AxisVector center = standing_at(ex);
  const auto a = static_cast<std::size_t>(first), b = static_cast<std::size_t>(second);
  center[a] = center_word(ex, a, center);
  center[b] = center_word(ex, b, center);
  center = t.apply(center);
  t.first = a;
  t.second = b;
  t.center_1 = center[a];
  t.center_2 = center[b];
  t.set_angle(t.reverses(a, b) ? -angle : angle);
  t.rotated = true;
  ex.follow_transform();
  return true;
}

bool rotation_off(Executor& ex) {
  ex.transform.rotated = false;
  ex.follow_transform();
  return true;
}

}  // namespace handlers
}  // namespace headstock::interp

// Rotation about any axis, polar coordinates with a pole, units and skip: where the K2000TC differs from the
// common handlers.
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "dialects/k2000tc/language.hpp"
#include "dialects/k2000tc/modes.hpp"

namespace headstock::dialects::k2000tc {
namespace {

using interp::Point3;

double axis_word(const Executor& ex, std::size_t axis, double otherwise) {
  const char name = ex.axes[axis].name;
  if (!ex.block.has(name)) return otherwise;
  const auto& a = ex.axes[axis];
  return static_cast<double>(ex.round_to(ex.nano(ex.block[name], a.increment), a.increment)) / 1e9 *
         a.mm_per_unit;
}

double programmed(const Executor& ex, std::size_t axis) {
  return static_cast<double>(ex.axes[axis].position) / 1e9 * ex.axes[axis].mm_per_unit;
}

// Rotation matrix by Rodrigues' formula; the axis need not be a unit vector.
bool rotation(const Point3& axis, double degrees, std::array<double, 9>& m) {
  const double size = std::hypot(axis[0], axis[1], axis[2]);
  if (!(size > 0)) return false;
  const double x = axis[0] / size, y = axis[1] / size, z = axis[2] / size;
  const double radians = std::remainder(degrees, 360.0) * std::numbers::pi / 180;
  const double c = std::cos(radians), s = std::sin(radians), t = 1 - c;
  m = {t * x * x + c,     t * x * y - s * z, t * x * z + s * y, t * x * y + s * z, t * y * y + c,
       t * y * z - s * x, t * x * z - s * y, t * y * z + s * x, t * z * z + c};
  return true;
}

// G68.1 with a point, a second point and R: about the line through both (L6850). IJK is the second point.
bool rotate_in_space(Executor& ex, double angle) {
  auto& t = ex.transform;
  std::uint8_t axes[3];
  const bool all =
      language(ex).cartesian_axes(ex, axes) && axes[0] != kNoAxis && axes[1] != kNoAxis && axes[2] != kNoAxis;
  if (!all) return ex.alarm(AlarmReason::arc_plane, ex.code_column, "G68.1");
  Point3 from{}, line{};
  constexpr char kSecond[] = {'I', 'J', 'K'};
  for (std::size_t i = 0; i < 3; ++i) {
    from[i] = axis_word(ex, axes[i], 0);
    line[i] = ex.length_mm(ex.block[kSecond[i]]) - from[i];
  }
  if (!rotation(line, angle, t.matrix))
    return ex.alarm(AlarmReason::value_range, ex.block['I'].column, "I J K");
  machine::AxisVector center{};
  for (std::size_t i = 0; i < 3; ++i) center[axes[i]] = from[i];
  center = t.apply(center);  // with scaling the centre is scaled, the angle is not (L7041)
  for (std::size_t i = 0; i < 3; ++i) {
    t.spatial_axes[i] = axes[i];
    t.spatial_center[i] = center[axes[i]];
  }
  t.spatial = true;
  ex.follow_transform();
  return true;
}

}  // namespace

bool rotation_on(Executor& ex) {
  auto& t = ex.transform;
  double angle = ex.data.parameter("P3610", 0);
  if (ex.block.has('R')) angle = static_cast<double>(ex.nano(ex.block['R'], program::kNano / 1'000)) / 1e9;
  const auto [first, second] = ex.plane_axes();
  if (first < 0 || second < 0) return ex.alarm(AlarmReason::arc_plane, ex.code_column, "G68.1");
  const auto a = static_cast<std::size_t>(first), b = static_cast<std::size_t>(second);
  // G91: the angle adds up; the centre is absolute all the same, as the manual's repeated figure needs it
  // (L7074).
  if (ex.incremental && t.rotated) angle += t.angle_deg;
  const auto [was_rotated, was_spatial] = std::pair(t.rotated, t.spatial);
  t.rotated = t.spatial = false;
  if (was_rotated || was_spatial) ex.follow_transform();
  if (ex.block.has('I') && ex.block.has('J') && ex.block.has('K')) return rotate_in_space(ex, angle);
  machine::AxisVector center{};
  for (std::size_t i = 0; i < ex.axes.size(); ++i) center[i] = programmed(ex, i);
  for (const std::size_t i : {a, b}) center[i] = axis_word(ex, i, center[i]);
  center = t.apply(center);
  t.first = a;
  t.second = b;
  t.center_1 = center[a];
  t.center_2 = center[b];
  t.set_angle(angle);
  t.rotated = true;
  ex.follow_transform();
  return true;
}

bool rotation_off(Executor& ex) {
  ex.transform.rotated = ex.transform.spatial = false;
  ex.follow_transform();
  return true;
}

// G16: the pole is the work zero under G90 and where the tool stands under G91 (L6283).
bool polar_on(Executor& ex) {
  const auto [first, second] = ex.plane_axes();
  if (first < 0 || second < 0) return ex.alarm(AlarmReason::arc_plane, ex.code_column, "G16");
  const double at_1 = programmed(ex, static_cast<std::size_t>(first)),
               at_2 = programmed(ex, static_cast<std::size_t>(second));
  auto& polar = ex.polar;
  polar = {};
  polar.on = polar.known = polar.fixed_pole = true;
  if (ex.incremental) {
    polar.center_1 = at_1;
    polar.center_2 = at_2;
  } else {
    polar.radius = std::hypot(at_1, at_2);
    polar.angle_deg = polar.radius > 0 ? std::atan2(at_2, at_1) * 180 / std::numbers::pi : 0;
  }
  return true;
}

// G31 IP F [P]: P1…P5 are the multi-step inputs when SKPN is 1, P0 and none the skip signal (L7389, L7522).
bool skip(Executor& ex) {
  std::int64_t step = 0;
  if (ex.block.has('P')) {
    step = ex.whole('P', AlarmReason::skip_number);
    if (step < 0) return false;
    if (step > 5) return language(ex).raise(ex, "PS0340", ex.block['P'].column, "P" + std::to_string(step));
  }
  const machine::AxisVector from = ex.machine_now;
  std::uint32_t moved = 0;
  if (!ex.take_targets(moved)) return false;
  if (moved == 0) return true;
  double feed = ex.data.parameter("P4510", 0);
  interp::FeedUnit unit = interp::FeedUnit::mm_per_minute;
  if (!ex.data.bit("P4500.7")) {
    if (!ex.cutting_feed(ex.path_to_targets(from, moved), feed, unit)) return false;
  } else if (!(feed > 0)) {
    return ex.alarm(AlarmReason::feed_missing, ex.code_column, "P4510");
  }
  auto& move = ex.emit<interp::Feed>();
  ex.fill_motion(move, moved);
  move.feed = feed;
  move.unit = unit;
  move.exact_stop = true;
  const bool multi = step > 0 && ex.data.bit("P0006.4");
  move.skip_signals = static_cast<std::uint16_t>(1u << (multi ? step : 0));
  ex.skip.machine = ex.machine_now;
  ex.skip.triggered = false;
  return true;
}

namespace {

// INCV P0001.5 = 0, when it is set at all: the input unit follows the machine's and G20/G21 do nothing
// (L7141).
bool unit(Executor& ex, bool inch) {
  const auto incv = ex.data.parameters.find("P0001.5");
  if (incv != ex.data.parameters.end() && incv->second == 0) return true;
  if (ex.modal.inch == inch) return true;
  ex.set_units(inch);
  ex.feed_mm = -1;
  return true;
}

}  // namespace

bool inch(Executor& ex) {
  return unit(ex, true);
}
bool metric(Executor& ex) {
  return unit(ex, false);
}

}  // namespace headstock::dialects::k2000tc

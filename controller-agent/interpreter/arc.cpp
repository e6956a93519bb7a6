// G02/G03: centre from I J K or R, helix and spiral.
#include <cmath>
#include <numbers>

#include "interpreter/executor.hpp"

namespace headstock::interp {
namespace {

struct PlaneWords {
  char first, second;                // basic axes, for texts
  char center_first, center_second;  // their centre words
};
constexpr PlaneWords kPlanes[] = {{'X', 'Y', 'I', 'J'}, {'Z', 'X', 'K', 'I'}, {'Y', 'Z', 'J', 'K'}};

struct Point {
  double first = 0, second = 0;
};

double distance(Point a, Point b) {
  return std::hypot(a.first - b.first, a.second - b.second);
}

// The centre left of the way for a short counter-clockwise arc; a clockwise or a long one mirrors it.
Point center_by_radius(Point from, Point to, double radius, Turn turn) {
  const double chord = distance(from, to);
  const double half = chord / 2;
  const double height = std::sqrt(std::max(0.0, radius * radius - half * half));
  const double side = (turn == Turn::ccw) == (radius > 0) ? 1 : -1;
  return {(from.first + to.first) / 2 - side * height * (to.second - from.second) / chord,
          (from.second + to.second) / 2 + side * height * (to.first - from.first) / chord};
}

// Angle swept in the direction of the turn, (0, 2π]; start and end on one ray are a full circle.
double swept(Point from, Point to, Point center, Turn turn) {
  const double a = std::atan2(from.second - center.second, from.first - center.first);
  const double b = std::atan2(to.second - center.second, to.first - center.first);
  double angle = turn == Turn::ccw ? b - a : a - b;
  const double full = 2 * std::numbers::pi;
  if (angle < 0) angle += full;
  return angle < 1e-12 ? full : angle;
}

}  // namespace

// Axes beside the plane make a helix; an axis parallel to one of the plane's has no place in the block.
bool Executor::only_helix_axes(std::uint32_t moved, std::size_t first, std::size_t second) {
  const auto basic = [this](std::size_t i) {
    const int role = role_of(i);
    return role > 4 ? role - 4 : role;
  };
  int beside = 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if ((moved >> i & 1u) == 0 || i == first || i == second) continue;
    const int role = basic(i);
    if (role != 0 && (role == basic(first) || role == basic(second)))
      return alarm(AlarmReason::arc_foreign_axis, block.has(axes[i].name) ? block[axes[i].name].column : 0,
                   std::string(1, axes[i].name));
    if (++beside > 2) return alarm(AlarmReason::helix_axes, code_column, std::string(1, axes[i].name));
  }
  return true;
}

bool Executor::arc(Turn turn) {
  const PlaneWords& names = kPlanes[static_cast<std::size_t>(plane)];
  const PlaneIndex in_plane = plane_axes();
  if (in_plane.first < 0 || in_plane.second < 0)
    return alarm(AlarmReason::arc_plane, code_column, std::string{names.first, names.second});
  const auto first = static_cast<std::size_t>(in_plane.first),
             second = static_cast<std::size_t>(in_plane.second);
  if (axes[first].increment != axes[second].increment && axes[first].rotary == axes[second].rotary)
    return alarm(AlarmReason::arc_increments, code_column, std::string{axes[first].name, axes[second].name});
  if (transform.spatial || (transform.rotated && (transform.first != first || transform.second != second)))
    return alarm(AlarmReason::rotation_plane, code_column, std::string{names.first, names.second});
  if (one_digit_rapid) return alarm(AlarmReason::arc_in_rapid, code_column, "F0");

  const Point from{slide_mm(first), slide_mm(second)};
  std::uint32_t moved = 0;
  if (!take_targets(moved) || !only_helix_axes(moved, first, second)) return false;
  const AxisVector target = targets_mm();
  const Point to{target[first], target[second]};
  moved |= 1u << first | 1u << second;
  if (transform.active() && transform.reverses(first, second)) turn = turn == Turn::cw ? Turn::ccw : Turn::cw;

  double tolerance = data.parameter(dialect.arcs.tolerance_parameter, dialect.arcs.tolerance_mm);
  if (switches.lenient)
    tolerance = std::max(tolerance, 0.1);  // field files were rounded by their post-processors
  const bool by_center = block.has(names.center_first) || block.has(names.center_second);

  Point center;
  double radius = 0;
  if (block.has('R')) {
    const program::Word& word = block['R'];
    if (by_center && dialect.arcs.r_and_center_is_alarm)
      return alarm(AlarmReason::arc_r_and_center, word.column, "R");
    const double wanted = length_mm(word) * (transform.active() ? transform.radius_factor(first, second) : 1);
    if (wanted == 0) return alarm(AlarmReason::arc_no_center, word.column, "R");
    if (std::fabs(word.value()) > dialect.arcs.largest_r)
      return alarm(AlarmReason::arc_r_too_large, word.column, "R");
    if (wanted < 0 && !dialect.arcs.negative_r) return alarm(AlarmReason::arc_negative_r, word.column, "R");
    const double chord = distance(from, to);
    if (chord == 0) {  // 0°: nothing moves in the plane (0i-D 4.3)
      if (dialect.arcs.closed_by_r_is_alarm) return alarm(AlarmReason::arc_r_too_small, word.column, "R");
      return feed();
    }
    // A semicircle written with rounded end points must not fail on the last digit.
    const double slack = std::max(tolerance, 2 * static_cast<double>(linear_increment) / 1e9 * unit_mm);
    if (std::fabs(wanted) < chord / 2 - slack) return alarm(AlarmReason::arc_r_too_small, word.column, "R");
    center = center_by_radius(from, to, wanted, turn);
    radius = std::max(std::fabs(wanted), chord / 2);
  } else if (by_center) {
    const auto offset = [this](char letter) { return block.has(letter) ? length_mm(block[letter]) : 0; };
    AxisVector way{};
    way[first] = offset(names.center_first);
    way[second] = offset(names.center_second);
    if (transform.active()) way = transform.turn(way);
    center = {from.first + way[first], from.second + way[second]};
    radius = distance(from, center);
    const program::Word& word =
        block.has(names.center_first) ? block[names.center_first] : block[names.center_second];
    if (radius == 0)
      return alarm(pipeline.side() != 0 ? AlarmReason::compensation_arc_centre : AlarmReason::arc_no_center,
                   word.column, "I J K");
    const double mismatch = std::fabs(distance(to, center) - radius);
    if (tolerance > 0 && mismatch > tolerance) {
      return alarm(pipeline.side() != 0 ? AlarmReason::compensation_arc_end : AlarmReason::arc_radius,
                   word.column, std::to_string(mismatch) + " mm");
    }
  } else {
    return alarm(AlarmReason::arc_no_center, 0, "R I J K");
  }

  const double angle = swept(from, to, center, turn);
  double value = 0;
  FeedUnit unit{};
  if (!cutting_feed(radius, value, unit)) return false;  // inverse time: by the radius (0i-D 5.3)
  auto& motion = emit<Arc>();
  fill_motion(motion, moved);
  motion.feed = value;
  motion.unit = unit;
  motion.plane = plane;
  motion.turn = turn;
  motion.axis_1 = static_cast<std::uint8_t>(first);
  motion.axis_2 = static_cast<std::uint8_t>(second);
  motion.feed_on_arc = dialect.arcs.feed_on_arc && !data.bit(dialect.arcs.feed_on_path_parameter);
  motion.radius_mm = radius;
  motion.turns = angle / (2 * std::numbers::pi);
  motion.center_work = motion.end_work;
  motion.center_machine = motion.end_machine;
  motion.center_work[first] = center.first / axes[first].mm_per_unit;
  motion.center_work[second] = center.second / axes[second].mm_per_unit;
  motion.center_machine[first] = center.first + modal.work_zero[first];
  motion.center_machine[second] = center.second + modal.work_zero[second];
  return true;
}

// G32/G33/G34. The lead handed on is along the longer axis, as the machine's spindle synchronisation needs
// it.
bool Executor::thread(bool variable) {
  const auto& rules = dialect.threads;
  if (block.has('F') && block.has('I') && rules.f_and_i_is_alarm) {
    return alarm(AlarmReason::thread_f_and_i, block['I'].column, "I");
  }
  for (const char runout : {'J', 'K'}) {
    if (block.has(runout) && !rules.runout && !(variable && runout == rules.change_word)) {
      return alarm(AlarmReason::g_unavailable, block[runout].column, std::string(code->name) + ' ' + runout);
    }
  }
  if (block.has('F')) {
    const program::Word& word = block['F'];
    lead_mm = word.point || pocket ? word.value() * unit_mm
              : modal.inch         ? word.value() * dialect.numbers.feed_per_revolution_unit_inch * 25.4
                                   : word.value() * dialect.numbers.feed_per_revolution_unit_mm;
  } else if (block.has('I') && rules.inch_word) {
    const double per_inch = block['I'].value();
    lead_mm = per_inch > 0 ? 25.4 / per_inch : 0;
  }
  const std::uint32_t lead_column = block.has('F')   ? block['F'].column
                                    : block.has('I') ? block['I'].column
                                                     : 0;
  if (!(lead_mm > 0) || lead_mm > rules.most_lead_mm)
    return alarm(AlarmReason::thread_lead, lead_column, "F");

  if (block.has('Q') && !rules.q_parameter.empty() && !data.bit(rules.q_parameter))
    return alarm(AlarmReason::illegal_address, block['Q'].column, "Q");
  const AxisVector from = machine_now;
  std::uint32_t moved = 0;
  if (!take_targets(moved) || !axes_at_once(moved)) return false;
  if (moved == 0) return true;
  const AxisVector to = targets_mm();
  double path = 0, longest = 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if ((transform.also_moved(moved) >> i & 1u) == 0) continue;
    const double d = std::fabs(to[i] + modal.work_zero[i] - from[i]);
    path += d * d;
    longest = std::max(longest, d);
  }
  double lead = rules.lead_along_path && path > 0 ? lead_mm * longest / std::sqrt(path) : lead_mm;
  double change = 0;
  if (variable && block.has(rules.change_word)) {
    change = length_mm(block[rules.change_word]);
    if (rules.first_lead_changed) lead += change;
    // After the way s the lead is sqrt(lead² + 2 s change): it must stay positive and in range (PS0313).
    const double last = lead * lead + 2 * longest * change;
    if (lead <= 0 || last <= 0 || last > rules.most_lead_mm * rules.most_lead_mm)
      return alarm(AlarmReason::thread_lead_change, block[rules.change_word].column,
                   std::string(1, rules.change_word));
  }
  Thread motion;
  fill_motion(motion, moved);
  motion.lead_mm = lead;
  motion.lead_change_mm = change;
  if (block.has('Q')) motion.start_angle_deg = static_cast<double>(block['Q'].integer()) * rules.q_unit_deg;
  if (!rules.f_is_feed_too && block.has('F')) feed_mm = -1;
  if (rules.runout && block.has('J')) return thread_runout(motion, from);
  emit<Thread>() = motion;
  return true;
}

// G32 J K: before the end the tool leaves the thread, J along the short axis over K along the long one
// (2000TC L4150). The spindle goes on leading; the block ends where the tool is then.
bool Executor::thread_runout(const Thread& whole_thread, const AxisVector& from) {
  std::size_t along = 0;
  const AxisVector end = machine_now;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (std::fabs(end[i] - from[i]) > std::fabs(end[along] - from[along])) along = i;
  const auto other = axis_named(axes[along].name == 'X' ? 'Z' : 'X');
  if (!other) return alarm(AlarmReason::illegal_address, block['J'].column, "J");
  const std::size_t across = *other;
  const double j = length_mm(block['J']);
  double k = block.has('K') ? std::fabs(length_mm(block['K'])) : 0;
  if (j == 0) {
    emit<Thread>() = whole_thread;
    return true;
  }
  if (k == 0) k = std::fabs(j);
  const double length = std::fabs(end[along] - from[along]);
  if (k >= length) return alarm(AlarmReason::thread_lead, block[block.has('K') ? 'K' : 'J'].column, "K");
  const double part = 1 - k / length;
  AxisVector leave = end, out_of = end;
  leave[along] = from[along] + (end[along] - from[along]) * part;
  leave[across] = from[across] + (end[across] - from[across]) * part;
  out_of[across] = end[across] + j;
  Thread part_of = whole_thread;
  for (const AxisVector& to : {leave, out_of}) {
    for (const std::size_t i : {along, across}) set_axis_machine(i, to[i]);
    auto& leg = emit<Thread>();
    leg = part_of;
    leg.end_machine = machine_now;
    leg.end_work = work_now;
    leg.axes |= 1u << along | 1u << across;
    // The lead that the first part ends with.
    part_of.lead_mm =
        std::sqrt(part_of.lead_mm * part_of.lead_mm + 2 * length * part * part_of.lead_change_mm);
  }
  return true;
}

}  // namespace headstock::interp

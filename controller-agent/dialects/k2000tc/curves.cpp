#include "dialects/k2000tc/curves.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <string>

#include "dialects/k2000tc/language.hpp"

namespace headstock::dialects::k2000tc {
namespace {

using interp::CurveError;
using interp::Point3;
using interp::Turn;

constexpr double kMostTurns = 10'000'000;
constexpr std::string_view kCenterWords = "IJK";

interp::AxisVector programmed_mm(const Executor& ex) {
  interp::AxisVector place{};
  for (std::size_t i = 0; i < ex.axes.size(); ++i)
    place[i] = static_cast<double>(ex.axes[i].position) / 1e9 * ex.axes[i].mm_per_unit;
  return place;
}

// I J K as a vector along Xp Yp Zp, mm.
Point3 center_vector(const Executor& ex) {
  Point3 vector{};
  for (std::size_t i = 0; i < 3; ++i) {
    const char letter = kCenterWords[i];
    if (ex.block.has(letter)) vector[i] = ex.length_mm(ex.block[letter]);
  }
  return vector;
}

Point3 plus(const Point3& a, const Point3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

// What all curves need: targets, the Cartesian axes, the feed.
struct Start {
  RunningCurve run;
  Point3 from{}, to{};
};

bool begin(Executor& ex, Start& s) {
  Language& own = language(ex);
  const std::string_view name = ex.code->name;
  if (ex.modal.g[7] != 400) return own.raise(ex, "PS0048", ex.code_column, std::string(name));
  if (!own.cartesian_axes(ex, s.run.cartesian))
    return ex.alarm(AlarmReason::arc_plane, ex.code_column, std::string(name));
  s.run.from = programmed_mm(ex);
  if (!ex.take_targets(s.run.moved)) return false;
  for (std::size_t i = 0; i < ex.axes.size(); ++i)
    ex.axes[i].position = ex.round_to(ex.axes[i].position, ex.axes[i].increment);
  s.run.to = programmed_mm(ex);
  for (std::size_t i = 0; i < 3; ++i) {
    if (s.run.cartesian[i] == kNoAxis) continue;
    s.from[i] = s.run.from[s.run.cartesian[i]];
    s.to[i] = s.run.to[s.run.cartesian[i]];
    s.run.moved |= 1u << s.run.cartesian[i];
  }
  s.run.at = ex.at;
  s.run.exact_stop = ex.exact_stop_once || ex.exact_stop_mode;
  return ex.cutting_feed(1, s.run.feed, s.run.unit);
}

bool run(Executor& ex, Start& s) {
  for (std::size_t i = 0; i < ex.axes.size(); ++i)
    s.run.end_position[i] = static_cast<double>(ex.axes[i].position);
  Language& own = language(ex);
  own.curve = std::make_unique<RunningCurve>(s.run);
  if (ex.block.m_count == 0) return true;
  // What the block's M codes do comes behind its last chord, so all of them are made now.
  constexpr std::size_t kMostQueued = 20'000;
  while (own.curve->next(ex)) {
    if (ex.queue.size() > kMostQueued) return own.raise(ex, "PS0009", ex.block.m[0].column, "M");
  }
  own.curve.reset();
  return true;
}

// A straight move to the end: points in a line.
bool straight(Executor& ex, Start& s) {
  auto& motion = ex.emit<interp::Feed>();
  ex.fill_motion(motion, s.run.moved);
  motion.feed = s.run.feed;
  motion.unit = s.run.unit;
  return true;
}

// The plane's normal: + side of the third axis, the turn seen from there.
Point3 plane_normal(const Executor& ex) {
  switch (ex.plane) {
    case interp::Plane::xy:
      return {0, 0, 1};
    case interp::Plane::zx:
      return {0, 1, 0};
    default:
      return {1, 0, 0};
  }
}

// NX NY NZ hold for the block; NI NJ NK are modal (L6190).
bool space_normal(Executor& ex, Point3& normal) {
  const auto& b = ex.block;
  Language& own = language(ex);
  constexpr char kOnce[] = {'X', 'Y', 'Z'};
  bool once = false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (b.has_marked(kCenterWords[i])) own.normal[i] = b.marked_at(kCenterWords[i]).value();
    once = once || b.has_marked(kOnce[i]);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (once)
      normal[i] = b.has_marked(kOnce[i]) ? b.marked_at(kOnce[i]).value() : 0;
    else
      normal[i] = own.normal[i];
  }
  return true;
}

bool refuse(Executor& ex, CurveError error) {
  Language& own = language(ex);
  const auto column_of = [&ex](char letter) {
    return ex.block.has(letter) ? ex.block[letter].column : ex.code_column;
  };
  switch (error) {
    case CurveError::no_way:
      return own.raise(ex, "PS0272", ex.code_column, std::string(ex.code->name));
    case CurveError::pole_off_plane:
      return own.raise(ex, "PS0275", column_of('I'), "I J K");
    case CurveError::pole_on_start:
      return own.raise(ex, "PS0263", column_of('I'), "I J K");
    case CurveError::no_normal:
      return own.raise(ex, "PS0329", ex.code_column, "NX NY NZ");
    default:
      return own.raise(ex, "PS0329", ex.code_column, std::string(ex.code->name));
  }
}

enum class Kind : std::uint8_t { archimedean, logarithmic };
enum class Where : std::uint8_t { plane, space };

bool extra_turns(Executor& ex, double& turns) {
  turns = 0;
  if (!ex.block.has('P')) return true;
  const std::int64_t p = ex.whole('P', AlarmReason::value_range);
  if (p < 0) return false;
  turns = static_cast<double>(p);
  return turns <= kMostTurns || language(ex).raise(ex, "PS0117", ex.block['P'].column, "P");
}

bool spiral(Executor& ex, Kind kind, Where where, Turn turn) {
  Start s;
  if (!begin(ex, s)) return false;
  Point3 normal = plane_normal(ex);
  if (where == Where::space && !space_normal(ex, normal)) return false;
  if (turn == Turn::cw) normal = {-normal[0], -normal[1], -normal[2]};

  CurveError error = CurveError::none;
  if (kind == Kind::archimedean && ex.block.has('Q')) {  // format 1: the pole is the start or the end (L2880)
    Language& own = language(ex);
    std::int64_t p = 0;
    if (ex.block.has('P')) p = ex.whole('P', AlarmReason::value_range);
    if (p < 0) return false;
    if (p > 1) return own.raise(ex, "PS0268", ex.block['P'].column, "P");
    const double degrees = static_cast<double>(ex.nano(ex.block['Q'], program::kNano / 1'000)) / 1e9;
    if (!(degrees > 0)) return own.raise(ex, "PS0267", ex.block['Q'].column, "Q");
    if (degrees > kMostTurns * 360) return own.raise(ex, "PS0117", ex.block['Q'].column, "Q");
    error = spiral_about_end(s.from, s.to, normal, p == 1, degrees * std::numbers::pi / 180, s.run.curve);
  } else {
    double turns = 0;
    if (!extra_turns(ex, turns)) return false;
    const Point3 pole = plus(s.from, center_vector(ex));
    const double off_plane = where == Where::space ? ex.data.parameter("P6449", 0.01) : 1e9;
    error = spiral_about_pole(s.from, s.to, pole, normal, turns, kind == Kind::logarithmic, off_plane,
                              s.run.curve);
  }
  return error == CurveError::none ? run(ex, s) : refuse(ex, error);
}

// The operation the block has just emitted, when it is the only one of its kind to look at.
interp::Operation* last_emitted(Executor& ex) {
  if (ex.queue.size() > ex.queue_head) return &ex.queue.back();
  return ex.out_used ? ex.out : nullptr;
}

void take_back(Executor& ex) {
  if (ex.queue.size() > ex.queue_head)
    ex.queue.pop_back();
  else
    ex.out_used = false;
}

double path(const Executor& ex, const interp::AxisVector& from, const interp::AxisVector& to,
            std::uint32_t without) {
  double sum = 0;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if ((without >> i & 1u) == 0) sum += (to[i] - from[i]) * (to[i] - from[i]);
  }
  return std::sqrt(sum);
}

}  // namespace

bool RunningCurve::next(Executor& ex) {
  const double step = curve.angle > 0 ? curve.chord(turned_, kChordTolerance_mm) : 1;
  // A last chord much shorter than the others would make the machine hesitate: the rest is shared by two.
  const double left = curve.angle - turned_;
  const bool last = left <= step;
  turned_ = last ? curve.angle : left < 2 * step ? turned_ + left / 2 : turned_ + step;
  const double part = curve.angle > 0 ? turned_ / curve.angle : 1;

  interp::AxisVector place = to;
  if (!last) {
    for (std::size_t i = 0; i < ex.axes.size(); ++i) place[i] = from[i] + (to[i] - from[i]) * part;
    const Point3 point = curve.at(turned_);
    for (std::size_t i = 0; i < 3; ++i) {
      if (cartesian[i] != kNoAxis) place[cartesian[i]] = point[i];
    }
  }
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    ex.axes[i].position = last ? static_cast<std::int64_t>(end_position[i])
                               : std::llround(place[i] / ex.axes[i].mm_per_unit * 1e9);
  }
  const interp::AxisVector before = ex.machine_now;
  const interp::AxisVector in_work = ex.transform.active() ? ex.transform.apply(place) : place;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if ((moved >> i & 1u) == 0 && !ex.transform.active()) continue;
    ex.work_now[i] = in_work[i] / ex.axes[i].mm_per_unit;
    ex.machine_now[i] = in_work[i] + ex.modal.work_zero[i];
  }
  const std::uint32_t unreal = language(ex).hypothetical;
  const double real = path(ex, before, ex.machine_now, unreal);
  const double whole = path(ex, before, ex.machine_now, 0);
  if (unreal != 0 && real == 0) return !last;  // the machine stands still here
  auto& motion = ex.emit<interp::Feed>();
  motion.at = at;
  motion.modal = ex.modal;
  motion.end_work = ex.work_now;
  motion.end_machine = ex.machine_now;
  motion.axes = moved;
  motion.exact_stop = exact_stop && last;
  motion.feed =
      unreal != 0 && whole > 0 ? feed * real / whole : feed;  // F counts along the programmed curve (L3640)
  motion.unit = unit;
  language(ex).moved(ex, motion);
  return !last;
}

// G02.1: start, start + I J K, end (L2652). Points in a line make a line.
bool three_point_arc(Executor& ex) {
  Start s;
  if (!begin(ex, s)) return false;
  const Point3 middle = plus(s.from, center_vector(ex));
  const CurveError error = interp::three_point_arc(s.from, middle, s.to, s.run.curve);
  return error == CurveError::straight ? straight(ex, s) : run(ex, s);
}

bool plane_archimedean_cw(Executor& ex) {
  return spiral(ex, Kind::archimedean, Where::plane, Turn::cw);
}
bool plane_archimedean_ccw(Executor& ex) {
  return spiral(ex, Kind::archimedean, Where::plane, Turn::ccw);
}
bool space_archimedean_cw(Executor& ex) {
  return spiral(ex, Kind::archimedean, Where::space, Turn::cw);
}
bool space_archimedean_ccw(Executor& ex) {
  return spiral(ex, Kind::archimedean, Where::space, Turn::ccw);
}
bool plane_logarithmic_cw(Executor& ex) {
  return spiral(ex, Kind::logarithmic, Where::plane, Turn::cw);
}
bool plane_logarithmic_ccw(Executor& ex) {
  return spiral(ex, Kind::logarithmic, Where::plane, Turn::ccw);
}
bool space_logarithmic_cw(Executor& ex) {
  return spiral(ex, Kind::logarithmic, Where::space, Turn::cw);
}
bool space_logarithmic_ccw(Executor& ex) {
  return spiral(ex, Kind::logarithmic, Where::space, Turn::ccw);
}

namespace {

// G07.2: the spindle turns with the move just made (L4129). A changing lead takes several pieces.
bool turn_spindle(Executor& ex, const interp::AxisVector& from_machine, const interp::AxisVector& from_work) {
  Language& own = language(ex);
  auto& thread = own.thread;
  auto* made = last_emitted(ex);
  auto* motion = made == nullptr ? nullptr : std::get_if<interp::Feed>(made);
  const double lead_end =
      ex.block.has_marked('F') ? ex.block.marked_at('F').value() * ex.unit_mm : thread.lead_mm;
  if (lead_end < 0) return ex.alarm(AlarmReason::thread_lead, ex.block.marked_at('F').column, "NF");
  if (motion == nullptr) return true;
  const interp::Feed whole = *motion;
  const double distance = std::fabs(whole.end_machine[thread.linear] - from_machine[thread.linear]);
  if (distance > 0 && (thread.lead_mm > 0 || lead_end > 0)) {
    const bool forward = whole.end_machine[thread.linear] > from_machine[thread.linear];
    const double sign = forward != thread.reversed ? 360 : -360;
    const double start = ex.machine_now[thread.spindle];
    const double length = path(ex, from_machine, whole.end_machine, 0);
    constexpr int kPieces = 64;
    const int pieces = thread.lead_mm == lead_end ? 1 : kPieces;
    double before = 0;
    take_back(ex);
    for (int k = 1; k <= pieces; ++k) {
      const double part = static_cast<double>(k) / pieces;
      const double turned = sign * thread.turns(distance * part, distance, lead_end);
      auto& piece = ex.emit<interp::Feed>();
      piece = whole;
      for (std::size_t i = 0; i < ex.axes.size(); ++i) {
        piece.end_machine[i] = from_machine[i] + (whole.end_machine[i] - from_machine[i]) * part;
        piece.end_work[i] = from_work[i] + (whole.end_work[i] - from_work[i]) * part;
      }
      ex.set_axis_machine(thread.spindle, start + turned);
      piece.end_machine[thread.spindle] = ex.machine_now[thread.spindle];
      piece.end_work[thread.spindle] = ex.work_now[thread.spindle];
      piece.axes |= 1u << thread.spindle;
      // F is the speed along the linear axes; on the machine's path a degree counts as a millimetre (L1869).
      piece.feed = whole.feed * std::hypot(length / pieces, turned - before) / (length / pieces);
      before = turned;
    }
  }
  thread.lead_mm = lead_end;
  return true;
}

}  // namespace

bool rapid(Executor& ex) {
  return ex.rapid();
}

bool feed(Executor& ex) {
  Language& own = language(ex);
  const interp::AxisVector before = ex.machine_now, before_work = ex.work_now;
  if (!ex.feed()) return false;
  if (own.thread.on && own.hypothetical != 0)
    return ex.alarm(AlarmReason::g_not_now, ex.code_column, "G07 G07.2");
  if (own.thread.on) return turn_spindle(ex, before, before_work);
  if (own.hypothetical == 0) return true;
  auto* made = last_emitted(ex);
  auto* motion = made == nullptr ? nullptr : std::get_if<interp::Feed>(made);
  if (motion == nullptr) return true;
  const double real = path(ex, before, ex.machine_now, own.hypothetical);
  const double whole = path(ex, before, ex.machine_now, 0);
  if (real == 0)
    take_back(ex);
  else
    motion->feed *= real / whole;
  return true;
}

namespace {

// G02/G03 with P extra turns (L2500). A helix with an axis that only exists in the program becomes a curve.
bool arc(Executor& ex, Turn turn) {
  Language& own = language(ex);
  if (own.thread.on) return ex.alarm(AlarmReason::g_not_now, ex.code_column, "G07.2");
  double turns = 0;
  if (!extra_turns(ex, turns)) return false;
  if (ex.data.bit("P2501.7")) {  // RIKALM (L2303)
    const bool by_r = ex.block.has('R');
    bool by_center = false, zero = true;
    for (const char letter : kCenterWords) {
      if (!ex.block.has(letter)) continue;
      by_center = true;
      zero = zero && ex.block[letter].digits == 0;
    }
    if (by_r == by_center || (by_r && ex.block['R'].digits == 0) || (by_center && zero))
      return own.raise(ex, "PS0329", by_r ? ex.block['R'].column : ex.code_column, "R I J K");
  }
  const interp::AxisVector from = programmed_mm(ex);
  const interp::AxisVector from_work = ex.work_now;
  if (!ex.arc(turn)) return false;
  auto* made = last_emitted(ex);
  auto* motion = made == nullptr ? nullptr : std::get_if<interp::Arc>(made);
  if (motion == nullptr) return true;
  motion->turns += turns;
  const std::uint32_t plane_bits = 1u << motion->axis_1 | 1u << motion->axis_2;
  if ((own.hypothetical & plane_bits) == 0) return true;
  if (ex.transform.active()) return ex.alarm(AlarmReason::g_not_now, ex.code_column, "G07");
  const interp::Arc arc_made = *motion;
  take_back(ex);
  Start s;
  auto& run_it = s.run;
  run_it.from = from;
  run_it.to = programmed_mm(ex);
  run_it.at = ex.at;
  run_it.feed = arc_made.feed;
  run_it.unit = arc_made.unit;
  run_it.moved = arc_made.axes;
  run_it.exact_stop = arc_made.exact_stop;
  // The curve's coordinates: first and second axis of the plane; its third one is none.
  const std::size_t first = arc_made.axis_1, second = arc_made.axis_2;
  std::size_t third = 0;
  while (third == first || third == second) ++third;
  const bool has_third = third < ex.axes.size();
  run_it.cartesian[0] = static_cast<std::uint8_t>(first);
  run_it.cartesian[1] = static_cast<std::uint8_t>(second);
  run_it.cartesian[2] = has_third ? static_cast<std::uint8_t>(third) : kNoAxis;
  const auto mm = [&ex](const interp::AxisVector& work, std::size_t axis) {
    return work[axis] * ex.axes[axis].mm_per_unit;
  };
  auto& curve = run_it.curve;
  curve.pole = {mm(arc_made.center_work, first), mm(arc_made.center_work, second),
                has_third ? from[third] : 0};
  const double a = mm(from_work, first) - curve.pole[0], b = mm(from_work, second) - curve.pole[1];
  curve.radius_from = curve.radius_to = std::hypot(a, b);
  curve.along = {a / curve.radius_from, b / curve.radius_from, 0};
  const double sense = turn == Turn::ccw ? 1 : -1;
  curve.across = {-sense * curve.along[1], sense * curve.along[0], 0};
  curve.angle = arc_made.turns * 2 * std::numbers::pi;
  if (has_third) curve.leg = {0, 0, run_it.to[third] - from[third]};
  return run(ex, s);
}

}  // namespace

bool arc_cw(Executor& ex) {
  return arc(ex, Turn::cw);
}
bool arc_ccw(Executor& ex) {
  return arc(ex, Turn::ccw);
}

}  // namespace headstock::dialects::k2000tc

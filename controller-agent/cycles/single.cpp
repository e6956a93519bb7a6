#include "cycles/single.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace headstock::cycles {
namespace {

double sign_of(double value) {
  return value < 0 ? -1 : 1;
}

// The quarter circle (on cones a little more or less) between the way across and the thread.
struct ThreadArc {
  Point center, from, to;  // `from` and `to` as arms about the centre
  double sweep = 0, radius = 0;
};

ThreadArc thread_arc(const ThreadPass& job, bool onto) {
  const double toward = sign_of(job.end.u - job.start.u), out = sign_of(job.start.v - job.end.v);
  const double begin_u = job.start.u + toward * job.shift;
  const double along = std::fabs(job.end.u - begin_u);
  const double size = std::hypot(along, job.taper);
  // Along the thread, and square to it away from the work.
  const Point t{toward * along / size, -job.taper / size};
  const Point n = toward * out > 0 ? Point{-t.v, t.u} : Point{t.v, -t.u};
  ThreadArc arc;
  arc.radius = onto ? job.arc_in : job.arc_out;
  arc.center.u = onto ? begin_u + toward * arc.radius : job.end.u - toward * arc.radius;
  const double root = job.end.v + job.taper * std::fabs(job.end.u - arc.center.u) / along;
  arc.center.v = root + out * arc.radius / std::fabs(t.u);
  const Point touches{-n.u * arc.radius, -n.v * arc.radius};
  const Point across{(onto ? -toward : toward) * arc.radius, 0};
  arc.from = onto ? across : touches;
  arc.to = onto ? touches : across;
  const double sine = arc.from.u * arc.to.v - arc.from.v * arc.to.u;
  const double cosine = arc.from.u * arc.to.u + arc.from.v * arc.to.v;
  arc.sweep = std::atan2(std::fabs(sine), cosine);
  return arc;
}

Point on_arc(const ThreadArc& arc, double angle) {
  const double a = std::sin(arc.sweep - angle) / std::sin(arc.sweep), b = std::sin(angle) / std::sin(arc.sweep);
  return {arc.center.u + arc.from.u * a + arc.to.u * b, arc.center.v + arc.from.v * a + arc.to.v * b};
}

// Chords of the arc, as fast along the path as the thread is: what the spindle turns on it is the same in every pass.
Moves arc_cut(ThreadArc arc, Move like, double lead_on_path) {
  const double widest = 2 * std::acos(std::max(0.0, 1 - kThreadChord_mm / arc.radius));
  const int chords = static_cast<int>(std::ceil(arc.sweep / widest));
  Point at = on_arc(arc, 0);
  like.run_up_mm = arc.radius * arc.sweep;
  for (int k = 1; k <= chords; ++k) {
    like.to = on_arc(arc, arc.sweep * k / chords);
    const double du = std::fabs(like.to.u - at.u), dv = std::fabs(like.to.v - at.v);
    like.lead_mm = lead_on_path * std::max(du, dv) / std::hypot(du, dv);
    at = like.to;
    co_yield like;
  }
}

}  // namespace

double arc_height(const ThreadPass& job, bool onto) {
  return thread_arc(job, onto).center.v;
}

Moves box_cut(Box job) {
  if (job.facing) {
    co_yield move_u(MoveKind::rapid, job.end.u + job.taper);
    co_yield move_both(MoveKind::feed, job.end);
    co_yield move_u(MoveKind::feed, job.start.u);
    co_yield move_v(MoveKind::rapid, job.start.v);
  } else {
    co_yield move_v(MoveKind::rapid, job.end.v + job.taper);
    co_yield move_both(MoveKind::feed, job.end);
    co_yield move_v(MoveKind::feed, job.start.v);
    co_yield move_u(MoveKind::rapid, job.start.u);
  }
}

Moves thread_pass(ThreadPass job) {
  const double toward = sign_of(job.end.u - job.start.u);
  const double begin_u = job.start.u + toward * job.shift;
  const double length = std::fabs(job.end.u - begin_u);
  const double out = sign_of(job.start.v - job.end.v);  // away from the work
  const double first_v = job.end.v + job.taper;
  const double runout = job.arc_out > 0 ? 0 : std::min(job.runout.length, length);
  // On the cone, where the run-out begins.
  const Point leaves{job.end.u - toward * runout, job.end.v + (length > 0 ? job.taper * runout / length : 0)};
  const double room = std::fabs(job.start.v - leaves.v);
  const double lead_on_path =
      length > 0 ? job.lead_mm * std::hypot(length, job.taper) / std::max(length, std::fabs(job.taper)) : job.lead_mm;
  for (std::int64_t n = 0; n < job.starts; ++n) {
    const double angle =
        std::fmod(job.angle_deg + 360.0 * static_cast<double>(n) / static_cast<double>(job.starts), 360.0);
    Move cut = move_both(MoveKind::thread, leaves);
    cut.lead_mm = job.lead_mm;
    cut.angle_deg = angle;
    if (job.run_in > 0 && job.run_in < length) {
      // Obliquely to the root: the thread has begun before full depth.
      const double high = std::min(job.run_in, std::fabs(job.start.v - first_v));
      co_yield move_v(MoveKind::rapid, first_v + out * high);
      Move in = cut;
      const double along = std::min(high, length / 2);
      in.to = {begin_u + toward * along, first_v - job.taper * along / length};
      co_yield in;
    } else if (job.arc_in > 0) {
      const ThreadArc arc = thread_arc(job, true);
      co_yield move_both(MoveKind::rapid, on_arc(arc, 0));
      Moves chords = arc_cut(arc, cut, lead_on_path);
      for (Move chord; chords.next(chord);) co_yield chord;
    } else if (job.shift != 0) {
      co_yield move_both(MoveKind::rapid, {begin_u, first_v});
    } else {
      co_yield move_v(MoveKind::rapid, first_v);
    }
    if (job.arc_out > 0) {
      const ThreadArc arc = thread_arc(job, false);
      cut.to = on_arc(arc, 0);
      co_yield cut;
      Moves chords = arc_cut(arc, cut, lead_on_path);
      for (Move chord; chords.next(chord);) co_yield chord;
    } else {
      co_yield cut;
    }
    if (runout > 0) {
      Move leave = cut;
      leave.to = {job.end.u, leaves.v + out * std::min(job.runout.height, room)};
      co_yield leave;
    }
    co_yield move_v(MoveKind::rapid, job.start.v);
    co_yield ending_pass(move_u(MoveKind::rapid, job.start.u));
  }
}

Moves pecking(Pecking job) {
  // p: along the pecks, q: across.
  const auto p_of = [&](Point at) { return job.across_first ? at.v : at.u; };
  const auto q_of = [&](Point at) { return job.across_first ? at.u : at.v; };
  const auto to_p = [&](MoveKind kind, double p) {
    return job.across_first ? move_v(kind, p) : move_u(kind, p);
  };
  const auto to_q = [&](MoveKind kind, double q) {
    return job.across_first ? move_u(kind, q) : move_v(kind, q);
  };
  const double p0 = p_of(job.start), p1 = p_of(job.end);
  const double q0 = q_of(job.start), q1 = q_of(job.end);
  const double depth = std::fabs(p1 - p0), width = std::fabs(q1 - q0);
  const double in = sign_of(p1 - p0), across = sign_of(q1 - q0);
  const double away = width > kTiny ? -across : job.relief_sign < 0 ? -1 : 1;
  const auto columns =
      width > kTiny && job.step > 0 ? static_cast<std::int64_t>(std::ceil(width / job.step - 1e-9)) + 1 : 1;
  const auto pecks = job.peck > 0 ? static_cast<std::int64_t>(std::ceil(depth / job.peck - 1e-9)) : 1;
  double q = q0;
  for (std::int64_t column = 0; column < columns; ++column) {
    q = q0 + across * std::min(job.step * static_cast<double>(column), width);
    if (column > 0) co_yield to_q(MoveKind::rapid, q);
    for (std::int64_t n = 1; n <= pecks; ++n) {
      const bool bottom = n == pecks;
      const double p = bottom ? p1 : p0 + in * job.peck * static_cast<double>(n);
      co_yield to_p(MoveKind::feed, p);
      if (bottom) break;
      if (job.full_retract) {
        co_yield to_p(MoveKind::rapid, p0 - in * job.back);
        co_yield to_p(MoveKind::rapid, p - in * job.back);
      } else if (job.back > 0) {
        co_yield to_p(MoveKind::rapid, p - in * job.back);
      }
    }
    if (job.relief > 0) co_yield to_q(MoveKind::rapid, q + away * job.relief);
    co_yield ending_pass(to_p(MoveKind::rapid, p0));
  }
  co_yield to_q(MoveKind::rapid, q0);
}

}  // namespace headstock::cycles

#include "cycles/tool_radius.hpp"

#include <cmath>
#include <numbers>
#include <vector>

namespace headstock::cycles {
namespace {

using dialects::AlarmReason;

comp::Point point(Point p) {
  return {p.u, p.v};
}
Point point(comp::Point p) {
  return {p.u, p.v};
}
Point plus(Point a, comp::Point b) {
  return {a.u + b.u, a.v + b.v};
}

comp::Segment path_of(const Segment& s) {
  if (!s.arc) return comp::line(point(s.from), point(s.to));
  comp::Segment arc = comp::arc(point(s.from), point(s.to), point(s.center), s.sweep > 0 ? 1 : -1);
  arc.sweep = std::fabs(s.sweep);
  return arc;
}

}  // namespace

bool offset_profile(interp::Executor& ex, const Rules& cycle, const interp::CompensationMode& mode,
                    Profile& profile) {
  const double r = mode.radius;
  if (r == 0 || profile.segments.size() <= profile.approach) return true;
  const auto refuse = [&ex](AlarmReason reason) { return ex.alarm(reason, ex.code_column, "G41/G42"); };
  comp::OffsetRules rules;
  rules.circular_outside = ex.data.bit(ex.dialect.compensation.circular_parameter);

  std::vector<comp::Segment> contour;
  for (std::size_t i = profile.approach; i < profile.segments.size(); ++i) {
    const comp::Segment path = path_of(profile.segments[i]);
    if (path.arc && path.turn * r > 0 &&
        std::fmin(path.start_radius(), path.end_radius()) - std::fabs(r) < kTiny)
      return refuse(AlarmReason::compensation_overcut);
    contour.push_back(path);
  }
  // The tool must be on the side that the cycle starts from.
  const double start_side =
      comp::cross(contour.front().direction_at_start(), point(profile.start) - contour.front().from);
  if (std::fabs(start_side) > kTiny && start_side * r < 0) return fail(ex, cycle, Fault::radius_side, 'P');
  Path beside(profile.segments.begin(),
              profile.segments.begin() + static_cast<std::ptrdiff_t>(profile.approach));
  comp::Vectors begin = comp::single(comp::normal_at_start(contour.front(), r));
  Point here = plus(point(contour.front().from), begin.first() + mode.tip);
  if (!beside.empty()) beside.back().to = here;
  for (std::size_t i = 0; i < contour.size(); ++i) {
    const comp::Segment& path = contour[i];
    const bool last = i + 1 == contour.size();
    comp::Vectors end =
        last ? comp::single(comp::normal_at_end(path, r)) : comp::corner(path, contour[i + 1], r, rules);
    if (end.count == 0) return refuse(AlarmReason::compensation_no_crossing);
    if (comp::check(path, begin.last(), end.first()) != comp::Between::good)
      return refuse(AlarmReason::compensation_interference);
    Segment run = profile.segments[profile.approach + i];
    run.from = here;
    run.to = plus(point(path.to), end.first() + mode.tip);
    if (run.arc) {
      const comp::Segment offset =
          comp::arc(path.from + begin.last(), path.to + end.first(), path.center, path.turn);
      run.center = plus(point(path.center), mode.tip);
      run.sweep = offset.sweep * path.turn;
    }
    const double dwell = run.dwell_s;
    run.dwell_s = 0;
    beside.push_back(run);
    here = run.to;
    for (std::size_t n = 1; n < end.count; ++n) {
      Segment link;
      link.from = here;
      link.to = plus(point(path.to), end.at[n] + mode.tip);
      if (end.circular && n == 1) {
        link.arc = true;
        link.center = plus(point(path.to), mode.tip);
        link.sweep = comp::swept(point(link.from), point(link.to), point(link.center), end.turn) * end.turn;
      }
      beside.push_back(link);
      here = link.to;
    }
    beside.back().dwell_s = dwell;
    begin = end;
  }
  profile.segments = std::move(beside);
  return true;
}

Moves box_cut_beside(Box job, BesideBox tool) {
  // The legs: from the start of the cut to its end, and on to the level of the start point.
  const Point cut =
      job.facing ? Point{job.end.u + job.taper, job.start.v} : Point{job.start.u, job.end.v + job.taper};
  const Point out = job.facing ? Point{job.start.u, job.end.v} : Point{job.end.u, job.start.v};
  const comp::Segment first = comp::line(point(cut), point(job.end));
  const comp::Segment second = comp::line(point(job.end), point(out));
  const comp::Point to_start = point(job.start) - point(cut);
  const double r = comp::cross(first.direction_at_start(), to_start) > 0 ? tool.radius : -tool.radius;
  const comp::Vectors corner = comp::corner(first, second, r, {});
  const comp::Point tip = point(tool.tip);
  co_yield move_both(MoveKind::rapid, plus(cut, comp::normal_at_start(first, r) + tip));
  co_yield move_both(MoveKind::feed, plus(job.end, corner.last() + tip));
  co_yield move_both(MoveKind::feed, plus(out, comp::normal_at_end(second, r) + tip));
  co_yield move_both(MoveKind::rapid, job.start);
}

}  // namespace headstock::cycles

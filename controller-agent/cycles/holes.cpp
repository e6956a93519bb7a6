#include "cycles/holes.hpp"

#include <algorithm>
#include <cmath>

#include "cycles/geometry.hpp"

namespace headstock::cycles {
namespace {

using Kind = HoleMove::Kind;
using interp::SpindleDirection;

HoleMove along(Kind kind, double to) {
  return {.kind = kind, .to = to};
}
HoleMove spindle(SpindleDirection direction) {
  return {.kind = Kind::spindle, .direction = direction};
}
HoleMove dwell(double seconds) {
  return {.kind = Kind::dwell, .seconds = seconds};
}
HoleMove shift(double u, double v) {
  return {.kind = Kind::shift, .u = u, .v = v};
}
SpindleDirection other(SpindleDirection direction) {
  return direction == SpindleDirection::cw ? SpindleDirection::ccw : SpindleDirection::cw;
}

// The hole from R to the bottom with the axis and the spindle in step.
HoleMoves tap_in_step(Hole job) {
  const double in = job.bottom < job.reference ? -1 : 1;
  const double depth = std::fabs(job.bottom - job.reference);
  HoleMove tap{.kind = Kind::tap, .seconds = job.dwell_s};
  tap.direction = job.kind.tap == HoleTap::left ? SpindleDirection::ccw : SpindleDirection::cw;
  const double gain = job.pecks_from_retract ? job.peck - job.clearance : job.peck;
  const auto pecks = job.peck > 0 && depth > job.peck
                         ? static_cast<std::int64_t>(std::ceil((depth - job.peck) / gain - 1e-9)) + 1
                         : 1;
  for (std::int64_t n = 1; n <= pecks; ++n) {
    const bool last = n == pecks;
    tap.bottom = last ? job.bottom : job.reference + in * (job.peck + gain * static_cast<double>(n - 1));
    tap.to = last || job.tap_pecks_out ? job.reference : tap.bottom - in * std::min(job.clearance, job.peck);
    co_yield tap;
  }
  if (job.stands_after) co_yield spindle(SpindleDirection::stop);
}

// A floating tap holder takes up what axis and spindle differ.
HoleMoves tap_floating(Hole job) {
  const SpindleDirection in = job.kind.tap == HoleTap::left ? SpindleDirection::ccw : SpindleDirection::cw;
  co_yield along(Kind::feed, job.bottom);
  if (job.dwell_s > 0) co_yield dwell(job.dwell_s);
  if (job.stop_before_reversal) co_yield spindle(SpindleDirection::stop);
  co_yield spindle(other(in));
  co_yield along(Kind::feed, job.reference);
  if (job.dwell_s > 0 && job.dwell_at_reference) co_yield dwell(job.dwell_s);
  if (job.stop_before_reversal) co_yield spindle(SpindleDirection::stop);
  co_yield spindle(in);
}

HoleMoves feed_in(Hole job) {
  const double in = job.bottom < job.reference ? -1 : 1;
  const double depth = std::fabs(job.bottom - job.reference);
  const bool pecking = job.kind.in != HoleIn::once && job.peck > 0;
  const auto pecks = pecking ? static_cast<std::int64_t>(std::ceil(depth / job.peck - 1e-9)) : 1;
  for (std::int64_t n = 1; n < pecks; ++n) {
    const double reached = job.reference + in * job.peck * static_cast<double>(n);
    co_yield along(Kind::feed, reached);
    if (job.kind.in == HoleIn::pecks_back) {
      co_yield along(Kind::rapid, reached - in * job.clearance);
      continue;
    }
    co_yield along(Kind::rapid, job.reference);
    if (job.kind.in == HoleIn::pecks_out && job.clearance < job.peck * static_cast<double>(n)) {
      co_yield along(Kind::rapid, reached - in * job.clearance);
    }
  }
  co_yield along(Kind::feed, job.bottom);
}

// G87: through the hole with the tool out of the centre, then cutting upward.
HoleMoves bore_back(Hole job) {
  co_yield HoleMove{.kind = Kind::orient};
  co_yield shift(job.shift_u, job.shift_v);
  co_yield along(Kind::rapid, job.reference);
  co_yield shift(0, 0);
  co_yield spindle(job.turning);
  co_yield along(Kind::feed, job.bottom);
  if (job.dwell_s > 0) co_yield dwell(job.dwell_s);
  co_yield HoleMove{.kind = Kind::orient};
  co_yield shift(job.shift_u, job.shift_v);
  co_yield along(Kind::rapid, job.initial);
  co_yield shift(0, 0);
  co_yield spindle(job.turning);
}

HoleMoves cut_and_leave(Hole job) {
  HoleMove move;
  HoleMoves in = feed_in(job);
  while (in.next(move)) co_yield move;
  switch (job.kind.bottom) {
    case HoleBottom::nothing:
      break;
    case HoleBottom::dwell:
      if (job.dwell_s > 0) co_yield dwell(job.dwell_s);
      break;
    case HoleBottom::spindle_stop:
      if (job.dwell_s > 0) co_yield dwell(job.dwell_s);
      co_yield spindle(SpindleDirection::stop);
      break;
    case HoleBottom::orient_shift:
      if (job.dwell_s > 0) co_yield dwell(job.dwell_s);
      co_yield HoleMove{.kind = Kind::orient};
      co_yield shift(job.shift_u, job.shift_v);
      break;
    case HoleBottom::operator_out:
      if (job.dwell_s > 0) co_yield dwell(job.dwell_s);
      co_yield spindle(SpindleDirection::stop);
      co_yield HoleMove{.kind = Kind::operator_stop};
      break;
  }
  const Kind way_out = job.kind.out == HoleOut::feed ? Kind::feed : Kind::rapid;
  if (way_out == Kind::feed || job.to_reference) {
    HoleMove out = along(way_out, job.reference);
    if (way_out == Kind::feed) out.feed_ratio = job.out_ratio;
    co_yield out;
    if (!job.to_reference) co_yield along(Kind::rapid, job.initial);
  } else {
    co_yield along(Kind::rapid, job.initial);
  }
  if (job.kind.bottom == HoleBottom::orient_shift) co_yield shift(0, 0);
  const bool stopped = job.kind.bottom == HoleBottom::spindle_stop ||
                       job.kind.bottom == HoleBottom::orient_shift ||
                       job.kind.bottom == HoleBottom::operator_out;
  if (stopped) co_yield spindle(job.turning);
}

}  // namespace

HoleMoves drill(Hole job) {
  HoleMove move;
  if (job.kind.in == HoleIn::up) {
    HoleMoves moves = bore_back(job);
    while (moves.next(move)) co_yield move;
    co_return;
  }
  if (std::fabs(job.reference - job.initial) > kTiny) co_yield along(Kind::rapid, job.reference);
  if (job.kind.tap == HoleTap::none) {
    HoleMoves moves = cut_and_leave(job);
    while (moves.next(move)) co_yield move;
    co_return;
  }
  HoleMoves moves = job.synchronous ? tap_in_step(job) : tap_floating(job);
  while (moves.next(move)) co_yield move;
  if (!job.to_reference) co_yield along(Kind::rapid, job.initial);
}

}  // namespace headstock::cycles

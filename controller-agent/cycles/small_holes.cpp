#include "cycles/small_holes.hpp"

#include <algorithm>
#include <cmath>

#include "cycles/geometry.hpp"
#include "cycles/rules.hpp"

namespace headstock::cycles {
namespace {

using Kind = HoleMove::Kind;

HoleMove at_feed(double to, double ratio) {
  return {.kind = Kind::feed, .to = to, .feed_ratio = ratio, .senses = true};
}
HoleMove traveling(double to, double mm_min) {
  return {.kind = Kind::feed, .to = to, .feed_mm_min = mm_min};
}
HoleMove speed(double ratio) {
  return {.kind = Kind::speed, .speed_ratio = ratio};
}

// In percent; what is not set changes nothing.
double ratio_of(const interp::Executor& ex, const char* parameter) {
  const double percent = ex.data.parameter(parameter);
  return percent > 0 ? percent / 100 : 1;
}

}  // namespace

HoleMoves small_hole(SmallHole job, const Overload* seen) {
  const double in = job.bottom < job.reference ? -1 : 1;
  double reached = job.reference;
  PeckChange now;
  if (std::fabs(job.reference - job.initial) > kTiny) co_yield HoleMove{.to = job.reference};
  for (int in_vain = 0;;) {
    bool overloaded = false;
    if (std::fabs(reached - job.reference) > job.clearance) {
      HoleMove advance = traveling(reached - in * job.clearance, job.advance_mm_min);
      advance.senses = true;
      co_yield advance;
      overloaded = seen->came;
    }
    ++in_vain;
    if (!overloaded) {
      const double target =
          in < 0 ? std::max(job.bottom, reached - job.peck) : std::min(job.bottom, reached + job.peck);
      co_yield at_feed(target, now.feed);
      overloaded = seen->came;
      const double deepest = overloaded ? seen->at : target;
      if ((deepest - reached) * in > kTiny) {
        reached = deepest;
        in_vain = 0;
      }
    }
    if ((job.bottom - reached) * in <= kTiny) break;
    HoleMove out = traveling(job.reference, job.retract_mm_min);
    out.retracts = true;
    out.overloaded = overloaded;
    co_yield out;
    if (in_vain >= kMostInVain) {
      co_yield HoleMove{.kind = Kind::refused};
      co_return;
    }
    const PeckChange& change = overloaded ? job.overloaded : job.clean;
    if (now.feed * change.feed < job.least_feed) continue;
    now.feed *= change.feed;
    now.speed *= change.speed;
    if (change.speed != 1) co_yield speed(now.speed);
  }
  if (job.dwell_s > 0) co_yield HoleMove{.kind = Kind::dwell, .seconds = job.dwell_s};
  co_yield traveling(job.reference, job.retract_mm_min);
  if (now.speed != 1) co_yield speed(1);
  if (!job.to_reference) co_yield HoleMove{.to = job.initial};
}

std::optional<SmallHole> small_hole_job(interp::Executor& ex, const Hole& hole) {
  interp::HoleWords& words = ex.cycle.hole;
  const program::Block& b = ex.block;
  const Rules& rules = rules_of(ex.dialect);
  if (b.has('I')) {
    words.travel_mm_min = b['I'].value() * ex.unit_mm;
    if (!(words.travel_mm_min > 0)) return fail(ex, rules, Fault::value, 'I'), std::nullopt;
  }
  SmallHole job;
  job.initial = hole.initial;
  job.reference = hole.reference;
  job.bottom = hole.bottom;
  job.to_reference = hole.to_reference;
  job.peck = hole.peck;
  job.dwell_s = hole.dwell_s;
  job.clearance = std::max(0.0, ex.data.parameter("5174"));
  const bool given = words.travel_mm_min > 0;
  job.advance_mm_min = given ? words.travel_mm_min : std::max(0.0, ex.data.parameter("5173"));
  job.retract_mm_min = given ? words.travel_mm_min : std::max(0.0, ex.data.parameter("5172"));
  if (ex.data.bit("5160#1")) job.overloaded = {ratio_of(ex, "5166"), ratio_of(ex, "5164")};  // OLS
  if (ex.data.bit("5160#2")) job.clean = {ratio_of(ex, "5167"), ratio_of(ex, "5165")};       // NOL
  job.least_feed = std::max(0.0, ex.data.parameter("5168")) / 100;
  return job;
}

}  // namespace headstock::cycles

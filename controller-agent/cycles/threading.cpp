#include "cycles/threading.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headstock::cycles {

bool Depths::next(double& depth) {
  const double rough = job_.height - job_.finish;
  if (depth_ < rough - kTiny) {
    ++n_;
    const double n = static_cast<double>(n_);
    const bool area = job_.law == DepthLaw::constant_area;
    const double wanted = job_.first_depth * (area ? std::sqrt(n) : n);
    double least = depth_ + job_.least;
    if (area && job_.least_from == LeastFrom::root) least = job_.first_depth * std::sqrt(n - 1) + job_.least;
    depth_ = std::min(rough, n_ == 1 ? std::max(wanted, job_.least) : std::max(wanted, least));
    depth = depth_;
    return true;
  }
  if (finished_ >= job_.finish_passes) return false;
  ++finished_;
  depth = job_.height;
  return true;
}

double most_passes(const Threading& job) {
  const double rough = job.height - job.finish;
  const double ratio = rough / job.first_depth;
  const double by_law = job.law == DepthLaw::constant_area ? ratio * ratio : ratio;
  const double by_least =
      job.least > 0 && job.least_from == LeastFrom::last_pass ? rough / job.least : by_law;
  return std::ceil(std::min(by_law, by_least)) + 2 + static_cast<double>(job.finish_passes);
}

ThreadPass pass_at(const Threading& job, double depth, double shift) {
  const double out = job.start.v < job.end.v ? -1 : 1;
  const double length = std::fabs(job.end.u - job.start.u);
  ThreadPass cut;
  cut.start = job.start;
  cut.shift = shift;
  cut.end = {job.end.u, job.end.v + out * (job.height - depth)};
  cut.taper = length > 0 ? job.taper * (length - shift) / length : 0;  // on the same cone, begun further along
  cut.lead_mm = job.lead_mm;
  cut.angle_deg = job.angle_deg;
  cut.starts = job.starts;
  cut.runout = job.runout;
  cut.arc_in = job.arc_in;
  cut.arc_out = job.arc_out;
  return cut;
}

Moves threading(Threading job) {
  const double flank = std::tan(job.tip_angle_deg / 2 * std::numbers::pi / 180);
  const double rough = job.height - job.finish;
  Depths depths(job);
  double depth = 0;
  for (std::int64_t pass = 1; depths.next(depth); ++pass) {
    // How far the tool begins from the start point, along the thread.
    double along = job.finish_straight ? std::min(depth, rough) : depth;
    if (job.infeed == Infeed::zigzag && pass % 2 == 0 && !depths.finishing()) along = 2 * job.height - depth;
    if (job.finish_at_start) along -= job.height;
    Moves moves = thread_pass(pass_at(job, depth, along * flank));
    Move move;
    while (moves.next(move)) co_yield move;
  }
}

}  // namespace headstock::cycles

#include "rig.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "motion/geometry.hpp"

namespace headstock::motion::rig {

machine::Machine machine(std::size_t axes, double speed, double acceleration, double jerk, double rapid) {
  machine::Machine m;
  const char* names = "XYZABCUV";
  for (std::size_t i = 0; i < axes; ++i) {
    machine::Axis axis;
    axis.name = names[i];
    axis.max_feed_mm_min = speed * 60;
    axis.rapid_mm_min = (rapid > 0 ? rapid : speed) * 60;
    axis.max_acceleration_mm_s2 = acceleration;
    axis.max_jerk_mm_s3 = jerk;
    m.axes.push_back(axis);
  }
  return m;
}

Run run(Kernel& kernel, const machine::Machine& machine, const std::vector<Move>& moves,
        const Options& options) {
  Run result;
  const double period_s = machine.period_us * 1e-6;
  LimitsCheck limits(machine.axes.size(), period_s);
  PathError error(machine.axes.size(), tolerance_weights(machine));
  kernel.set_position(options.start);
  limits.add(options.start);
  error.start(options.start);
  std::size_t next = 0;
  double phase = 0;
  bool finished = false;
  for (std::size_t period = 0; period < options.most_periods; ++period) {
    std::size_t pushed = 0;
    while (next < moves.size() && kernel.can_push() &&
           (options.pushes_per_step == 0 || pushed < options.pushes_per_step)) {
      error.add(moves[next]);
      kernel.push(moves[next++]);
      ++pushed;
    }
    if (next == moves.size() && !finished) {
      kernel.finish();
      finished = true;
    }
    for (std::size_t i = 0; options.plans_per_step == 0 || i < options.plans_per_step; ++i)
      if (!kernel.plan()) break;
    const double rpm = options.rpm ? options.rpm(period) : 1000.0;
    phase += rpm / 60 * period_s * 2 * M_PI;
    const Sample sample =
        kernel.step(options.overrides ? options.overrides(period) : Overrides{}, phase, rpm);
    if (options.watch) options.watch(sample);
    limits.add(sample.position);
    error.sample(sample.position, sample.tag);
    result.samples.push_back(sample);
    if (finished && sample.queue_empty) {
      result.finished = true;
      break;
    }
  }
  result.time_s = static_cast<double>(result.samples.size()) * period_s;
  result.velocity = limits.max_velocity();
  result.acceleration = limits.max_acceleration();
  result.jerk = limits.max_jerk();
  result.path_error = error.max();
  return result;
}

std::string violations(const machine::Machine& machine, const Run& run, bool rapid) {
  std::ostringstream out;
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const machine::Axis& axis = machine.axes[i];
    const double speed =
        (rapid ? std::max(axis.rapid_mm_min, axis.max_feed_mm_min) : axis.max_feed_mm_min) / 60;
    if (run.velocity[i] > speed * 1.001) out << axis.name << ": v " << run.velocity[i] / speed << "; ";
    if (run.acceleration[i] > axis.max_acceleration_mm_s2 * 1.01)
      out << axis.name << ": a " << run.acceleration[i] / axis.max_acceleration_mm_s2 << "; ";
    if (axis.max_jerk_mm_s3 < 1e9 && run.jerk[i] > axis.max_jerk_mm_s3 * 1.05)
      out << axis.name << ": j " << run.jerk[i] / axis.max_jerk_mm_s3 << "; ";
  }
  return out.str();
}

Move line(AxisVector end, double mm_s, double tolerance) {
  Move move;
  move.geometry = Line{end};
  move.feed = PathFeed{mm_s};
  move.tolerance_mm = tolerance;
  return move;
}

}  // namespace headstock::motion::rig

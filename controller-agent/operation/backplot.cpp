#include "operation/backplot.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "axes/arc_path.hpp"
#include "dialects/dialect.hpp"
#include "operation/motion_feed.hpp"

namespace headstock::operation {
namespace {

PlotKind kind_of(const interp::Operation& operation) {
  if (std::holds_alternative<interp::Rapid>(operation)) return PlotKind::rapid;
  if (std::holds_alternative<interp::Arc>(operation)) return PlotKind::arc;
  if (std::holds_alternative<interp::Thread>(operation)) return PlotKind::thread;
  return PlotKind::feed;
}

// Angle whose chord leaves a circle by `chord_mm`: sagitta = r(1 − cos(angle/2)).
int chords(double radius, double sweep, double chord_mm) {
  if (radius <= chord_mm) return std::max(4, static_cast<int>(std::abs(sweep)));
  const double step = 2 * std::acos(1 - chord_mm / radius);
  return static_cast<int>(std::clamp(std::ceil(std::abs(sweep) / step), 1.0, 100'000.0));
}

class Plotter {
 public:
  Plotter(const machine::Machine& machine, const BackplotLimits& limits, Backplot& plot)
      : axes_(machine.axes.size()), machine_(machine), limits_(limits), plot_(plot) {
    for (std::size_t i = 0; i < axes_; ++i) {
      plot.axes.push_back(machine.axes[i].name);
      position_[i] = machine.axes[i].reference_mm;
    }
  }

  bool add(const interp::Operation& operation) {
    const interp::Motion& motion = motion_of(operation);
    if (plot_.moves.empty()) first(motion);
    PlotMove move;
    move.kind = kind_of(operation);
    move.line = motion.at.line;
    move.program = motion.at.program;
    if (const auto* arc = std::get_if<interp::Arc>(&operation)) {
      const axes::ArcPath path(position_, arc_geometry(machine_, *arc));
      const int pieces =
          chords(std::max(path.start_radius(), path.end_radius()), path.sweep(), limits_.chord_mm);
      for (int i = 1; i < pieces && points_ < limits_.max_points; ++i)
        point(move, path.position(path.sweep() * i / pieces), motion.modal.work_zero);
    }
    point(move, motion.end_machine, motion.modal.work_zero);
    position_ = motion.end_machine;
    plot_.moves.push_back(std::move(move));
    return points_ < limits_.max_points;
  }

 private:
  void first(const interp::Motion& motion) {
    for (std::size_t i = 0; i < axes_; ++i) {
      plot_.min_mm[i] = plot_.max_mm[i] = position_[i] - motion.modal.work_zero[i];
      plot_.start.push_back(static_cast<float>(plot_.min_mm[i]));
    }
  }
  void point(PlotMove& move, const AxisVector& at, const AxisVector& zero) {
    for (std::size_t i = 0; i < axes_; ++i) {
      const double value = at[i] - zero[i];
      move.points.push_back(static_cast<float>(value));
      plot_.min_mm[i] = std::min(plot_.min_mm[i], value);
      plot_.max_mm[i] = std::max(plot_.max_mm[i], value);
    }
    ++points_;
  }

  std::size_t axes_;
  const machine::Machine& machine_;
  const BackplotLimits& limits_;
  Backplot& plot_;
  AxisVector position_{};
  std::size_t points_ = 0;
};

}  // namespace

Backplot backplot(const machine::Machine& machine, interp::MachineData data, const OpenProgram& main,
                  std::shared_ptr<program::Programs> sub_programs, const interp::Switches& switches,
                  const BackplotLimits& limits) {
  Backplot plot;
  const dialects::Dialect* dialect = dialects::find(machine.profile);
  if (!dialect) throw std::invalid_argument("no such controller profile: '" + machine.profile + "'");
  auto source = main();
  if (!source) throw std::runtime_error("the program cannot be opened");
  interp::Interpreter interpreter(*dialect, machine, data, sub_programs.get());
  interpreter.set_switches(switches);
  AxisVector home{};
  for (std::size_t i = 0; i < machine.axes.size(); ++i) home[i] = machine.axes[i].reference_mm;
  interpreter.start(std::move(source), home);

  Plotter plotter(machine, limits, plot);
  interp::Operation operation;
  for (std::uint64_t i = 0; interpreter.next(operation) == interp::Pull::operation; ++i) {
    if (const auto* alarm = std::get_if<interp::Alarm>(&operation)) {
      plot.alarm_code = alarm->code;
      plot.alarm_at = alarm->at;
    }
    const bool cancelled = limits.cancel && limits.cancel->load(std::memory_order_relaxed);
    if ((is_motion(operation) && !plotter.add(operation)) || i >= limits.max_operations || cancelled) {
      plot.truncated = true;
      break;
    }
  }
  return plot;
}

}  // namespace headstock::operation

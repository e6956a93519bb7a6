#include "operation/timing.hpp"

#include <algorithm>
#include <utility>

#include "operation/path_length.hpp"
#include "operation/virtual_time.hpp"

namespace headstock::operation {
namespace {

// The clock and the flag are looked at this often: twice a millisecond of computing at most.
constexpr std::uint64_t kPeriodsBetweenChecks = 512;

const char* kIncomplete[] = {"", "", "stopped", "stuck", "budget", ""};

class Estimator {
 public:
  Estimator(const machine::Machine& machine, const EstimateBudget& budget)
      : machine_(machine), budget_(budget), deadline_(std::chrono::steady_clock::now() + budget.max_wall) {
    for (std::size_t i = 0; i < machine.axes.size(); ++i) last_[i] = machine.axes[i].reference_mm;
    result.min_mm = result.max_mm = last_;
  }

  void operation(const interp::Operation& operation) {
    const auto& at =
        std::visit([](const auto& o) -> const interp::SourcePosition& { return o.at; }, operation);
    if (at.line != block_.line || at.program != block_.program || at.byte_offset != block_.byte_offset)
      ++result.blocks;
    block_ = at;
    if (const auto* tool = std::get_if<interp::Tool>(&operation)) {
      if (tool->tool != 0 &&
          std::find(result.tools.begin(), result.tools.end(), tool->tool) == result.tools.end())
        result.tools.push_back(tool->tool);
    } else if (const auto* end = std::get_if<interp::End>(&operation)) {
      result.counts_part = end->counts_part;
    }
  }

  void move(const motion::Move& move) {
    const double length = path_length(last_, move);
    result.length_mm += length;
    if (!std::holds_alternative<motion::RapidFeed>(move.feed)) result.cutting_length_mm += length;
    last_ = end_of(move);
  }

  bool period(const Controller& controller, std::uint64_t periods) {
    const motion::Sample& sample = controller.sample();
    if (sample.moving) {
      ++(controller.cutting() ? cutting_ : rapid_);
      for (std::size_t i = 0; i < machine_.axes.size(); ++i) {
        result.min_mm[i] = std::min(result.min_mm[i], sample.position[i]);
        result.max_mm[i] = std::max(result.max_mm[i], sample.position[i]);
      }
    }
    if (periods % kPeriodsBetweenChecks != 0) return true;
    if (budget_.cancel && budget_.cancel->load(std::memory_order_relaxed)) {
      result.incomplete_reason = "cancelled";
      return false;
    }
    return result.blocks <= budget_.max_blocks &&
           static_cast<double>(periods) * machine_.period_us * 1e-6 <= budget_.max_machine_s &&
           std::chrono::steady_clock::now() < deadline_;
  }

  void finish(const VirtualRun& run, RunEnd end) {
    const double period_s = machine_.period_us * 1e-6;
    result.time_s = static_cast<double>(run.periods) * period_s;
    result.cutting_s = static_cast<double>(cutting_) * period_s;
    result.rapid_s = static_cast<double>(rapid_) * period_s;
    result.complete = end == RunEnd::completed || end == RunEnd::alarm;
    if (end == RunEnd::refused) result.incomplete_reason = run.reason;
    if (!result.complete && result.incomplete_reason.empty())
      result.incomplete_reason = kIncomplete[static_cast<std::size_t>(end)];
    for (const TimedEvent& event : run.events) {
      const auto* raised = std::get_if<AlarmRaised>(&event.event);
      if (raised)
        result.alarms.push_back(
            {raised->alarm.code, raised->alarm.text_en, raised->alarm.text_zh, raised->alarm.at});
    }
  }

  RunEstimate result;

 private:
  const machine::Machine& machine_;
  const EstimateBudget& budget_;
  const std::chrono::steady_clock::time_point deadline_;
  interp::SourcePosition block_;
  AxisVector last_{};
  std::uint64_t cutting_ = 0, rapid_ = 0;
};

/// Offsets of one tool in a row share its life: each tool counts once.
std::map<std::int32_t, double> life_taken(const tools::LifeTable& before, const tools::LifeTable& after) {
  std::map<std::int32_t, double> taken;
  for (const auto& [number, group] : after.groups) {
    const tools::LifeGroup* old = before.find(number);
    if (old == nullptr || old->tools.size() != group.tools.size()) continue;
    std::int64_t amount = 0;
    for (std::size_t i = 0; i < group.tools.size(); ++i)
      if (i == 0 || group.tools[i].tool != group.tools[i - 1].tool) amount += group.tools[i].used - old->tools[i].used;
    if (amount > 0)
      taken[number] = group.unit == tools::LifeUnit::uses ? static_cast<double>(amount) : static_cast<double>(amount) / 10;
  }
  return taken;
}

}  // namespace

RunEstimate estimate(const machine::Machine& machine, const interp::MachineData& data, OpenProgram main,
                     std::shared_ptr<program::Programs> sub_programs, const interp::Switches& switches,
                     const EstimateBudget& budget) {
  ControllerOptions options = virtual_options(switches);
  options.drive = axes::make_drive(machine);  // exact stops last until the machine's own drives are there
  Controller controller(machine, data, std::move(options));
  Estimator estimator(machine, budget);
  controller.on_operation([&](const interp::Operation& operation) { estimator.operation(operation); });
  controller.on_move([&](const motion::Move& move) { estimator.move(move); });
  VirtualRun run(controller);
  const CommandResult selected =
      controller.select("main", {}, single_program(std::move(main), std::move(sub_programs)));
  if (!selected.accepted) {
    run.reason = selected.reason;
    estimator.finish(run, RunEnd::refused);
    return std::move(estimator.result);
  }
  const RunEnd end = run.run([&] { return estimator.period(controller, run.periods); });
  estimator.finish(run, end);
  estimator.result.life_needed = life_taken(data.tool_life, controller.data().tool_life);
  return std::move(estimator.result);
}

}  // namespace headstock::operation

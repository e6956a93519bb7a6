#include "operation/virtual_time.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace headstock::operation {
namespace {

class SingleProgram final : public program::Programs {
 public:
  SingleProgram(std::function<std::unique_ptr<program::Source>()> open,
                std::shared_ptr<program::Programs> others)
      : open_(std::move(open)), others_(std::move(others)) {}
  std::unique_ptr<program::Source> open_number(std::uint32_t number) override {
    return others_ ? others_->open_number(number) : nullptr;
  }
  std::unique_ptr<program::Source> open_name(std::string_view name) override {
    // Cycle start asks for the selected program by the name it was selected under.
    if (name == kMain) return open_();
    return others_ ? others_->open_name(name) : nullptr;
  }
  static constexpr std::string_view kMain = "main";

 private:
  std::function<std::unique_ptr<program::Source>()> open_;
  std::shared_ptr<program::Programs> others_;
};

// Longer than any spindle takes to its speed and any dwell of a sound program is not judged by this: only
// standing with moves to trace counts.
constexpr double kStuckAfter_s = 60;

}  // namespace

ControllerOptions virtual_options(const interp::Switches& switches) {
  ControllerOptions options;
  options.drive = std::make_unique<axes::IdealDrive>();
  options.switches = switches;
  options.now_ms = [] { return std::int64_t{0}; };
  return options;
}

std::shared_ptr<program::Programs> single_program(std::function<std::unique_ptr<program::Source>()> open,
                                                  std::shared_ptr<program::Programs> others) {
  return std::make_shared<SingleProgram>(std::move(open), std::move(others));
}

void PeriodCost::add(std::uint64_t ns) {
  ++bins_[std::min<std::uint64_t>(ns / kBin_ns, bins_.size() - 1)];
  ++count_;
  max_ns_ = std::max(max_ns_, ns);
}

double PeriodCost::percentile_us(double share) const {
  const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(count_));
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i + 1 < bins_.size() && share < 1; ++i) {
    sum += bins_[i];
    if (sum > 0 && sum >= wanted) return static_cast<double>((i + 1) * kBin_ns) / 1000;
  }
  return static_cast<double>(max_ns_) / 1000;
}

void VirtualRun::take_events() {
  TimedEvent event;
  bool any = false;
  while (controller_.take_event(event)) {
    events.push_back(std::move(event));
    ++taken_;
    any = true;
  }
  if (any) controller_.committed(taken_);
}

void VirtualRun::period() {
  take_events();
  while (controller_.work()) {
  }
  ++periods;
  if (!cost) {
    controller_.step();
    return;
  }
  const auto before = std::chrono::steady_clock::now();
  controller_.step();
  cost->add(static_cast<std::uint64_t>((std::chrono::steady_clock::now() - before).count()));
}

RunEnd VirtualRun::run(const std::function<bool()>& each_period) {
  take_events();
  const CommandResult started = controller_.command({Action::cycle_start, Origin::panel, 0});
  if (!started.accepted) {
    reason = started.reason;
    return RunEnd::refused;
  }
  const double period_s = controller_.machine().period_us * 1e-6;
  const auto stuck_after = static_cast<std::uint64_t>(kStuckAfter_s / period_s);
  std::uint64_t standing = 0;
  std::size_t seen = events.size();
  while (true) {
    period();
    if (!each_period()) return RunEnd::out_of_budget;
    const motion::Sample& sample = controller_.sample();
    standing = sample.moving || sample.queue_empty ? 0 : standing + 1;
    if (standing > stuck_after) return RunEnd::stuck;
    // What happened shows in the events; asking for the state every period would cost more than the period.
    for (take_events(); seen < events.size(); ++seen) {
      const auto* changed = std::get_if<StateChanged>(&events[seen].event);
      if (!changed) continue;
      if (changed->state == State::alarm || changed->state == State::emergency_stop) return RunEnd::alarm;
      if (changed->state == State::idle) return RunEnd::completed;
      if (changed->state == State::stopped) {
        if (!answer_stops) return RunEnd::stopped;
        controller_.command({Action::cycle_start, Origin::panel, 0});
      }
    }
  }
}

}  // namespace headstock::operation

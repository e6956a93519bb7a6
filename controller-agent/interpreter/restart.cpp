#include "interpreter/restart.hpp"

#include <algorithm>
#include <utility>

#include "interpreter/executor.hpp"

namespace headstock::interp {
namespace {

constexpr std::size_t kMostSampled = 35;  // M codes the control remembers (0i-D L31152)

}  // namespace

Pull Executor::restart(std::unique_ptr<program::Source> main, const AxisVector& machine_position,
                       const RestartPoint& point) {
  start(std::move(main), machine_position);
  restart_run = {};
  restart_run.point = point;
  restart_run.data = std::make_unique<MachineData>(data);
  restarting = true;
  return run_through();
}

// Before a block is carried out. @return true: it is the one, and is left for the next pull.
bool Executor::restart_reached(bool has_sequence, std::uint32_t sequence, bool counted) {
  RestartRun& run = restart_run;
  if (cycle.watch != nullptr) return false;  // a block of a profile is carried out by its cycle only
  if (run.point.block != 0) {
    run.reached = counted && at.block + 1 == run.point.block;
  } else if (has_sequence && sequence == run.point.sequence) {
    run.reached = ++run.seen == run.point.occurrence;
  }
  return run.reached;
}

// The search writes into a copy. In its pauses the machine's data are everybody's, as they were and as others
// have changed them meanwhile.
Pull Executor::run_through() {
  if (!restarting) return finished ? Pull::finished : Pull::operation;
  std::swap(data, *restart_run.data);
  const Pull reached = search();
  if (restarting) std::swap(data, *restart_run.data);
  return reached;
}

Pull Executor::search() {
  Operation thrown;
  for (;;) {
    out = &thrown;
    out_used = false;
    at_standstill = true;  // nothing is handed out, so nothing is waited for
    if (cycle.running != nullptr) {
      if (!cycle.running->next(*this)) {
        cycle.running.reset();
        cycle.name = nullptr;
        if (!finished) run_deferred();
      }
    } else if (!finished && step() == Step::wait) {
      return Pull::wait;
    }
    if (pipeline.active()) pipeline.take(*this);
    if (out_used) sample(thrown);
    for (const Operation& more : queue) sample(more);
    const bool alarmed = finished && std::holds_alternative<Alarm>(queue.empty() ? thrown : queue.back());
    queue.clear();
    queue_head = 0;
    if (++steps % 1'024 == 0 && environment->wants_stop()) {
      finished = true;
      keep_data_of_broken_run();
      leave_program();
      return Pull::finished;
    }
    if (!finished && !restart_run.reached) {
      if (steps % 1'024 == 0 && environment->wants_pause()) return Pull::pause;
      continue;
    }

    restart_run.state.position = machine_now;
    restart_run.state.modal = modal;
    restart_run.state.spindle = modal.spindle_speed;
    keep_data_of_broken_run();
    barrier = false;
    at_standstill = true;
    // Inside compensation, a chamfer or G12.1 the axes would begin beside the path (0i-D L31700).
    const bool beside = pipeline.compensating() || pipeline.side() != 0 || pipeline.holds_corner() ||
                        surface.now.kind != SurfaceKind::none;
    if (!finished && !beside) return Pull::operation;
    leave_program();
    if (!finished) {
      finished = true;
      queue.emplace_back(Alarm{at, std::string(dialect.alarm_code(AlarmReason::g_not_now)), "restart"});
      return Pull::finished;
    }
    if (alarmed) {
      queue.push_back(std::move(thrown));
    } else {
      queue.emplace_back(Alarm{at, std::string(dialect.alarm_code(AlarmReason::sequence_not_found)),
                               restart_run.point.block != 0 ? std::to_string(restart_run.point.block)
                                                            : "N" + std::to_string(restart_run.point.sequence)});
    }
    return Pull::finished;
  }
}

// The search is over, its copy goes. Of a newer version than either, so that nobody takes what he has read of
// the copy for the machine's.
void Executor::leave_search() {
  data.version = std::max(data.version, restart_run.data->version) + 1;
  restart_run.data.reset();
  restarting = false;
  data_input_ahead.clear();
  if (macros != nullptr) (void)macros->variables.take_changes();
  update_zeros();
}

void Executor::keep_variable(std::uint32_t number) {
  auto& kept = data.common_variables;
  const auto found = kept.find(number);
  const double before = found != kept.end() ? found->second : macro::kNull, now = macros->common.get(number);
  if (now == before || (macro::is_null(now) && macro::is_null(before))) return;
  if (macro::is_null(now)) {
    kept.erase(number);
  } else {
    kept[number] = now;
  }
  ++data.version;
  if (changed) changed({"variable/" + std::to_string(number), before, now, "program"});
}

// The variables that do not outlive power are those of this run; everything else stands as it did.
void Executor::keep_data_of_broken_run() {
  std::swap(data, *restart_run.data);
  leave_search();
  if (macros != nullptr) {
    for (const macro::CommonRange& range : macros->rules.common) {
      if (range.retained) continue;
      for (std::uint32_t number = range.first; number <= range.last; ++number) keep_variable(number);
    }
  }
}

void Executor::sample(const Operation& passed) {
  RestartState& state = restart_run.state;
  if (const auto* m = std::get_if<MCode>(&passed)) {
    if (state.m.size() == kMostSampled) state.m.erase(state.m.begin());
    state.m.push_back(m->code);
  } else if (const auto* tool = std::get_if<Tool>(&passed)) {
    state.tool = tool->tool;
    state.offset = tool->offset;
  }
}

}  // namespace headstock::interp

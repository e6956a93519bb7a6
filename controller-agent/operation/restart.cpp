// A program taken up in its middle (0i-D III-4.6, type Q): it is run through from its head without anything
// being handed out, the machine stops, and cycle start takes the axes to the block one after the other. The
// operator gives M, S and T himself beforehand in MDI mode; what is plainly missing refuses the start.
#include "operation/restart.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "operation/controller_impl.hpp"

namespace headstock::operation {
namespace {

constexpr double kAtBlock_mm = 1e-9;
constexpr std::string_view kOrderParameter = "7310";

/// As the newest of M03, M04, M05 says.
int turning_after(const std::vector<std::int32_t>& passed) {
  for (auto m = passed.rbegin(); m != passed.rend(); ++m) {
    if (*m == 3) return 1;
    if (*m == 4) return -1;
    if (*m == 5) return 0;
  }
  return 0;
}

}  // namespace

CommandResult Controller::Impl::restart(std::optional<interp::RestartPoint> point) {
  if (emergency) return refused("emergency_stop");
  if (alarmed() || phase == Phase::faulted) return refused("alarm");
  if (phase == Phase::aborting) return refused("resetting");
  if (phase != Phase::idle) return refused("running");
  if (mode != Mode::memory) return refused("wrong_mode");
  if (selection.name.empty() || selection.is_stream) return refused("no_program");
  if (mirror_place_unknown()) return refused("mirror_place");
  if (realtime.machine_lock || realtime.axis_lock.load() != 0) return refused("machine_lock");
  if (!point) {
    const Breakpoint& broken = retained.breakpoint;
    if (broken.program.empty() || broken.block == 0) return refused("no_breakpoint");
    if (broken.program != selection.name || broken.revision_hash != selection.revision_hash)
      return refused("other_program");
    point.emplace();
    point->block = broken.block;
  }
  if (!(data.parameter("1410", FeedRules{}.dry_run_mm_min) > 0)) return refused("bad_value");
  if (point->block == 0 && point->sequence == 0) return refused("bad_value");
  if (point->occurrence == 0) return refused("bad_value");
  selection.unseen = false;  // the operator has just asked for it
  const CommandResult started = start_run(selection, &*point);
  if (!started.accepted) return started;
  restarting.point = *point;
  await = Await::search;
  return started;
}

void Controller::Impl::search_restart() {
  const interp::Pull reached =
      restarting.source != nullptr
          ? interpreter.restart(std::exchange(restarting.source, nullptr), feed.position(), restarting.point)
          : interpreter.run_through();
  if (reached == interp::Pull::wait || reached == interp::Pull::pause) {
    calculating = true;
    return;
  }
  await = Await::nothing;
  if (reached == interp::Pull::operation) restart_found();
  // Otherwise there is no such block: its alarm is the next operation.
}

void Controller::Impl::restart_found() {
  const interp::RestartState& state = interpreter.restart_state();
  restarting.found = true;
  RestartReport& report = restarting.report;
  report.found = true;
  report.block = restarting.point.block;
  report.sequence = restarting.point.sequence;
  report.m = state.m;
  report.tool = state.tool;
  report.offset = state.offset;
  report.spindle = state.spindle;
  report.turning = turning_after(state.m);
  report.position = state.position;

  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    if (machine.axes[i].follows == 0 && (plc_axes >> i & 1) == 0) order.push_back(i);
  const auto rank = [this](std::size_t axis) {
    const std::string of_axis = std::string(kOrderParameter) + '/' + machine.axes[axis].name;
    const double written = data.parameter(of_axis);
    return written > 0 ? written : 1e3 + static_cast<double>(axis);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
  AxisVector at = feed.position();
  for (const std::size_t axis : order) {
    if (std::abs(state.position[axis] - at[axis]) < kAtBlock_mm) continue;
    at[axis] = state.position[axis];
    interp::Feed move;
    move.modal = state.modal;
    move.at.part = static_cast<std::uint32_t>(axis) + 1;  // single block stops after each axis
    move.end_machine = at;
    move.axes = 1u << axis;
    move.exact_stop = true;
    move.feed = std::min(data.parameter("1410", FeedRules{}.dry_run_mm_min), machine.axes[axis].rapid_mm_min);
    restarting.approach.emplace_back(move);
  }
  phase = Phase::stopped;
  realtime.running = false;
}

CommandResult Controller::Impl::may_go_to_restart() {
  const plc::Outputs& now = realtime.state().machine;
  const RestartReport& needs = restarting.report;
  if (needs.turning != 0 && static_cast<int>(now.turning) != needs.turning) return refused("restart_spindle");
  if (needs.tool != 0 && now.tool != needs.tool) return refused("restart_tool");
  return {true, {}};
}

/// @return true: `operation` is the next move to where the program goes on.
bool Controller::Impl::next_approach() {
  if (restarting.approach.empty() || !feed.has_room(realtime.state().sample.tag)) return false;
  operation = std::move(restarting.approach.front());
  restarting.approach.pop_front();
  has_operation = true;
  wait_since_period = 0;
  if (observer) observer(operation);
  return true;
}

// The block that is being carried out, or was carried out last.
interp::SourcePosition Controller::Impl::block_under_way() {
  const RealtimeState& now = realtime.state();
  const bool traced = feed.last_tag() == 0 || (now.sample.tag == feed.last_tag() && now.sample.queue_empty);
  const bool between = await != Await::nothing && await != Await::block_stop && !now.sample.moving && traced;
  return between || feed.last_tag() == 0 ? last_block : tags.find(now.sample.tag).at;
}

/// What is being carried out now, for the disk.
void Controller::Impl::mark_breakpoint() {
  if (run_mode != Mode::memory || restarting.found || await == Await::search || !restarting.approach.empty())
    return;
  const interp::SourcePosition at = block_under_way();
  if (at.block == 0) return;
  retained.breakpoint = {selection.name, selection.revision_hash, at.block, at.sequence, at.line};
}

// What RESET takes back begins with this block (0i-D K.32.1): the one under way, or the one behind all that is done.
std::uint32_t Controller::Impl::first_block_left() {
  const motion::Sample& sample = realtime.state().sample;
  const std::uint32_t traced = sample.tag > tag_before_run ? tags.find(sample.tag).at.block : 0;
  const AxisVector& left = sample.distance_to_go;
  if (sample.moving || std::any_of(left.begin(), left.end(), [](double d) { return d != 0; }))
    return std::max(traced, 1u);
  const bool in_function = await == Await::function || await == Await::dwell || await == Await::tap;
  if (in_function && last_block.block != 0) return last_block.block;
  return std::max(traced, done_block) + 1;
}

}  // namespace headstock::operation

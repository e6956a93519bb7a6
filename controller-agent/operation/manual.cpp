// Moving by hand: jog, steps of the handle or the incremental keys, reference return, and the block typed in
// MDI mode. Moves go through the same kernel as a program's, so the limits hold; letting go of a button is a
// feed hold whose rest is dropped.
#include <algorithm>
#include <string>
#include <utility>

#include "axes/travel_limits.hpp"
#include "operation/controller_impl.hpp"

namespace headstock::operation {
namespace {

constexpr double kManualFeed_mm_min = 1'000;  // FANUC No. 1423, when it is not set

CommandResult refused(const char* reason) {
  return {false, reason};
}

/// The block typed at the panel; the programs it calls are those of the memory.
class TypedBlock final : public program::Programs {
 public:
  TypedBlock(std::string text, std::shared_ptr<program::Programs> memory)
      : text_(std::move(text)), memory_(std::move(memory)) {}
  std::unique_ptr<program::Source> open_number(std::uint32_t number) override {
    return memory_ ? memory_->open_number(number) : nullptr;
  }
  std::unique_ptr<program::Source> open_name(std::string_view name) override {
    if (name == kName) return program::source_from_text(text_);
    return memory_ ? memory_->open_name(name) : nullptr;
  }
  static constexpr std::string_view kName = "MDI";

 private:
  std::string text_;
  std::shared_ptr<program::Programs> memory_;
};

}  // namespace

CommandResult Controller::Impl::mdi(std::string text) {
  if (busy()) return refused("running");
  if (mode != Mode::mdi) return refused("wrong_mode");
  mdi_block = {};
  mdi_block.name = TypedBlock::kName;
  mdi_block.bytes = text.size();
  mdi_block.memory = std::make_shared<TypedBlock>(std::move(text), selection.memory);
  return {true, {}};
}

CommandResult Controller::Impl::may_move_by_hand(std::size_t axis, Mode needed) const {
  if (emergency) return refused("emergency_stop");
  if (alarmed() || phase == Phase::faulted) return refused("alarm");
  if (phase != Phase::idle && phase != Phase::manual) return refused("running");
  if (mode != needed) return refused("wrong_mode");
  if (axis >= machine.axes.size()) return refused("bad_value");
  return {true, {}};
}

void Controller::Impl::move_by_hand(std::size_t axis, double target_mm, double feed_mm_min) {
  motion::Move move;
  AxisVector target = feed.position();
  target[axis] = target_mm;
  move.geometry = motion::Line{target};
  if (feed_mm_min > 0)
    move.feed = motion::PathFeed{feed_mm_min / 60};
  else
    move.feed = motion::RapidFeed{};
  if (phase == Phase::idle) {
    const AxisVector standing = feed.position();
    kernel.set_position(standing);
    feed.set_position(standing);
    hand_off = false;
  }
  feed.add_manual(move);
  phase = Phase::manual;
  planned = false;
  realtime.hold = false;
}

CommandResult Controller::Impl::jog(std::size_t axis, int direction) {
  if (direction == 0) {
    if (phase == Phase::manual) end_manual(true);
    return {true, {}};
  }
  if (const CommandResult may = may_move_by_hand(axis, Mode::jog); !may.accepted) return may;
  if (phase == Phase::manual) return refused("running");
  const machine::Axis& limits = machine.axes[axis];
  const double limit =
      direction > 0 ? limits.max_mm - axes::kStopBeforeLimit_mm : limits.min_mm + axes::kStopBeforeLimit_mm;
  if ((limit - feed.position()[axis]) * direction <= 0) return refused("travel_limit");
  move_by_hand(axis, limit, std::min(data.parameter("1423", kManualFeed_mm_min), limits.rapid_mm_min));
  return {true, {}};
}

CommandResult Controller::Impl::step(std::size_t axis, double distance_mm) {
  const Mode needed = mode == Mode::handle ? Mode::handle : Mode::jog;
  if (const CommandResult may = may_move_by_hand(axis, needed); !may.accepted) return may;
  if (phase == Phase::manual && (hand_off || !kernel.can_push())) return refused("running");
  const double target = feed.position()[axis] + distance_mm;
  const machine::Axis& limits = machine.axes[axis];
  const bool outside = distance_mm > 0 ? target > limits.max_mm : target < limits.min_mm;
  if (outside) return refused("travel_limit");
  if (distance_mm == 0) return {true, {}};
  move_by_hand(axis, target, std::min(data.parameter("1423", kManualFeed_mm_min), limits.rapid_mm_min));
  return {true, {}};
}

CommandResult Controller::Impl::reference(std::size_t axis) {
  if (const CommandResult may = may_move_by_hand(axis, Mode::reference); !may.accepted) return may;
  if (phase == Phase::manual) return refused("running");
  const double target = machine.axes[axis].reference_mm;
  if (target == feed.position()[axis]) return {true, {}};
  move_by_hand(axis, target, 0);
  return {true, {}};
}

void Controller::Impl::end_manual(bool as_soon_as_possible) {
  hand_off = hand_off || as_soon_as_possible;
  if (!as_soon_as_possible) return;
  realtime.hold = true;
  manual_since = realtime.state().periods;
}

bool Controller::Impl::work_manual() {
  bool more = true;
  while (more) more = kernel.plan();
  const RealtimeState& now = realtime.state();
  if (!std::exchange(planned, true)) manual_since = now.periods;
  // Two periods: the sample must have been made after the last change by hand.
  if (now.periods < manual_since + 2 || now.sample.moving) return false;
  const bool arrived = now.sample.queue_empty && now.sample.tag == feed.last_tag();
  if (!arrived && !hand_off) return false;
  const AxisVector standing = now.sample.position;
  kernel.set_position(standing);
  feed.set_position(standing);
  interpreter.set_position(standing);
  realtime.hold = false;
  hand_off = false;
  phase = Phase::idle;
  state_changed();
  return false;
}

}  // namespace headstock::operation

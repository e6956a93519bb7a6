// Interruption macros on the machine (0i-D 14.9, K2000TC L20693). Between blocks: the block is carried out,
// then the program is called. Inside a block: the axes brake on the path and the program begins; when it
// commands nothing the rest of the block follows, otherwise that rest is dropped and the interpreter goes on
// as its control does. Threads, taps, dwells, M S T and skip moves are carried out to their end first.
#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "operation/controller_impl.hpp"

namespace headstock::operation {
namespace {

constexpr double kAtEnd_mm = 1e-6;
constexpr int kOperationsAPiece = 256;

}  // namespace

/// Before anything more is asked of the interpreter, and before the first operation behind M96 is taken up.
/// @return true: what has been handed out comes first.
bool Controller::Impl::wait_for_interruption() {
  if (!interpreter.interruption_enabled()) {
    interruption.in_force = interruption.all_done = false;
    return false;
  }
  if (interruption.all_done && interruption.in_force) return false;
  feed.finish();
  planned = false;
  await = Await::interruption;
  return true;
}

void Controller::Impl::work_interruption() {
  const RealtimeState& now = realtime.state();
  if (interruption.stage == MacroInterruption::Stage::inside) return run_interruption_in_block();
  const bool traced = feed.last_tag() == 0 || (now.sample.tag == feed.last_tag() && now.sample.queue_empty);
  const bool done = planned && traced && !now.sample.starved && !now.kernel_moving && now.in_position;
  if (!done) return break_in();

  realtime.brake = false;
  interruption.stage = MacroInterruption::Stage::none;
  interruption.all_done = true;
  await = Await::nothing;
  const auto signal = interpreter.interruption_signal();
  // A signal that was on before M96 counts by its level only (0i-D L20860).
  if (!std::exchange(interruption.in_force, true)) interruption.see();
  if (has_operation || realtime.hold || !interruption.due(signal.by_level)) return;
  interruption.see();
  (void)interpreter.interrupt(feed.position(), false);
}

/// The block is under way: does the signal break into it?
void Controller::Impl::break_in() {
  const RealtimeState& now = realtime.state();
  const auto signal = interpreter.interruption_signal();
  if (interruption.stage == MacroInterruption::Stage::none) {
    if (!interruption.in_force || has_operation || realtime.hold) return;
    if (!signal.inside_blocks || !interruption.due(signal.by_level)) return;
    realtime.brake = true;
    interruption.braking_since = now.periods;
    interruption.stage = MacroInterruption::Stage::braking;
    return;
  }
  // Two periods: the state must have been made after the brake was put on.
  if (now.periods < interruption.braking_since + 2 || now.kernel_moving || realtime.hold) return;
  double to_go = 0;
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    to_go = std::max(to_go, std::abs(feed.position()[i] - now.base[i]));
  if (to_go < kAtEnd_mm) return;  // it came to its end instead
  interruption.see();
  if (!interpreter.interrupt(now.base, true)) {
    interruption.stage = MacroInterruption::Stage::none;
    realtime.brake = false;
    return;
  }
  interruption.stage = MacroInterruption::Stage::inside;
  run_interruption_in_block();
}

/// The axes stand inside the block; the program has commanded nothing yet.
void Controller::Impl::run_interruption_in_block() {
  for (int i = 0; i < kOperationsAPiece; ++i) {
    switch (interpreter.next(operation)) {
      case interp::Pull::wait:
      case interp::Pull::finished:
        return;
      case interp::Pull::standstill:  // they do stand
      case interp::Pull::pause:
        calculating = true;
        return;
      case interp::Pull::operation:
        break;
    }
    if (observer) observer(operation);
    if (interpreter.interruption_left_block()) {
      has_operation = true;  // of what follows the block
      interruption.stage = MacroInterruption::Stage::none;
      realtime.brake = false;
      return;
    }
    if (std::holds_alternative<interp::Message>(operation)) {
      take(operation);
      continue;
    }
    has_operation = true;
    interruption.stage = MacroInterruption::Stage::none;
    return park();  // the rest of the block is over
  }
  calculating = true;
}

}  // namespace headstock::operation

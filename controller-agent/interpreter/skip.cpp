#include "interpreter/skip.hpp"

#include <bit>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp {

void Executor::skip_ended(const AxisVector& machine_position, bool triggered) {
  set_position(machine_position);
  skip.machine = machine_position;
  skip.triggered = triggered;
}

// The signals that the parameters assign to P1…P4 of G31, or to Q1…Q4 of G04 (0i-D 4.7). 0: none are.
std::uint16_t Executor::assigned_skip_signals(std::int64_t number) const {
  const auto& parameters = dialect.modes.skip_signals;
  std::uint16_t signals = 0;
  const std::string name(parameters[static_cast<std::size_t>(number)]);
  for (int bit = 0; bit < 8 && !name.empty(); ++bit) {
    if (data.bit(name + '#' + std::to_string(bit))) signals = static_cast<std::uint16_t>(signals | 1u << bit);
  }
  return signals;
}

namespace handlers {
namespace {

constexpr std::uint16_t kSkip = 1;  // the SKIP input itself

// P98: torque limit, P99: torque limit or SKIP, P1…P4: by parameter.
bool signals_of(Executor& ex, std::uint16_t& signals, std::int64_t& step) {
  const std::uint16_t skip = ex.data.bit(ex.dialect.modes.skip_off_parameter) ? 0 : kSkip;
  if (!ex.block.has('P')) {
    signals = skip;
    return true;
  }
  const std::int64_t p = ex.whole('P', AlarmReason::skip_number);
  if (p < 0) return false;
  const std::uint32_t column = ex.block['P'].column;
  if (p == 98 || p == 99) {
    if (std::popcount(ex.block.words & ex.axis_letters) != 1)
      return ex.alarm(AlarmReason::skip_format, column, "P" + std::to_string(p));
    signals = static_cast<std::uint16_t>(kSkipTorque | (p == 99 ? skip : 0u));
    return true;
  }
  if (p == 90) return ex.alarm(AlarmReason::skip_format, column, "P90");
  if (p < 1 || p > 4) return ex.alarm(AlarmReason::skip_number, column, "P" + std::to_string(p));
  signals = ex.assigned_skip_signals(p - 1);
  step = p;
  // A probe whose signal is assigned to nothing would run into the part.
  return signals != 0 || ex.alarm(AlarmReason::skip_number, column, "P" + std::to_string(p));
}

}  // namespace

// G31 IP F [P]: as G01 until the signal comes; the rest of the move is dropped.
bool skip(Executor& ex) {
  const auto& rules = ex.dialect.modes;
  if (rules.compensation_group != 0 && ex.modal.g[rules.compensation_group] != rules.compensation_off)
    return ex.alarm(AlarmReason::skip_not_allowed, ex.code_column, std::string(ex.code->name));
  std::uint16_t signals = 0;
  std::int64_t step = 0;
  if (!signals_of(ex, signals, step)) return false;
  std::string feed_parameter;
  if (step > 0 && ex.data.bit(rules.skip_step_feed_parameter)) feed_parameter = std::to_string(6281 + step);
  if (step == 0 && ex.data.bit(rules.skip_feed_parameter)) feed_parameter = "6281";

  const AxisVector from = ex.machine_now;
  std::uint32_t moved = 0;
  if (!ex.take_targets(moved)) return false;
  if (moved == 0) return true;
  double feed = 0;
  FeedUnit unit = FeedUnit::mm_per_minute;
  if (feed_parameter.empty()) {
    if (!ex.cutting_feed(ex.path_to_targets(from, moved), feed, unit)) return false;
  } else {
    feed = ex.data.parameter(feed_parameter);
    if (feed <= 0) return ex.alarm(AlarmReason::feed_missing, ex.code_column, "No." + feed_parameter);
  }
  auto& move = ex.emit<Feed>();
  ex.fill_motion(move, moved);
  move.feed = feed;
  move.unit = unit;
  move.exact_stop = true;
  move.skip_signals = signals;
  move.skip_level = !ex.data.bit(rules.skip_low_parameter);
  move.skip_overridable = unit == FeedUnit::mm_per_revolution || ex.data.bit(rules.skip_override_parameter);
  ex.skip.machine = ex.machine_now;
  ex.skip.triggered = false;
  return true;
}

}  // namespace handlers
}  // namespace headstock::interp

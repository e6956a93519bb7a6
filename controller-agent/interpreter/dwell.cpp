// G04 in all its forms.
#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp::handlers {
namespace {

// X and U without a point count in the least increment: 0.001 s under IS-B (0i-D 4.10).
double seconds(const Executor& ex, const program::Word& word) {
  if (word.point || ex.pocket) return word.value();
  return word.value() / ex.dwell_units_a_second();
}

// P is always without a point; its unit follows the increment system unless a parameter fixes it to 0.001 s.
double p_seconds(const Executor& ex, const program::Word& word, bool turns) {
  const auto& rules = ex.dialect.modes;
  const bool scales = rules.dwell_p_scales && (turns || !ex.data.bit(rules.dwell_ms_parameter));
  return word.value() / (scales ? ex.dwell_units_a_second() : 1000);
}

}  // namespace

bool dwell(Executor& ex) {
  const program::Block& b = ex.block;
  const bool strict = !ex.switches.lenient;
  if (b.has('X') && b.has('P') && ex.dialect.repeated_words == dialects::Repeated::alarm && strict) {
    return ex.alarm(AlarmReason::dwell_words, b['P'].column, "P");
  }
  const bool turns =
      ex.feed_unit == FeedUnit::mm_per_revolution && ex.data.bit(ex.dialect.dwell_turns_parameter);
  double amount = 0;
  bool given = true;
  char letter = 'P';
  if (b.has('X')) {
    letter = 'X';
    amount = seconds(ex, b['X']);
  } else if (b.has('U') && ex.dialect.tools.lathe) {
    letter = 'U';
    amount = seconds(ex, b['U']);
  } else if (b.has('P')) {
    if (b['P'].point && strict) return ex.alarm(AlarmReason::decimal_point, b['P'].column, "P");
    amount = p_seconds(ex, b['P'], turns);
  } else {
    given = false;
  }
  if (amount < 0) return ex.alarm(AlarmReason::minus_sign, b[letter].column, std::string(1, letter));
  std::uint16_t signals = 0;
  const auto& by_q = ex.dialect.modes.skip_signals;
  if (!by_q[0].empty()) {
    if (b.has('Q')) {
      const std::int64_t q = ex.whole('Q', AlarmReason::skip_number);
      if (q < 0) return false;
      if (q >= 1 && q <= 4) signals = ex.assigned_skip_signals(q - 1);
      if (signals == 0) return ex.alarm(AlarmReason::skip_number, b['Q'].column, "Q" + std::to_string(q));
    }
    signals = static_cast<std::uint16_t>(signals | ex.assigned_skip_signals(4));
  }
  auto& pause = ex.emit<Dwell>();  // without an amount: an exact stop
  pause.at = ex.at;
  pause.modal = ex.modal;
  if (given) (turns ? pause.revolutions : pause.seconds) = amount;
  pause.skip_signals = signals;
  return true;
}

}  // namespace headstock::interp::handlers

// Variables that only the machine can answer: signals, clocks, counters (L18930-L19060, L19333-L19369).
#include <cmath>

#include "dialects/k2000tc/language.hpp"

namespace headstock::dialects::k2000tc {

using k2000::Error;

namespace {

constexpr std::uint32_t kInputs = 1'000, kOutputs = 1'100, kSignals = 16, kAll = 32, kSignalsEnd = 2'000;
// M91I and M93I have no address in the manual: the environment's last two inputs stand for them.
constexpr unsigned kJumpInputs[] = {126, 127};

bool is_date(double value) {
  const double month = std::fmod(std::floor(value / 100), 100), day = std::fmod(value, 100);
  return value >= 19'700'101 && value < 100'000'000 && month >= 1 && month <= 12 && day >= 1 && day <= 31;
}
bool is_time(double value) {
  return value >= 0 && value < 240'000 && std::fmod(std::floor(value / 100), 100) < 60 && std::fmod(value, 100) < 60;
}

}  // namespace

bool Language::jump_input(int which) const {
  return ex_.environment->input(kJumpInputs[which]);
}

Error Language::machine_variable(std::uint32_t number, Value& value) {
  const bool is_signal = number < kSignalsEnd;
  if (is_signal && !ex_.environment->has_signals()) return Error::no_variable;  // nobody connected them
  if (ex_.environment->takes_time()) ex_.jumps = ex_.idle_jumps = 0;  // a loop that waits for it is not endless
  const auto signals = [&](std::uint32_t first, const auto& read) {
    if (number >= first && number < first + kSignals) {
      value = Value::of_uint(read(number - first) ? 1 : 0);
      return true;
    }
    if (number != first + kAll) return false;
    std::uint64_t sum = 0;
    for (std::uint32_t i = 0; i < kSignals; ++i) sum |= read(i) ? 1u << i : 0u;
    value = Value::of_uint(sum);
    return true;
  };
  if (signals(kInputs, [this](std::uint32_t i) { return ex_.environment->input(i); })) return Error::none;
  if (signals(kOutputs, [this](std::uint32_t i) { return ex_.environment->output(i); })) return Error::none;
  switch (number) {
    case 3'001:
      value = Value::of_uint(static_cast<std::uint64_t>(std::fmod(ex_.environment->clock_ms(), 4294967296.0)));
      return Error::none;
    case 3'002:
      value = Value::of_float(ex_.environment->clock_hours());
      return Error::none;
    case 3'011:
      value = Value::of_uint(ex_.environment->date());
      return Error::none;
    case 3'012:
      value = Value::of_uint(ex_.environment->time());
      return Error::none;
    case 3'901:
      value = Value::of_uint(static_cast<std::uint64_t>(ex_.environment->parts_made()));
      return Error::none;
    case 3'902:
      value = Value::of_uint(static_cast<std::uint64_t>(ex_.environment->parts_required()));
      return Error::none;
    default:
      return Error::no_variable;
  }
}

Error Language::set_machine_variable(std::uint32_t number, const Value& value) {
  if (number < kSignalsEnd && !ex_.environment->has_signals()) return Error::no_variable;
  const double given = value.number();
  if (number >= kOutputs && number < kOutputs + kSignals) {
    ex_.environment->set_output(number - kOutputs, value.truth());
    return Error::none;
  }
  if (number == kOutputs + kAll) {
    const auto whole = value.integer();
    if (!whole) return Error::whole_needed;
    for (std::uint32_t i = 0; i < kSignals; ++i) ex_.environment->set_output(i, (*whole >> i & 1) != 0);
    return Error::none;
  }
  switch (number) {
    case 3'001:
      ex_.environment->set_clock_ms(given);
      return Error::none;
    case 3'002:
      ex_.environment->set_clock_hours(given);
      return Error::none;
    case 3'901:
      if (!ex_.data.bit("P4100.4")) return Error::no_variable;  // MACN
      ex_.environment->set_parts_made(given);
      return Error::none;
    case 3'011:
    case 3'012:
      // The machine's clock is set by its operating system; a wrong value is the control's alarm all the same.
      if (number == 3'011 ? !is_date(given) : !is_time(given)) raise(ex_, "PS1303", 0, std::to_string(number));
      return Error::no_variable;
    default:
      return Error::no_variable;
  }
}

bool Language::write_out(Executor& ex, std::string text) {
  auto& message = ex.emit<interp::Message>();
  message.at = ex.at;
  message.text = std::move(text);
  message.kind = interp::MessageKind::print;
  return true;
}

}  // namespace headstock::dialects::k2000tc

// The switch at the machine that lets parameters be written. While it is on the control is in an alarm, so
// that nobody forgets it and nothing is machined with half of a new set: 0i-D SW0100 (L39989, L45460), GSK
// 218T 100 (L3512, L7159), GSK 2000TC 100 (L9161). The manuals' two keys together, which silence the alarm
// with the switch left on, are not at Headstock's panel: the switch goes off, then RESET.
#include <algorithm>
#include <string_view>

#include "operation/controller_impl.hpp"

namespace headstock::operation {
namespace {

/// Empty: the control has no such alarm.
std::string_view switch_alarm(std::string_view profile) {
  struct Entry {
    std::string_view profile, code;
  };
  static constexpr Entry kAlarms[] = {
      {"fanuc-0i-t", "SW0100"}, {"fanuc-0i-m", "SW0100"}, {"gsk-218t", "100"}, {"gsk-2000tc", "100"}};
  const auto* found = std::ranges::find(kAlarms, profile, &Entry::profile);
  return found != std::end(kAlarms) ? found->code : std::string_view();
}

}  // namespace

CommandResult Controller::Impl::set_parameter_write(bool on) {
  if (on == parameter_write) return {true, {}};
  // 0i-D 12.3.1: MDI mode or emergency stop; at least no program and no axis may be under way.
  if (on && (busy() || emergency_braking())) return {false, "running"};
  parameter_write = on;
  const std::string_view code = switch_alarm(machine.profile);
  const bool there =
      std::ranges::any_of(alarms, [&](const ActiveAlarm& alarm) { return alarm.code == code; });
  if (on && !code.empty() && !there) raise(std::string(code), {}, {}, {});
  return {true, {}};
}

bool Controller::Impl::stays_until_switched_off(const ActiveAlarm& alarm) const {
  return parameter_write && alarm.code == switch_alarm(machine.profile);
}

CommandResult Controller::set_parameter_write(bool on) {
  Access access(impl_->lock, impl_->waiting);
  return impl_->set_parameter_write(on);
}

}  // namespace headstock::operation

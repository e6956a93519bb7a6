// G20/G21: when the unit may change (0i-D 4.14).
#include <cmath>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp::handlers {
namespace {

// What must be switched off before (L7523): compensation, rotation and the like; G00 or G01; G97.
bool state_allows(const Executor& ex) {
  return ex.motion_code->tenths <= 10 && ex.surface.now.kind == SurfaceKind::none && !ex.polar.on &&
         ex.compensation_is_off() && ex.length_sign == 0 && !ex.transform.active() &&
         !ex.constant_surface_speed;
}

}  // namespace

// Offsets and positions are kept in millimetres: nothing has to be converted. With one of the two parameters
// set the control lays down where and when; without them it trusts the program.
bool select_unit(Executor& ex, bool inch) {
  if (ex.modal.inch == inch) return true;
  const auto& rules = ex.dialect.modes;
  const bool at_reference = ex.data.bit(rules.unit_at_reference_parameter);
  const bool anywhere = ex.data.bit(rules.unit_anywhere_parameter);
  if ((at_reference || anywhere) && !state_allows(ex))
    return ex.alarm(AlarmReason::unit_change, ex.code_column, std::string(ex.code->name));
  if (at_reference && !anywhere) {
    for (std::size_t i = 0; i < ex.axes.size(); ++i) {
      if (!ex.axes[i].rotary && std::fabs(ex.machine_now[i] - ex.machine.axes[i].reference_mm) > 0.0005)
        return ex.alarm(AlarmReason::unit_change_place, ex.code_column, std::string(1, ex.axes[i].name));
    }
  }
  bool shifted = false;
  for (const ProgramAxis& axis : ex.axes) shifted = shifted || axis.zero_shift != 0 || axis.zero_local != 0;
  if ((at_reference || anywhere) && shifted) {
    if (!ex.data.bit(rules.unit_clears_shift_parameter))
      return ex.alarm(AlarmReason::unit_change, ex.code_column, std::string(ex.code->name));
    for (ProgramAxis& axis : ex.axes) axis.zero_shift = axis.zero_local = 0;
    ex.update_zeros();
  }
  ex.set_units(inch);
  ex.feed_mm = -1;  // F means something else now
  return true;
}

}  // namespace headstock::interp::handlers

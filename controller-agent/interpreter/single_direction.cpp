// G60: positioning that always comes from the same side, so that backlash does not show (0i-D No.5440).
#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp::handlers {

// Rapid to a point before the end, then to the end. The sign of the parameter is the direction of the last
// way, its amount the length; 0: that axis is positioned as by G00. Mirror image does not turn the direction
// round.
bool single_direction(Executor& ex) {
  if (ex.data.bit(ex.dialect.modes.approach_modal_parameter)) {  // G60 is then of group 01
    ex.motion_code = ex.code;
    ex.modal.g[1] = ex.code->tenths;
  }
  std::uint32_t moved = 0;
  if (!ex.take_targets(moved)) return false;
  if (moved == 0) return true;
  AxisVector before{};
  bool any = false;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if ((moved >> i & 1u) == 0) continue;
    const double way =
        ex.data.parameter(std::string(ex.dialect.modes.approach_parameter) + '/' + ex.axes[i].name);
    before[i] = ex.page_to_slide(i, way);
    any = any || before[i] != 0;
  }
  auto& last = ex.emit<Rapid>();
  ex.fill_motion(last, moved);
  last.linear = ex.linear_rapid;
  last.exact_stop = true;
  if (!any) return true;
  Rapid first = last;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    first.end_machine[i] -= before[i];
    first.end_work[i] -= before[i] / ex.axes[i].mm_per_unit;
  }
  const Rapid end = last;
  last = first;  // the reference is to the operation that goes out first
  ex.emit<Rapid>() = end;
  return true;
}

}  // namespace headstock::interp::handlers

#include "dialects/gsk-218t/reference_return.hpp"

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::dialects::gsk_218t {

using interp::Executor;

// APRS P006.6: an axis that G28 brought to its reference point stands at P044, P045 [0.001 mm] from then on.
bool reference_return(Executor& ex) {
  if (!interp::handlers::reference_return(ex)) return false;
  if (!ex.data.bit("P006.6")) return true;
  struct Place {
    char axis, step;
    std::string_view parameter;
  };
  for (const Place& place : {Place{'X', 'U', "P044"}, Place{'Z', 'W', "P045"}}) {
    const auto i = ex.axis_named(place.axis);
    if (!i || (!ex.block.has(place.axis) && !ex.block.has(place.step))) continue;
    auto& axis = ex.axes[*i];
    const double wanted = ex.page_to_slide(*i, ex.data.parameter(place.parameter) / 1'000);
    axis.zero_local = 0;
    axis.zero_shift = ex.machine_now[*i] - wanted - axis.zero_external - axis.zero_work - axis.zero_tool;
    ex.update_zero(*i);
  }
  // The last move ends in the new coordinates.
  interp::Operation& made = ex.queue.size() > ex.queue_head ? ex.queue.back() : *ex.out;
  if (auto* motion = std::get_if<interp::Rapid>(&made)) {
    motion->end_work = ex.work_now;
    motion->modal = ex.modal;
  }
  return true;
}

}  // namespace headstock::dialects::gsk_218t

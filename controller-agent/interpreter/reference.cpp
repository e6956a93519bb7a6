// G27…G30: reference points by way of an intermediate point.
#include <bit>
#include <cmath>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp::handlers {
namespace {

double reference_point(const Executor& ex, std::size_t axis, std::int64_t which) {
  const auto& rules = ex.dialect.modes;
  std::string parameter(which == 1 ? rules.first_reference_parameter
                                   : rules.reference_parameters[static_cast<std::size_t>(which - 2)]);
  if (const auto own = parameter.find(std::string(1, ex.axes[axis].name) + ':'); own != parameter.npos) {
    parameter = parameter.substr(own + 2, parameter.find(' ', own) - own - 2);
  } else {
    parameter += '/';
    parameter += ex.axes[axis].name;
  }
  const auto set = ex.data.parameters.find(parameter);
  return set == ex.data.parameters.end() ? ex.machine.axes[axis].reference_mm
                                         : ex.page_to_slide(axis, set->second);
}

// Rapid to the block's point, which is kept per axis for G29.
bool to_intermediate(Executor& ex, std::uint32_t& moved) {
  if (!ex.take_targets(moved)) return false;
  const auto& rules = ex.dialect.compensation;
  const bool keeps =
      rules.keeps_to_intermediate || (!rules.to_intermediate_parameter.empty() &&
                                      ex.data.parameter(rules.to_intermediate_parameter, 1) == 0);
  if (!keeps) ex.pipeline.drop_for_block();
  if (moved == 0) return true;
  auto& motion = ex.emit<Rapid>();
  ex.fill_motion(motion, moved);
  motion.exact_stop = true;
  for (std::uint32_t left = moved; left != 0; left &= left - 1) {
    auto& axis = ex.axes[static_cast<std::size_t>(std::countr_zero(left))];
    axis.intermediate = ex.machine_now[static_cast<std::size_t>(std::countr_zero(left))];
    axis.has_intermediate = true;
  }
  return true;
}

// In rotation, scaling or mirror image a return is only allowed with nothing in its way (0i-D K.6, PS0412):
// no length offset on an axis that is turned along, and no incremental way to the intermediate point.
bool conversion_allows(Executor& ex) {
  if (!ex.transform.active()) return true;
  const auto refuse = [&ex] {
    return ex.alarm(AlarmReason::g_not_now, ex.code_column, std::string(ex.code->name));
  };
  if (!ex.compensation_is_off()) return refuse();
  for (std::uint32_t mask = ex.block.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    const auto axis = static_cast<std::size_t>(ex.axis_of[letter]);
    const bool by = ex.incremental || (ex.incremental_letters >> letter & 1u) != 0;
    if ((by && ex.block.word[letter].digits != 0) || (ex.length_sign != 0 && ex.axes[axis].zero_tool != 0))
      return refuse();
  }
  return true;
}

// Not between the holes of a cycle (0i-D PS0044).
bool cycle_allows(Executor& ex) {
  return ex.cycle.hole.code == nullptr || !ex.dialect.reference_refused_in_cycle ||
         ex.alarm(AlarmReason::reference_in_cycle, ex.code_column, std::string(ex.code->name));
}

bool to_reference(Executor& ex, std::int64_t which) {
  if (!cycle_allows(ex)) return false;
  if (!conversion_allows(ex)) return false;
  std::uint32_t moved = 0;
  if (!to_intermediate(ex, moved)) return false;
  if (moved == 0 && ex.dialect.g28_alone_moves_all) moved = (1u << ex.axes.size()) - 1;
  if (moved == 0) return true;
  AxisVector target = ex.machine_now;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if ((moved >> i & 1u) == 0) continue;
    target[i] = reference_point(ex, i, which);
    if (ex.dialect.reference_cancels_offset && ex.axes[i].zero_tool != 0) {
      tool_offset::drop(ex, i);
    }
  }
  return ex.emit_rapid_to_machine(target, moved, true);
}

}  // namespace

bool reference_return(Executor& ex) {
  return to_reference(ex, 1);
}

bool reference_return_n(Executor& ex) {
  std::int64_t which = 2;
  if (ex.block.has('P')) {
    which = ex.whole('P', AlarmReason::reference_number);
    if (which < 0) return false;
  }
  if (which < 2 || which > 4 ||
      ex.dialect.modes.reference_parameters[static_cast<std::size_t>(which - 2)].empty()) {
    return ex.alarm(AlarmReason::reference_number, ex.block['P'].column, "P" + std::to_string(which));
  }
  return to_reference(ex, which);
}

// G29: by the intermediate point of the last G28/G30 to the block's point.
bool reference_from(Executor& ex) {
  if (!cycle_allows(ex)) return false;
  std::uint32_t named = 0;
  const AxisVector now = ex.machine_now;
  AxisVector middle = now;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if (ex.axes[i].has_intermediate) {
      middle[i] = ex.axes[i].intermediate;
      named |= 1u << i;
    }
  }
  if (named == 0) return ex.alarm(AlarmReason::no_intermediate, ex.code_column, std::string(ex.code->name));
  std::uint32_t wanted = 0;
  for (std::uint32_t mask = ex.block.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    wanted |= 1u << static_cast<unsigned>(ex.axis_of[static_cast<std::size_t>(std::countr_zero(mask))]);
  }
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if ((wanted >> i & 1u) == 0) middle[i] = now[i];
  }
  if ((named & wanted) != 0) ex.emit_rapid_to_machine(middle, named & wanted, false);
  std::uint32_t moved = 0;
  if (!ex.take_targets(moved)) return false;
  if (moved == 0) return true;
  ex.fill_motion(ex.emit<Rapid>(), moved);
  return true;
}

// G27: rapid to the point, then every axis named must stand at its reference point.
bool reference_check(Executor& ex) {
  if (!cycle_allows(ex)) return false;
  std::uint32_t moved = 0;
  if (!ex.take_targets(moved)) return false;
  if (moved != 0) ex.fill_motion(ex.emit<Rapid>(), moved);
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    const bool checked = moved == 0 || (moved >> i & 1u) != 0;
    if (checked && std::fabs(ex.machine_now[i] - reference_point(ex, i, 1)) > 0.0005) {
      return ex.alarm(AlarmReason::reference_check, ex.code_column, std::string(1, ex.axes[i].name));
    }
  }
  return true;
}

}  // namespace headstock::interp::handlers

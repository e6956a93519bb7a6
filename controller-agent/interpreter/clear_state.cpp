// What RESET leaves of the modal state and the coordinate systems: "reset state" or "clear state" (0i-D 3,
// No.3402#6).
#include "interpreter/executor.hpp"

namespace headstock::interp {
namespace {

// Groups that a parameter keeps through the clear state: group n is bit n % 8 of the byte n / 8
// (No.3406…3409).
std::uint32_t kept_groups(const Executor& ex) {
  const auto& bytes = ex.dialect.modes.kept_group_parameters;
  std::uint32_t kept = 0;
  for (unsigned group = 1; group < kModalGroups; ++group) {
    const std::string_view byte = bytes[group / 8];
    if (!byte.empty() && ex.data.bit(std::string(byte) + '#' + std::to_string(group % 8)))
      kept |= 1u << group;
  }
  return kept;
}

constexpr std::uint32_t bit_of(std::uint8_t group) {
  return group == 0 ? 0 : 1u << group;
}

}  // namespace

void Executor::clear_modes() {
  const auto& rules = dialect.modes;
  leave_surface();
  tool_offset::reset(*this);
  data_input = {};
  polygon = false;
  increment_limit = {};  // G91.1 lasts until RESET
  const bool clear = dialect.reset_clears || data.bit(dialect.reset_clears_parameter);
  std::uint32_t keep = 0;
  if (clear) {
    // The unit and stored stroke check 2 are not touched.
    keep = kept_groups(*this) | bit_of(rules.unit_group) | bit_of(rules.stroke_group);
    const auto back = [keep](std::uint8_t group) { return group == 0 || (keep & bit_of(group)) == 0; };
    if (back(rules.rotation_group)) transform.rotated = transform.spatial = false;
    if (back(rules.scaling_group)) transform.scaled = 0;
    if (back(rules.mirror_group)) transform.mirrored = mirror_setting.axes;
    polar.on = polar.on && !back(rules.polar_group);
    power_on(keep);
  } else if (rules.work_group != 0 && data.bit(rules.reset_work_parameter)) {
    if (const GCode* first = table->find(540); first != nullptr && first->handler != nullptr) {
      block.clear();
      code = first;
      modal.g[first->group] = first->tenths;
      first->handler(*this);
    }
  }
  const bool work_returns =
      clear ? (keep & bit_of(rules.work_group)) == 0 : data.bit(rules.reset_work_parameter);
  if (rules.work_group != 0 && (work_returns || data.bit(rules.reset_local_parameter))) {
    for (ProgramAxis& axis : axes) axis.zero_local = 0;
    update_zeros();
  }
}

}  // namespace headstock::interp

// Direct input of measured values (0i-D tool offset and work coordinate pages, 2000TC L8574, 218T L714, 200T
// L835): where the axes stand, what is in force, and what the place shall be called make the new value.
#include <algorithm>
#include <utility>

#include "dialects/dialect.hpp"
#include "interpreter/data_values.hpp"
#include "operation/controller_impl.hpp"
#include "tools/tool_setting.hpp"

namespace headstock::operation {
namespace {

constexpr double kInch_mm = 25.4;

bool in_force(const interp::ModalSnapshot& modal, std::int16_t code) {
  return std::ranges::find(modal.g, code) != modal.g.end();
}

// "work/G54/Z" → 540; 0: one that acts on all systems; -1: none that can be told from the modal codes.
std::int16_t code_of_system(std::string_view what) {
  constexpr std::pair<std::string_view, std::int16_t> kSystems[] = {
      {"work/EXT/", 0},   {"work/shift/", 0}, {"work/G54/", 540}, {"work/G55/", 550},
      {"work/G56/", 560}, {"work/G57/", 570}, {"work/G58/", 580}, {"work/G59/", 590}};
  for (const auto& [name, code] : kSystems)
    if (what.starts_with(name)) return code;
  return -1;
}

}  // namespace

EditResult Controller::Impl::touch(const TouchRequest& request) {
  const auto refuse = [&](std::string_view reason) {
    return EditResult{false, std::string(reason), request.what, data.version};
  };
  const dialects::Dialect& dialect = *dialects::find(machine.profile);
  std::vector<char> names;
  for (const machine::Axis& axis : machine.axes) names.push_back(axis.name);
  const interp::ValueRead old = interp::read_value(data, names, request.what);
  const auto axis = std::ranges::find(names, request.what.empty() ? '?' : request.what.back());
  if (!old.known || axis == names.end()) return refuse("bad_place");
  if (phase != Phase::idle) return refuse("running");
  const Live now = live();
  if (now.machine_lock || now.axis_lock != 0)
    return refuse("wrong_mode");  // the page is not where the slides are

  const interp::ModalSnapshot& modal = interpreter.modal();
  const auto index = static_cast<std::size_t>(axis - names.begin());
  const bool inch = modal.inch && !machine.axes[index].rotary;
  const double shown_mm = now.absolute[index] * (inch ? kInch_mm : 1);

  EditRequest edit;
  edit.origin = "measurement";
  edit.by = request.by;
  if (interp::kind_of_value(request.what) == interp::ValueKind::work) {
    const std::int16_t system = code_of_system(request.what);
    if (system < 0 || (system > 0 && !in_force(modal, system))) return refuse("other_offset");
    edit.values.push_back({request.what, old.value, old.value.value_or(0) + shown_mm - request.place});
    return edit_values(edit);
  }
  if (interp::kind_of_value(request.what) != interp::ValueKind::tool ||
      interp::field_of_value(request.what) != "geometry")
    return refuse("bad_place");

  const auto number = static_cast<std::int32_t>(interp::number_of_value(request.what));
  constexpr std::int16_t kNegativeLength = 440;
  if (!dialect.tools.lathe && in_force(modal, kNegativeLength)) return refuse("other_offset");
  const bool by_tool = dialect.tools.lathe && data.bit(dialect.tools.geometry_by_tool_parameter);
  const std::int32_t geometry_number = by_tool ? modal.tool : modal.offset;
  if (modal.offset != 0 && (modal.offset != number || geometry_number != number))
    return refuse("other_offset");
  std::string wear = request.what;
  wear.replace(wear.find("geometry"), std::string_view("geometry").size(), "wear");
  const std::optional<double> old_wear = interp::read_value(data, names, wear).value;

  // Offsets that count as a radius on an axis whose page shows a diameter.
  const bool halves = machine.axes[index].designation == machine::Designation::diameter &&
                      data.bit(dialect.tool_offsets.radius_parameter);
  const double unit = halves ? 0.5 : 1;
  const double counted = modal.offset == 0 ? 0 : old.value.value_or(0) + old_wear.value_or(0);
  const auto sign = dialect.tools.sign < 0 ? tools::OffsetSign::added : tools::OffsetSign::subtracted;
  const double wanted = tools::measured_offset({shown_mm * unit, request.place * unit, counted}, sign);
  edit.values.push_back({request.what, old.value, wanted});
  if (old_wear.value_or(0) != 0) edit.values.push_back({wear, old_wear, 0});
  return edit_values(edit);
}

EditResult Controller::touch(const TouchRequest& request) {
  Access access(impl_->lock, impl_->waiting);
  return impl_->touch(request);
}

}  // namespace headstock::operation

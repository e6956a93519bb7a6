// System variables of the offset pages: tools, workpiece zero points.
#include <cmath>

#include "interpreter/system_variable_access.hpp"

namespace headstock::interp::system_variables {
// ---- tool offsets

Result read_tool(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  const auto cell = static_cast<ToolCell>(row.detail >> 8);
  const char letter = static_cast<char>(row.detail & 0xff);
  const auto axis = ex.axis_named(letter);
  value = 0;
  const std::size_t number = index + 1;
  if (number > ex.dialect.tools.most_offsets) return Result::failed(AlarmReason::macro_variable);
  if (number >= ex.data.tools.size()) return {};
  const ToolOffset& tool = ex.data.tools[number];
  switch (cell) {
    case ToolCell::geometry:
    case ToolCell::single:
      value = axis ? tool.geometry[*axis] : 0;
      if (cell == ToolCell::single && axis) value += tool.wear[*axis];
      break;
    case ToolCell::wear:
      value = axis ? tool.wear[*axis] : 0;
      break;
    case ToolCell::radius:
      value = tool.radius;
      break;
    case ToolCell::radius_wear:
      value = tool.radius_wear;
      break;
    case ToolCell::tip:
      value = tool.tip;
      return {};
  }
  value /= ex.unit_mm;
  return {};
}

Result write_tool(Executor& ex, const Row& row, std::uint32_t index, double value) {
  const auto cell = static_cast<ToolCell>(row.detail >> 8);
  const char letter = static_cast<char>(row.detail & 0xff);
  const auto axis = ex.axis_named(letter);
  const std::size_t number = index + 1;
  if (number > ex.dialect.tools.most_offsets) return Result::failed(AlarmReason::macro_variable);
  if (!(std::fabs(value) < 1e6)) return Result::failed(AlarmReason::value_range);
  const bool of_axis = cell == ToolCell::geometry || cell == ToolCell::wear || cell == ToolCell::single;
  if (of_axis && !axis) return Result::failed(AlarmReason::macro_variable);
  if (ex.data.tools.size() <= number) ex.data.tools.resize(number + 1);
  ToolOffset& tool = ex.data.tools[number];
  const std::string place = "tool/" + std::to_string(number) + "/";
  const double mm = value * ex.unit_mm;
  switch (cell) {
    case ToolCell::geometry:
      store(ex, tool.geometry[*axis], mm, place + "geometry/" + letter);
      break;
    case ToolCell::wear:
      store(ex, tool.wear[*axis], mm, place + "wear/" + letter);
      break;
    case ToolCell::single:  // one number for everything: length, radius and no wear
      store(ex, tool.geometry[*axis], mm, place + "geometry/" + letter);
      store(ex, tool.wear[*axis], 0, place + "wear/" + letter);
      if (!ex.dialect.tools.lathe) store(ex, tool.radius, mm, place + "radius");
      break;
    case ToolCell::radius:
      store(ex, tool.radius, mm, place + "radius");
      break;
    case ToolCell::radius_wear:
      store(ex, tool.radius_wear, mm, place + "radius_wear");
      break;
    case ToolCell::tip: {
      const double whole = std::floor(value + 0.5);
      if (!(whole >= 0 && whole <= 9)) return Result::failed(AlarmReason::value_range);
      const int before = std::exchange(tool.tip, static_cast<int>(whole));
      if (before != tool.tip) ex.report_change(place + "tip", before, tool.tip);
      break;
    }
  }
  return {};
}

Result read_tool_in_force(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  const char letter = static_cast<char>(row.detail & 0xff);
  const auto named = letter == 0 ? std::optional<std::size_t>(index) : ex.axis_named(letter);
  if (!named || *named >= ex.axes.size()) return Result::failed(AlarmReason::macro_variable);
  const std::size_t axis = *named;
  if (!ex.dialect.tools.lathe) {
    value = ex.axes[axis].zero_tool / ex.axes[axis].mm_per_unit;
    return {};
  }
  const auto wear = static_cast<std::size_t>(std::max(ex.modal.offset, 0));
  const bool by_tool = ex.data.bit(ex.dialect.tools.geometry_by_tool_parameter) && wear != 0;
  const auto shape = by_tool ? static_cast<std::size_t>(std::max(ex.modal.tool, 0)) : wear;
  const auto& tools = ex.data.tools;
  const double worn = wear < tools.size() ? tools[wear].wear[axis] : 0;
  const double formed = shape < tools.size() ? tools[shape].geometry[axis] : 0;
  const bool both = (row.detail & 512) != 0;
  value = ((row.detail & 256) != 0 ? formed : both ? worn + formed : worn) / unit_of(ex, axis);
  return {};
}

// ---- work offsets

namespace {

double* work_cell(Executor& ex, std::int32_t detail, std::uint32_t index, std::size_t& axis,
                  std::string& name) {
  std::size_t system = 0;
  if (detail > 0) {
    axis = static_cast<std::size_t>(detail - 1);
    system = index;
  } else {
    axis = index;
    system = static_cast<std::size_t>(-detail);
  }
  if (axis >= ex.axes.size() || system > 6) return nullptr;
  name = system == 0 ? "work/EXT/" : "work/G" + std::to_string(53 + system) + "/";
  name += ex.axes[axis].name;
  return system == 0 ? &ex.data.work_external[axis] : &ex.data.work[system - 1][axis];
}

double* extra_cell(Executor& ex, std::uint32_t index, std::size_t& axis, std::string& name) {
  const std::size_t p = index / 20;
  axis = index % 20;
  if (p >= 48 || axis >= ex.axes.size()) return nullptr;
  name = "work/G54.1P" + std::to_string(p + 1) + "/" + ex.axes[axis].name;
  return &ex.data.work_extra[p][axis];
}

Result store_work(Executor& ex, double* cell, std::size_t axis, const std::string& name, double value) {
  if (cell == nullptr) return Result::failed(AlarmReason::macro_variable);
  if (!(std::fabs(value) < 1e6)) return Result::failed(AlarmReason::value_range);
  store(ex, *cell, value * unit_of(ex, axis), name);
  ex.update_zeros();
  return {};
}

}  // namespace

Result read_work(Executor& ex, const Row& row, std::uint32_t index, double& value) {
  std::size_t axis = 0;
  std::string name;
  const double* cell = work_cell(ex, row.detail, index, axis, name);
  if (cell == nullptr) return Result::failed(AlarmReason::macro_variable);
  value = *cell / unit_of(ex, axis);
  return {};
}

Result write_work(Executor& ex, const Row& row, std::uint32_t index, double value) {
  std::size_t axis = 0;
  std::string name;
  double* cell = work_cell(ex, row.detail, index, axis, name);
  return store_work(ex, cell, axis, name, value);
}

Result read_extra_work(Executor& ex, const Row&, std::uint32_t index, double& value) {
  std::size_t axis = 0;
  std::string name;
  const double* cell = extra_cell(ex, index, axis, name);
  if (cell == nullptr) return Result::failed(AlarmReason::macro_variable);
  value = *cell / unit_of(ex, axis);
  return {};
}

Result write_extra_work(Executor& ex, const Row&, std::uint32_t index, double value) {
  std::size_t axis = 0;
  std::string name;
  double* cell = extra_cell(ex, index, axis, name);
  return store_work(ex, cell, axis, name, value);
}

Result read_work_shift(Executor& ex, const Row& row, std::uint32_t, double& value) {
  const auto axis = ex.axis_named(static_cast<char>(row.detail));
  if (!axis) return Result::failed(AlarmReason::macro_variable);
  value = ex.data.work_shift[*axis] / unit_of(ex, *axis);
  return {};
}

Result write_work_shift(Executor& ex, const Row& row, std::uint32_t, double value) {
  const auto axis = ex.axis_named(static_cast<char>(row.detail));
  if (!axis) return Result::failed(AlarmReason::macro_variable);
  return store_work(ex, &ex.data.work_shift[*axis], *axis, "work/shift/" + axis_text(ex, *axis), value);
}

}  // namespace headstock::interp::system_variables

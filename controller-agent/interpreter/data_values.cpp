#include "interpreter/data_values.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace headstock::interp {
namespace {

using tools::LifeGroup;
using tools::LifeTool;
using tools::LifeUnit;

/// A name cut at its slashes; a parameter's second half ("1241/X") counts as one more part.
struct Parts {
  std::array<std::string_view, 4> part;
  std::size_t count = 0;
};

Parts cut(std::string_view what) {
  Parts parts;
  while (parts.count < parts.part.size()) {
    const std::size_t slash = what.find('/');
    parts.part[parts.count++] = what.substr(0, slash);
    if (slash == what.npos) return parts;
    what.remove_prefix(slash + 1);
  }
  return {};
}

std::optional<std::uint32_t> whole(std::string_view text) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty() || text.size() > 6)
    return std::nullopt;
  return number;
}

/// A whole number from 0; nothing for half ones, what is not finite, and what is larger than `most`.
std::optional<std::int64_t> whole(double value, double most) {
  if (!(value >= 0 && value <= most) || value != std::floor(value)) return std::nullopt;
  return static_cast<std::int64_t>(value);
}

std::optional<std::size_t> axis_index(const std::vector<char>& names, std::string_view text) {
  if (text.size() != 1) return std::nullopt;
  const auto found = std::ranges::find(names, text[0]);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

template <class Data>
auto* zero_offset(Data& data, std::string_view system) {
  using Zero = std::remove_reference_t<decltype((data.work_external))>;
  Zero* none = nullptr;
  if (system == "EXT") return &data.work_external;
  if (system == "shift") return &data.work_shift;
  if (system.size() == 3 && system.starts_with("G5") && system[2] >= '4' && system[2] <= '9')
    return &data.work[static_cast<std::size_t>(system[2] - '4')];
  if (system.starts_with("G54.1P")) {
    const auto number = whole(system.substr(6));
    if (number && *number >= 1 && *number <= data.work_extra.size()) return &data.work_extra[*number - 1];
  }
  return none;
}

/// The number of a tool's value, whichever field it is; the tip is read and written apart.
template <class Tool>
auto* tool_cell(Tool& tool, const Parts& parts, const std::vector<char>& names) {
  using Cell = std::remove_reference_t<decltype((tool.radius))>;
  Cell* none = nullptr;
  if (parts.count == 3 && parts.part[2] == "radius") return &tool.radius;
  if (parts.count == 3 && parts.part[2] == "radius_wear") return &tool.radius_wear;
  if (parts.count != 4) return none;
  const auto axis = axis_index(names, parts.part[3]);
  if (!axis) return none;
  if (parts.part[2] == "geometry") return &tool.geometry[*axis];
  if (parts.part[2] == "wear") return &tool.wear[*axis];
  return none;
}

double from_unit(std::int64_t amount, LifeUnit unit) {
  return unit == LifeUnit::uses ? static_cast<double>(amount) : static_cast<double>(amount) / 10;
}

std::optional<std::int64_t> to_unit(double value, LifeUnit unit) {
  return unit == LifeUnit::uses ? whole(value, 1e9) : whole(std::round(value * 10), 1e9);
}

/// Whole-number fields of a tool in a life group.
struct LifeField {
  std::string_view name;
  std::int32_t LifeTool::*field;
};
constexpr LifeField kLifeFields[] = {
    {"tool", &LifeTool::tool}, {"offset", &LifeTool::offset}, {"h", &LifeTool::h}, {"d", &LifeTool::d}};
constexpr std::size_t kMostLifeTools = 999;

ValueRead read_life(const MachineData& data, const Parts& parts) {
  const auto number = whole(parts.part[1]);
  if (!number || *number == 0 || parts.count < 3) return {};
  const auto group_number = static_cast<std::int32_t>(*number);
  const LifeGroup* group = data.tool_life.find(group_number);
  const std::string_view field = parts.part[2];
  if (parts.count == 3) {
    if (field != "unit" && field != "life" && field != "current") return {};
    if (group == nullptr) return {true, std::nullopt};
    if (field == "unit") return {true, group->unit == LifeUnit::uses ? 0 : 1};
    if (field == "life") return {true, from_unit(group->life, group->unit)};
    return {true, static_cast<double>(group->current)};
  }
  const auto entry = whole(parts.part[3]);
  if (!entry || *entry >= kMostLifeTools) return {};
  const bool there = group != nullptr && *entry < group->tools.size();
  const auto answer = [there](auto value) -> ValueRead {
    return {true, there ? std::optional<double>(value()) : std::nullopt};
  };
  if (field == "used") return answer([&] { return from_unit(group->tools[*entry].used, group->unit); });
  if (field == "skipped") return answer([&] { return group->tools[*entry].skipped ? 1.0 : 0.0; });
  for (const LifeField& one : kLifeFields)
    if (field == one.name)
      return answer([&] { return static_cast<double>(group->tools[*entry].*(one.field)); });
  return {};
}

bool write_life_tool(LifeGroup& group, std::string_view field, std::size_t entry,
                     std::optional<double> value) {
  if (!value) {  // the last tool of the group can be taken off
    if (field != "tool" || entry + 1 != group.tools.size()) return false;
    group.tools.pop_back();
    group.current = std::min(group.current, group.tools.empty() ? 0 : group.tools.size() - 1);
    return true;
  }
  if (entry > group.tools.size() || entry >= kMostLifeTools) return false;
  if (entry == group.tools.size() && field != "tool") return false;
  LifeTool made = entry < group.tools.size() ? group.tools[entry] : LifeTool{};
  if (field == "used") {
    const auto used = to_unit(*value, group.unit);
    if (!used) return false;
    made.used = *used;
  } else if (field == "skipped") {
    if (*value != 0 && *value != 1) return false;
    made.skipped = *value == 1;
  } else {
    const auto* known = std::ranges::find(kLifeFields, field, &LifeField::name);
    const auto number = whole(*value, 99'999'999);
    if (known == std::end(kLifeFields) || !number) return false;
    made.*(known->field) = static_cast<std::int32_t>(*number);
  }
  if (entry == group.tools.size())
    group.tools.push_back(made);
  else
    group.tools[entry] = made;
  return true;
}

bool write_life(MachineData& data, const Parts& parts, std::optional<double> value) {
  const auto number = whole(parts.part[1]);
  if (!number || *number == 0 || *number > 9'999 || parts.count < 3) return false;
  const auto group_number = static_cast<std::int32_t>(*number);
  auto& groups = data.tool_life.groups;
  const std::string_view field = parts.part[2];
  if (field == "life" && parts.count == 3 && !value) return groups.erase(group_number) != 0;
  if (parts.count == 4) {
    const auto entry = whole(parts.part[3]);
    LifeGroup* group = data.tool_life.find(group_number);
    return entry && group != nullptr && write_life_tool(*group, field, *entry, value);
  }
  if (!value) return false;
  const bool is_new = !groups.contains(group_number);
  LifeGroup made = is_new ? LifeGroup{} : groups.at(group_number);
  if (field == "unit") {
    if (*value != 0 && *value != 1) return false;
    if (is_new) made.life = 1;  // until its life is written
    const LifeUnit unit = *value == 0 ? LifeUnit::uses : LifeUnit::tenths;
    if (unit != made.unit && !made.tools.empty())
      return false;  // counts of one unit are no counts of the other
    made.unit = unit;
  } else if (field == "life") {
    const auto life = to_unit(*value, made.unit);
    if (!life || *life == 0) return false;
    made.life = *life;
  } else if (field == "current") {
    const auto current = whole(*value, kMostLifeTools);
    if (is_new || !current || static_cast<std::size_t>(*current) >= made.tools.size()) return false;
    made.current = static_cast<std::size_t>(*current);
  } else {
    return false;
  }
  groups[group_number] = std::move(made);
  return true;
}

std::string_view parameter_key(std::string_view what) {
  return what.substr(std::string_view("parameter/").size());
}

bool good_parameter_key(std::string_view key) {
  return !key.empty() && key.size() <= 40 &&
         key.find_first_not_of("0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ#./-") == key.npos;
}

}  // namespace

ValueKind kind_of_value(std::string_view what) {
  struct Prefix {
    std::string_view text;
    ValueKind kind;
  };
  static constexpr Prefix kPrefixes[] = {{"tool/", ValueKind::tool},
                                         {"work/", ValueKind::work},
                                         {"parameter/", ValueKind::parameter},
                                         {"variable/", ValueKind::variable},
                                         {"tool_life/", ValueKind::tool_life}};
  for (const Prefix& prefix : kPrefixes)
    if (what.starts_with(prefix.text) && what.size() > prefix.text.size()) return prefix.kind;
  return ValueKind::none;
}

std::uint32_t number_of_value(std::string_view what) {
  const Parts parts = cut(what);
  return parts.count >= 2 ? whole(parts.part[1]).value_or(0) : 0;
}

std::string_view field_of_value(std::string_view what) {
  const Parts parts = cut(what);
  return parts.count >= 3 && parts.part[0] == "tool" ? parts.part[2] : std::string_view();
}

ValueRead read_value(const MachineData& data, const std::vector<char>& axis_names, std::string_view what) {
  const Parts parts = cut(what);
  switch (kind_of_value(what)) {
    case ValueKind::tool: {
      const auto number = whole(parts.part[1]);
      if (!number || *number == 0) return {};
      static const ToolOffset kEmpty;
      const ToolOffset& tool = *number < data.tools.size() ? data.tools[*number] : kEmpty;
      if (parts.count == 3 && parts.part[2] == "tip") return {true, tool.tip};
      const double* cell = tool_cell(tool, parts, axis_names);
      if (cell == nullptr) return {};
      return {true, *cell};
    }
    case ValueKind::work: {
      const AxisVector* zero = zero_offset(data, parts.part[1]);
      const auto axis = axis_index(axis_names, parts.part[2]);
      if (zero == nullptr || !axis || parts.count != 3) return {};
      return {true, (*zero)[*axis]};
    }
    case ValueKind::parameter: {
      const std::string_view key = parameter_key(what);
      if (!good_parameter_key(key)) return {};
      const auto found = data.parameters.find(key);
      return {true, found != data.parameters.end() ? std::optional(found->second) : std::nullopt};
    }
    case ValueKind::variable: {
      const auto number = whole(parts.part[1]);
      if (!number || parts.count != 2) return {};
      const auto found = data.common_variables.find(*number);
      return {true, found != data.common_variables.end() ? std::optional(found->second) : std::nullopt};
    }
    case ValueKind::tool_life:
      return read_life(data, parts);
    case ValueKind::none:
      break;
  }
  return {};
}

bool write_value(MachineData& data, const std::vector<char>& axis_names, std::string_view what,
                 std::optional<double> value, std::size_t most_tools) {
  if (value && !std::isfinite(*value)) return false;
  const Parts parts = cut(what);
  switch (kind_of_value(what)) {
    case ValueKind::tool: {
      const auto number = whole(parts.part[1]);
      if (!number || *number == 0 || *number > most_tools || !value) return false;
      ToolOffset tool = *number < data.tools.size() ? data.tools[*number] : ToolOffset{};
      if (parts.count == 3 && parts.part[2] == "tip") {
        const auto tip = whole(*value, 9);
        if (!tip) return false;
        tool.tip = static_cast<int>(*tip);
      } else {
        double* cell = tool_cell(tool, parts, axis_names);
        if (cell == nullptr) return false;
        *cell = *value;
      }
      if (data.tools.size() <= *number) data.tools.resize(*number + std::size_t{1});
      data.tools[*number] = tool;
      return true;
    }
    case ValueKind::work: {
      AxisVector* zero = zero_offset(data, parts.part[1]);
      const auto axis = axis_index(axis_names, parts.part[2]);
      if (zero == nullptr || !axis || parts.count != 3 || !value) return false;
      (*zero)[*axis] = *value;
      return true;
    }
    case ValueKind::parameter: {
      const std::string_view key = parameter_key(what);
      if (!good_parameter_key(key)) return false;
      if (value)
        data.parameters[std::string(key)] = *value;
      else if (const auto found = data.parameters.find(key); found != data.parameters.end())
        data.parameters.erase(found);
      return true;
    }
    case ValueKind::variable: {
      const auto number = whole(parts.part[1]);
      if (!number || parts.count != 2) return false;
      if (value)
        data.common_variables[*number] = *value;
      else
        data.common_variables.erase(*number);
      return true;
    }
    case ValueKind::tool_life:
      return write_life(data, parts, value);
    case ValueKind::none:
      break;
  }
  return false;
}

void each_value(const MachineData& data, const std::vector<char>& axis_names,
                const std::function<void(const std::string& what, double value)>& row) {
  const auto if_set = [&row](const std::string& what, double value) {
    if (value != 0) row(what, value);
  };
  const auto axes = [&](const std::string& place, const AxisVector& values) {
    for (std::size_t i = 0; i < axis_names.size() && i < values.size(); ++i)
      if_set(place + axis_names[i], values[i]);
  };
  axes("work/EXT/", data.work_external);
  axes("work/shift/", data.work_shift);
  for (std::size_t i = 0; i < data.work.size(); ++i)
    axes("work/G" + std::to_string(54 + i) + "/", data.work[i]);
  for (std::size_t i = 0; i < data.work_extra.size(); ++i)
    axes("work/G54.1P" + std::to_string(i + 1) + "/", data.work_extra[i]);
  for (std::size_t i = 1; i < data.tools.size(); ++i) {
    const ToolOffset& tool = data.tools[i];
    const std::string place = "tool/" + std::to_string(i) + "/";
    axes(place + "geometry/", tool.geometry);
    axes(place + "wear/", tool.wear);
    if_set(place + "radius", tool.radius);
    if_set(place + "radius_wear", tool.radius_wear);
    if_set(place + "tip", tool.tip);
  }
  for (const auto& [key, value] : data.parameters) row("parameter/" + key, value);
  for (const auto& [number, value] : data.common_variables) row("variable/" + std::to_string(number), value);
  for (const auto& [number, group] : data.tool_life.groups) {
    const std::string place = "tool_life/" + std::to_string(number) + "/";
    row(place + "unit", group.unit == LifeUnit::uses ? 0 : 1);
    row(place + "life", from_unit(group.life, group.unit));
    row(place + "current", static_cast<double>(group.current));
    for (std::size_t i = 0; i < group.tools.size(); ++i) {
      const std::string entry = "/" + std::to_string(i);
      for (const LifeField& field : kLifeFields)
        row(place + std::string(field.name) + entry, group.tools[i].*(field.field));
      row(place + "used" + entry, from_unit(group.tools[i].used, group.unit));
      row(place + "skipped" + entry, group.tools[i].skipped ? 1 : 0);
    }
  }
}

}  // namespace headstock::interp

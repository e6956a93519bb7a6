#include "agent/retained.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "dialects/data_rules.hpp"
#include "interpreter/data_values.hpp"
#include "link/live_json.hpp"

namespace headstock::agent {
namespace {

using nlohmann::json;
constexpr const char* kCounters = "counters";
constexpr const char* kSelected = "selected";
constexpr const char* kData = "data";

std::vector<char> axis_names(const machine::Machine& machine) {
  std::vector<char> names;
  for (const machine::Axis& axis : machine.axes) names.push_back(axis.name);
  return names;
}

json parsed(const link::Spool& spool, const char* key) {
  const auto text = spool.retained(key);
  if (!text) return nullptr;
  json value = json::parse(*text, nullptr, false);
  if (!value.is_object())
    throw std::runtime_error(std::string("the stored value '") + key + "' cannot be read");
  return value;
}

json breakpoint_json(const operation::Breakpoint& at) {
  if (at.program.empty()) return nullptr;
  return {{"program", at.program}, {"sha256", at.revision_hash}, {"block", at.block}, {"sequence", at.sequence},
          {"line", at.line}};
}

/// Rows behind the last one with anything in it need not be kept.
void drop_empty_rows(std::vector<interp::ToolOffset>& tools) {
  const auto empty = [](const interp::ToolOffset& tool) {
    const auto zero = [](double value) { return value == 0; };
    return std::ranges::all_of(tool.geometry, zero) && std::ranges::all_of(tool.wear, zero) && tool.radius == 0 &&
           tool.radius_wear == 0 && tool.tip == 0;
  };
  while (!tools.empty() && empty(tools.back())) tools.pop_back();
}

std::map<std::string, double> values_of(const interp::MachineData& data, const machine::Machine& machine) {
  std::map<std::string, double> values;
  interp::each_value(data, axis_names(machine),
                     [&values](const std::string& what, double value) { values[what] = value; });
  return values;
}

double value_in(const std::map<std::string, double>& values, const std::string& what) {
  const auto found = values.find(what);
  return found != values.end() ? found->second : std::nan("");
}

}  // namespace

link::RetainedValue counters_value(const operation::Retained& r) {
  const json value = {{"parts", r.parts},
                      {"parts_total", r.parts_total},
                      {"parts_required", r.parts_required},
                      {"last_run", r.last_run},
                      {"last_alarm", r.last_alarm},
                      {"feed_override", r.feed_override},
                      {"rapid_override", r.rapid_override},
                      {"spindle_override", r.spindle_override},
                      {"run_open", r.run_open},
                      {"breakpoint", breakpoint_json(r.breakpoint)}};
  return {kCounters, value.dump(-1, ' ', false, json::error_handler_t::replace)};
}

operation::Retained read_counters(const link::Spool& spool) {
  const json value = parsed(spool, kCounters);
  operation::Retained r;
  if (value.is_null()) return r;
  r.parts = value.value("parts", r.parts);
  r.parts_total = value.value("parts_total", r.parts_total);
  r.parts_required = value.value("parts_required", r.parts_required);
  r.last_run = value.value("last_run", r.last_run);
  r.last_alarm = value.value("last_alarm", r.last_alarm);
  r.feed_override = value.value("feed_override", r.feed_override);
  r.rapid_override = value.value("rapid_override", r.rapid_override);
  r.spindle_override = value.value("spindle_override", r.spindle_override);
  r.run_open = value.value("run_open", false);
  if (const auto found = value.find("breakpoint"); found != value.end() && found->is_object()) {
    r.breakpoint.program = found->value("program", "");
    r.breakpoint.revision_hash = found->value("sha256", "");
    r.breakpoint.block = found->value("block", 0u);
    r.breakpoint.sequence = found->value("sequence", 0u);
    r.breakpoint.line = found->value("line", 0u);
  }
  return r;
}

link::RetainedValue selected_value(const SelectedProgram& selected) {
  if (selected.name.empty()) return {kSelected, std::nullopt};
  return {kSelected, json{{"name", selected.name}, {"sha256", selected.sha256}}.dump()};
}

SelectedProgram read_selected(const link::Spool& spool) {
  const json value = parsed(spool, kSelected);
  if (value.is_null()) return {};
  return {value.value("name", ""), value.value("sha256", "")};
}

link::RetainedValue data_value(interp::MachineData data, const machine::Machine& machine) {
  drop_empty_rows(data.tools);
  json variables = json::object();
  for (const auto& [number, value] : data.common_variables) variables[std::to_string(number)] = value;
  json names = json::object();
  for (const auto& [number, name] : data.variable_names) names[std::to_string(number)] = name;
  const json value = {{"offsets", json::parse(interp::offsets_to_json(data, axis_names(machine)))},
                      {"parameters", data.parameters},
                      {"variables", std::move(variables)},
                      {"variable_names", std::move(names)},
                      {"version", data.version}};
  return {kData, value.dump()};
}

interp::MachineData read_data(const link::Spool& spool, const machine::Machine& machine, Variables which) {
  const auto* dialect = dialects::find(machine.profile);
  // Every row is there from the start: while a program runs no row can be added under the look-ahead's hands.
  const auto with_rows = [dialect](interp::MachineData read) {
    const std::size_t rows = dialect != nullptr ? dialect->tools.most_offsets + 1 : 0;
    if (read.tools.size() < rows) read.tools.resize(rows);
    return read;
  };
  interp::MachineData data;
  const json value = parsed(spool, kData);
  if (value.is_null()) return with_rows(std::move(data));
  std::string problem = interp::load_offsets(value.at("offsets").dump(), axis_names(machine), data);
  if (problem.empty()) problem = interp::load_parameters(value.at("parameters").dump(), data);
  if (!problem.empty())
    throw std::runtime_error("the stored offsets and parameters cannot be read: " + problem);
  const dialects::OffsetPage page = dialect != nullptr ? dialects::offset_page(*dialect, data) : dialects::OffsetPage{};
  for (const auto& [name, number_value] : value.at("variables").items()) {
    const auto number = static_cast<std::uint32_t>(std::stoul(name));
    const bool kept = number >= page.first_kept && number <= page.last_kept;
    if (kept || which == Variables::all) data.common_variables[number] = number_value.get<double>();
  }
  const json names = value.value("variable_names", json::object());
  for (const auto& [number, name] : names.items())
    data.variable_names[static_cast<std::uint32_t>(std::stoul(number))] = name.get<std::string>();
  data.version = value.value("version", std::uint64_t{0});
  return with_rows(std::move(data));
}

void store_power_on(link::Spool& spool, const interp::MachineData& now, const machine::Machine& machine) {
  const bool first = !spool.retained(kData);
  const interp::MachineData stored = read_data(spool, machine, Variables::all);
  const auto before = values_of(stored, machine), after = values_of(now, machine);
  auto places = before;
  places.insert(after.begin(), after.end());
  const auto at = std::chrono::system_clock::now().time_since_epoch();
  const auto at_ms = std::chrono::duration_cast<std::chrono::milliseconds>(at).count();
  std::vector<link::NewEvent> events;
  for (const auto& [what, value] : places) {
    const double then = value_in(before, what), is = value_in(after, what);
    const bool same = then == is || (std::isnan(then) && std::isnan(is));
    if (!first && !same)
      events.push_back(
          link::to_new_event({at_ms, operation::OffsetChanged{{what, then, is, ""}, "power_on"}}));
  }
  if (events.empty() && now.version == stored.version) return;
  const link::RetainedValue value = data_value(now, machine);
  spool.commit(events, {&value, 1});
}

}  // namespace headstock::agent

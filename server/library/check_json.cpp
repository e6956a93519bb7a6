#include <nlohmann/json.hpp>

#include "db/time.hpp"
#include "server/library/checks.hpp"

namespace headstock::library {

using nlohmann::json;

json to_json(const CheckResult& result) {
  json findings = json::array(), bounds = json::object();
  for (const Finding& finding : result.findings)
    findings.push_back({{"line", finding.line},
                        {"column", finding.column},
                        {"code", finding.code},
                        {"text", {{"en", finding.en}, {"zh", finding.zh}}}});
  json life = json::array();
  for (const CheckResult::Life& one : result.life)
    life.push_back({{"group", one.group}, {"unit", one.unit}, {"need", one.need}});
  for (const AxisBounds& axis : result.bounds) bounds[axis.axis] = {axis.min_mm, axis.max_mm};
  return {{"ok", result.ok},
          {"findings", std::move(findings)},
          {"time_s", result.time_s},
          {"cutting_s", result.cutting_s},
          {"length_mm", result.length_mm},
          {"timed", result.timed},
          {"blocks", result.blocks},
          {"bounds", std::move(bounds)},
          {"tools", result.tools},
          {"life", std::move(life)},
          {"machine", result.machine},
          {"at", db::iso_time(result.at_ms)},
          {"at_ms", result.at_ms}};
}

CheckResult check_result_from_json(const json& from) {
  CheckResult result;
  result.ok = from.value("ok", false);
  for (const auto& finding : from.value("findings", json::array()))
    result.findings.push_back({finding.value("line", std::int64_t{0}),
                               finding.value("column", std::int64_t{0}), finding.value("code", ""),
                               finding.at("text").value("en", ""), finding.at("text").value("zh", "")});
  result.time_s = from.value("time_s", 0.0);
  result.cutting_s = from.value("cutting_s", 0.0);
  result.length_mm = from.value("length_mm", 0.0);
  result.timed = from.value("timed", true);
  result.blocks = from.value("blocks", std::int64_t{0});
  const json bounds = from.value("bounds", json::object());
  for (const auto& [axis, range] : bounds.items())
    result.bounds.push_back({axis, range.at(0).get<double>(), range.at(1).get<double>()});
  result.tools = from.value("tools", std::vector<std::int64_t>{});
  for (const auto& one : from.value("life", json::array()))
    result.life.push_back({one.value("group", std::int64_t{0}), one.value("unit", ""), one.value("need", 0.0)});
  result.machine = from.value("machine", std::int64_t{0});
  result.at_ms = from.value("at_ms", std::int64_t{0});
  return result;
}

}  // namespace headstock::library

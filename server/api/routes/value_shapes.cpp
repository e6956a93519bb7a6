#include "server/api/routes/value_shapes.hpp"

namespace headstock::api {

json to_json(const db::ValueItem& item) {
  json out = {{"what", item.what}, {"before", number_json(item.before)}, {"after", number_json(item.after)}};
  if (item.was_read) out["read_back"] = number_json(item.read_back);
  return out;
}

json to_json(const db::ValueRequestRow& r) {
  json values = json::array();
  for (const db::ValueItem& item : r.items) values.push_back(to_json(item));
  return {{"id", r.id},
          {"machine", r.machine},
          {"by", r.by},
          {"at", time_json(r.at_ms)},
          {"origin", r.origin},
          {"why", r.why},
          {"state", r.state},
          {"needs_second", r.needs_second.empty() ? json(nullptr) : json(r.needs_second)},
          {"second", r.second.empty() ? json(nullptr) : json(r.second)},
          {"second_at", time_json(r.second_ms)},
          {"reason", r.reason.empty() ? json(nullptr) : json(r.reason)},
          {"where", r.where.empty() ? json(nullptr) : json(r.where)},
          {"ended", time_json(r.ended_ms)},
          {"values", std::move(values)}};
}

json to_json(const db::ValueChangeRow& c) {
  return {{"id", c.id},
          {"machine", c.machine},
          {"at", time_json(c.at_ms)},
          {"received", time_json(c.received_ms)},
          {"what", c.what},
          {"before", number_json(c.before)},
          {"after", number_json(c.after)},
          {"origin", c.origin},
          {"by", c.by.empty() ? json(nullptr) : json(c.by)},
          {"request", c.request != 0 ? json(c.request) : json(nullptr)}};
}

json to_json(const db::SnapshotRow& s) {
  return {{"id", s.id}, {"machine", s.machine},       {"profile", s.profile}, {"name", s.name},
          {"by", s.by}, {"at", time_json(s.at_ms)}, {"values", s.values}};
}

json to_json(const dialects::OffsetPage& page, const std::vector<char>& axes) {
  json names = json::array();
  for (const char axis : axes) names.push_back(std::string(1, axis));
  return {{"axes", std::move(names)},
          {"numbers", page.numbers},
          {"lathe", page.lathe},
          {"memory", std::string(1, page.memory)},
          {"wear", page.wear},
          {"largest_mm", page.largest_mm},
          {"largest_wear_mm", page.largest_wear_mm},
          {"tips", page.tips},
          {"work_systems", page.work_systems},
          {"extra_systems", page.extra_systems},
          {"variables", {{page.first_variable, page.last_volatile}, {page.first_kept, page.last_kept}}}};
}

json to_json(const fleet::SheetRow& row) {
  json out = to_json(row.item);
  out["line"] = row.line;
  out["problem"] = row.problem.empty() ? json(nullptr) : json(row.problem);
  out["text"] = row.text;
  return out;
}

json to_json(const fleet::LifeGroupView& g) {
  json tools = json::array();
  for (const fleet::LifeToolView& tool : g.tools)
    tools.push_back({{"tool", tool.tool},
                     {"offset", tool.offset},
                     {"h", tool.h},
                     {"d", tool.d},
                     {"used", tool.used},
                     {"mark", tool.mark}});
  return {{"machine", g.machine},
          {"machine_name", g.machine_name},
          {"group", g.group},
          {"unit", g.unit},
          {"life", g.life},
          {"current", g.current},
          {"left_current", g.left_current},
          {"left_total", g.left_total},
          {"change_due", g.change_due},
          {"notice", g.notice},
          {"per_part", number_json(g.per_part)},
          {"parts_left", number_json(g.parts_left)},
          {"next_change_s", number_json(g.next_change_s)},
          {"tools", std::move(tools)}};
}

json to_json(const fleet::LifeNeed& need) {
  return {{"group", need.group}, {"unit", need.unit}, {"need", need.need}, {"left", need.left}};
}

json to_json(const fleet::Disagreement& d) {
  return {{"id", d.id},
          {"machine", d.machine},
          {"at", time_json(d.at_ms)},
          {"kind", d.kind},
          {"counted", d.counted},
          {"witness", d.witness},
          {"run", d.run},
          {"seen_by", d.seen_by.empty() ? json(nullptr) : json(d.seen_by)},
          {"seen", time_json(d.seen_ms)}};
}

json to_json(const fleet::Recount& r) {
  return {{"machine", r.machine},
          {"machine_name", r.name},
          {"events", r.events},
          {"missing", r.missing},
          {"parts", r.parts},
          {"parts_stored", r.parts_stored},
          {"runs", r.runs},
          {"runs_stored", r.runs_stored},
          {"runs_open", r.runs_open},
          {"identical", r.differences.empty()},
          {"differences", r.differences}};
}

json to_json(const fleet::Order& o) {
  return {{"id", o.id},
          {"name", o.name},
          {"machine", o.machine != 0 ? json(o.machine) : json(nullptr)},
          {"program", o.program},
          {"required", o.required},
          {"from", time_json(o.from_ms)},
          {"by", o.by},
          {"closed", time_json(o.closed_ms)},
          {"closed_by", o.closed_by.empty() ? json(nullptr) : json(o.closed_by)},
          {"made", o.made},
          {"rejected", o.rejected}};
}

}  // namespace headstock::api

#include "server/fleet/values.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "db/hash.hpp"
#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "dialects/dialect.hpp"
#include "interpreter/data_values.hpp"
#include "machine/machine.hpp"
#include "server/access/audit.hpp"
#include "server/fleet/event_body.hpp"
#include "server/fleet/writing_order.hpp"

namespace headstock::fleet {
namespace {

using nlohmann::json;

using body::real;
using body::text;

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> parts;
  std::istringstream stream(path);
  for (std::string part; std::getline(stream, part, '/');) parts.push_back(part);
  return parts;
}

/// Where a value stands in the document of offsets; empty: it does not belong there.
std::vector<std::string> place_in_document(const std::string& what) {
  std::vector<std::string> parts = split(what);
  if (parts.size() < 3) return {};
  if (parts[0] == "tool") {
    parts[0] = "tools";
    return parts;
  }
  if (parts[0] != "work") return {};
  if (parts[1] == "EXT") return {"external", parts[2]};
  if (parts[1] == "shift") return {"shift", parts[2]};
  return parts;
}

/// Groups of tool life with fresh tools: what a program needs of them does not depend on what is used of them
/// now.
json fresh_tool_life(const db::MachineValues& values) {
  interp::MachineData data;
  for (const auto& [what, value] : in_writing_order(values)) {
    const LifePlace place = life_place(what);
    if (place.group != 0 && place.field != "used" && place.field != "skipped" && place.field != "current")
      interp::write_value(data, {}, what, value, 0);
  }
  json document = json::object();
  for (const auto& [number_, group] : data.tool_life.groups) {
    json tools = json::array();
    for (const tools::LifeTool& tool : group.tools)
      tools.push_back({{"tool", tool.tool}, {"offset", tool.offset}, {"h", tool.h}, {"d", tool.d}});
    const bool uses = group.unit == tools::LifeUnit::uses;
    document[std::to_string(number_)] = {
        {"unit", uses ? "uses" : "seconds"},
        {"life", uses ? json(group.life) : json(static_cast<double>(group.life) / 10)},
        {"tools", std::move(tools)}};
  }
  return document;
}

bool matters_to_checks(const std::string& what) {
  return what.starts_with("parameter/") || what.starts_with("variable/");
}

bool exactly_same(std::optional<double> a, std::optional<double> b) {
  if (!a || !b) return a.value_or(0) == b.value_or(0) && a.has_value() == b.has_value();
  return std::fabs(*a - *b) <= 1e-9 * std::max(1.0, std::fabs(*a));
}

/// Offsets are 0 when nothing is said of them; everything else is then not set.
bool zero_when_absent(const std::string& what) {
  return what.starts_with("tool/") || what.starts_with("work/");
}

/// Counted on between two events, and signals made of them: no history of their own.
bool counts_by_itself(const std::string& what) {
  return what.starts_with("tool_life/") &&
         (what.find("/used/") != what.npos || what == "tool_life/change_due" ||
          what == "tool_life/notice_group");
}

}  // namespace

void record_change(db::Database& db, const db::EventRow& event, const json& told) {
  db::ValueChangeRow change;
  change.machine = event.machine;
  change.spool = event.spool;
  change.sequence = event.sequence;
  change.at_ms = event.at_ms;
  change.received_ms = event.received_ms;
  change.what = text(told, "what");
  change.before = real(told, "before");
  change.after = real(told, "after");
  change.origin = text(told, "origin");
  change.by = text(told, "by");
  change.request = body::integer(told, "request");
  if (change.what.empty()) return;
  // G10 L3 and the life page take whole groups in and out.
  const LifePlace life = life_place(change.what);
  if ((life.field == "registered" && change.after.value_or(0) == 0) || (life.field == "life" && !change.after))
    db.execute("DELETE FROM machine_values WHERE machine_id = ? AND what LIKE ?",
               {change.machine, change.what.substr(0, change.what.size() - life.field.size()) + "%"});
  db::insert_value_change(db, change);
  db::put_value(db, change.machine, change.what, change.after, change.spool, event.sequence, change.at_ms);
  if (change.request <= 0) return;
  // The answer to this request was lost, or came too late; the machine's own record says that it was carried
  // out.
  const std::string unanswered = "(state = 'unknown' OR (state = 'failed' AND reason = 'not_carried_out'))";
  db.execute(
      "UPDATE value_request_items SET read_back = ?, was_read = 1 WHERE request_id = ? AND what = ? AND "
      "EXISTS (SELECT 1 FROM value_requests WHERE id = request_id AND machine_id = ? AND " +
          unanswered + ")",
      {change.after, change.request, change.what, change.machine});
  db.execute(
      "UPDATE value_requests SET state = 'done', reason = '', ended_ms = ? WHERE id = ? AND machine_id = ? "
      "AND " +
          unanswered +
          " AND NOT EXISTS (SELECT 1 FROM value_request_items i WHERE i.request_id = value_requests.id AND "
          "i.was_read = 0)",
      {event.received_ms, change.request, change.machine});
}

void rebuild_offsets(db::Database& db, std::int64_t machine, std::int64_t now_ms) {
  json document = json::object();
  const db::MachineValues values = db::machine_values(db, machine);
  std::string others;
  for (const auto& [what, value] : values) {
    if (matters_to_checks(what)) others += what + "=" + std::to_string(value) + ";";
    const std::vector<std::string> place = place_in_document(what);
    if (place.empty()) continue;
    json* at = &document;
    for (const std::string& key : place) {
      if (!at->is_object() && !at->is_null()) break;
      at = &(*at)[key];
    }
    *at = value;
  }
  if (json life = fresh_tool_life(values); !life.empty()) document["tool_life"] = std::move(life);
  const std::string made = document.dump();
  const std::string key = db::sha256_hex(others);
  const auto setting = "machine/" + std::to_string(machine) + "/checked_values";
  const auto row = db::machine(db, machine);
  const auto before = db.text("SELECT value FROM settings WHERE key = ?", {setting});
  const bool other = !row || row->offsets_json != made || before != key;
  db.execute(
      "INSERT INTO settings (key, value) VALUES (?, ?) ON CONFLICT (key) DO UPDATE SET value = "
      "excluded.value",
      {setting, key});
  db.execute(
      "UPDATE machines SET offsets_json = ?, offsets_version = offsets_version + ?, offsets_at_ms = ? WHERE "
      "id = ?",
      {made, other ? 1 : 0, now_ms, machine});
}

std::int64_t reconcile(db::Database& db, std::int64_t machine, const std::string& spool, const json& report,
                       std::int64_t now_ms) {
  const auto found = report.find("values");
  const std::int64_t sequence = body::integer(report, "sequence");
  if (found == report.end() || !found->is_object()) return 0;
  db::Transaction transaction(db);
  const auto row = db::machine(db, machine);
  const bool known = row && row->offsets_at_ms.has_value();
  const db::MachineValues ours = db::machine_values(db, machine);
  std::int64_t differences = 0;
  const auto differs = [&](const std::string& what, std::optional<double> before,
                           std::optional<double> after) {
    if (!counts_by_itself(what)) {
      db::ValueChangeRow change;
      change.machine = machine;
      change.spool = spool;
      change.at_ms = change.received_ms = now_ms;
      change.what = what;
      change.before = before;
      change.after = after;
      change.origin = "found";
      db::insert_value_change(db, change);
      ++differences;
    }
    db::put_value(db, machine, what, after, spool, sequence, now_ms);
  };
  for (const auto& [what, value] : found->items()) {
    if (!value.is_number() || what.size() > 80) continue;
    const auto mine = ours.find(what);
    std::optional<double> before;
    if (mine != ours.end())
      before = mine->second;
    else if (zero_when_absent(what))
      before = 0;
    if (!exactly_same(before, value.get<double>())) differs(what, before, value.get<double>());
  }
  for (const auto& [what, value] : ours) {
    if (found->contains(what) || what == "tool_life/change_due" || what == "tool_life/notice_group" ||
        what.ends_with("/registered"))
      continue;
    if (!zero_when_absent(what))
      differs(what, value, std::nullopt);
    else if (value != 0)
      differs(what, value, 0);
  }
  rebuild_offsets(db, machine, now_ms);
  transaction.commit();
  return known ? differences : 0;
}

bool same_as_shown(std::optional<double> a, std::optional<double> b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return std::fabs(*a - *b) <= 5e-7;
}

MachinePages machine_pages(db::Database& db, std::int64_t id) {
  MachinePages pages;
  const auto row = db::machine(db, id);
  if (!row) throw db::Refusal("not_found", access::subject("machine", id));
  pages.machine = *row;
  if (row->toml.empty()) {
    if (const auto standard = machine::default_machine(row->profile))
      for (const machine::Axis& axis : standard->axes) pages.axes.push_back(axis.name);
  } else {
    const auto parsed = machine::parse_machine(row->toml, row->name, row->profile);
    if (const auto* error = std::get_if<machine::MachineError>(&parsed))
      throw db::Refusal("bad_machine_file", error->message);
    for (const machine::Axis& axis : std::get<machine::Machine>(parsed).axes) pages.axes.push_back(axis.name);
  }
  pages.dialect = dialects::find(row->profile);
  if (pages.dialect == nullptr) throw db::Refusal("bad_profile", row->profile.substr(0, 60));
  for (const auto& [what, value] : in_writing_order(db::machine_values(db, id)))
    interp::write_value(pages.data, pages.axes, what, value, pages.dialect->tools.most_offsets);
  pages.page = dialects::offset_page(*pages.dialect, pages.data);
  return pages;
}

bool in_kind(const std::string& kind, const std::string& what) {
  if (kind.empty()) return true;
  struct Kind {
    std::string_view name, prefix;
  };
  static constexpr Kind kKinds[] = {{"offsets", "tool/"},
                                    {"work", "work/"},
                                    {"parameters", "parameter/"},
                                    {"variables", "variable/"},
                                    {"tool_life", "tool_life/"}};
  for (const Kind& one : kKinds)
    if (one.name == kind) return what.starts_with(one.prefix);
  return false;
}

std::string limit_kind(const std::string& what) {
  switch (interp::kind_of_value(what)) {
    case interp::ValueKind::tool: {
      const std::string_view field = interp::field_of_value(what);
      if (field == "tip") return {};
      if (field == "wear" || field == "radius_wear") return "wear";
      return field == "radius" ? "radius" : "geometry";
    }
    case interp::ValueKind::work:
      return "work";
    case interp::ValueKind::parameter:
      return "parameter";
    case interp::ValueKind::variable:
      return "variable";
    case interp::ValueKind::tool_life:
      return what.find("/used/") == what.npos ? "" : "tool_life";
    case interp::ValueKind::none:
      break;
  }
  return {};
}

}  // namespace headstock::fleet

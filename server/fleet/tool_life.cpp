#include "server/fleet/tool_life.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "server/access/audit.hpp"
#include "server/fleet/values.hpp"

namespace headstock::fleet {
namespace {

using nlohmann::json;

constexpr const char* kPolicy = "tool_life.short";
constexpr std::int64_t kLately = 50;  // parts

double in_unit(std::int64_t amount, tools::LifeUnit unit) {
  return unit == tools::LifeUnit::uses ? static_cast<double>(amount) : static_cast<double>(amount) / 10;
}

/// The last parts of a machine: since when, how many, how far apart.
struct Pace {
  std::int64_t since_ms = 0, parts = 0;
  double seconds_a_part = 0;
};

Pace pace_of(db::Database& db, std::int64_t machine) {
  Pace pace;
  double cycles = 0;
  db.each("SELECT at_ms, cycle_s FROM parts WHERE machine_id = ? ORDER BY at_ms DESC LIMIT " +
              std::to_string(kLately),
          {machine}, [&](const db::Row& row) {
            pace.since_ms = row.integer(0) - static_cast<std::int64_t>(row.real(1) * 1000);
            cycles += row.real(1);
            ++pace.parts;
          });
  if (pace.parts > 0) pace.seconds_a_part = cycles / static_cast<double>(pace.parts);
  return pace;
}

/// What each group has used since a moment, by the changes the machine told.
std::map<std::int64_t, double> used_since(db::Database& db, std::int64_t machine, std::int64_t since_ms) {
  std::map<std::int64_t, double> used;
  db.each(
      "SELECT what, before_value, after_value FROM value_changes WHERE machine_id = ? AND at_ms >= ? AND what "
      "LIKE 'tool_life/%/used/%' AND by_user = ''",
      {machine, since_ms}, [&](const db::Row& row) {
        const std::string what = row.text(0);
        const std::size_t field = what.find("/used/");
        if (field == what.npos) return;
        const double grown = row.real(2) - row.real(1);
        if (grown > 0) used[std::atoll(what.c_str() + 10)] += grown;
      });
  return used;
}

LifeGroupView view_of(const MachinePages& pages, std::int64_t number, const tools::LifeGroup& group) {
  LifeGroupView view;
  view.machine = pages.machine.id;
  view.machine_name = pages.machine.name;
  view.group = number;
  view.unit = group.unit == tools::LifeUnit::uses ? "uses" : "seconds";
  view.life = in_unit(group.life, group.unit);
  view.current = static_cast<std::int64_t>(group.current);
  if (!group.tools.empty()) view.left_current = in_unit(tools::remaining(group), group.unit);
  view.change_due = tools::all_spent(group);
  std::vector<std::int32_t> seen;
  for (std::size_t i = 0; i < group.tools.size(); ++i) {
    const tools::LifeTool& tool = group.tools[i];
    LifeToolView one{tool.tool, tool.offset, tool.h, tool.d, in_unit(tool.used, group.unit), ""};
    const char mark = static_cast<char>(tools::mark(group, i));
    if (mark != ' ') one.mark = std::string(1, mark);
    // Offsets of one tool share its life: it is there once.
    if (!tool.skipped && std::ranges::find(seen, tool.tool) == seen.end()) {
      view.left_total += std::max(0.0, view.life - one.used);
      seen.push_back(tool.tool);
    }
    view.tools.push_back(std::move(one));
  }
  return view;
}

}  // namespace

std::vector<LifeGroupView> tool_life(db::Database& db, std::int64_t machine, std::int64_t /*now_ms*/) {
  std::vector<LifeGroupView> views;
  for (const db::MachineRow& row : db::machines(db)) {
    if (machine != 0 && row.id != machine) continue;
    const MachinePages pages = machine_pages(db, row.id);
    if (pages.data.tool_life.groups.empty()) continue;
    const Pace pace = pace_of(db, row.id);
    const auto used =
        pace.parts > 0 ? used_since(db, row.id, pace.since_ms) : std::map<std::int64_t, double>();
    const auto values = db::machine_values(db, row.id);
    const auto notice = values.find("tool_life/notice_group");
    for (const auto& [number, group] : pages.data.tool_life.groups) {
      LifeGroupView view = view_of(pages, number, group);
      view.notice = notice != values.end() && notice->second == static_cast<double>(number);
      if (const auto found = used.find(number); found != used.end() && found->second > 0) {
        view.per_part = found->second / static_cast<double>(pace.parts);
        view.parts_left = view.left_current / *view.per_part;
        view.next_change_s = *view.parts_left * pace.seconds_a_part;
      }
      views.push_back(std::move(view));
    }
  }
  if (machine == 0)
    std::ranges::stable_sort(views, {}, [](const LifeGroupView& view) {
      return view.change_due ? -1 : view.next_change_s.value_or(std::numeric_limits<double>::max());
    });
  return views;
}

std::string to_string(ShortLife policy) {
  return policy == ShortLife::refuse ? "refuse" : policy == ShortLife::warn ? "warn" : "off";
}

ShortLife short_life_policy(db::Database& db) {
  const std::string kept = db.text("SELECT value FROM settings WHERE key = ?", {kPolicy}).value_or("refuse");
  return kept == "warn" ? ShortLife::warn : kept == "off" ? ShortLife::off : ShortLife::refuse;
}

void set_short_life_policy(db::Database& db, const access::Actor& actor, const std::string& policy) {
  demand(actor, access::Action::edit_offsets);
  if (policy != "refuse" && policy != "warn" && policy != "off") throw db::Refusal("bad_value", "short_life");
  db::Transaction transaction(db);
  db.execute(
      "INSERT INTO settings (key, value) VALUES (?, ?) ON CONFLICT (key) DO UPDATE SET value = "
      "excluded.value",
      {kPolicy, policy});
  access::record(db, actor, "tool_life.policy", "shop", {{"short_life", policy}});
  transaction.commit();
}

std::vector<LifeNeed> short_lives(db::Database& db, std::int64_t machine, const std::string& resident) {
  std::vector<LifeNeed> found;
  const auto checked = db.text(
      "SELECT c.result_json FROM checks c JOIN residents r ON r.sha256 = c.sha256 WHERE r.machine_id = ? AND "
      "r.name = ? "
      "AND c.machine_id = ? ORDER BY c.id DESC LIMIT 1",
      {machine, resident, machine});
  if (!checked) return found;
  const json result = json::parse(*checked, nullptr, false);
  if (!result.is_object() || !result.contains("life") || result["life"].empty()) return found;
  const auto groups = tool_life(db, machine, 0);
  for (const json& one : result["life"]) {
    LifeNeed need{one.value("group", std::int64_t{0}), one.value("unit", ""), one.value("need", 0.0), 0};
    const auto group = std::ranges::find(groups, need.group, &LifeGroupView::group);
    if (group == groups.end()) continue;  // the machine itself raises its alarm for a missing group
    need.left = group->left_total;
    if (need.need > need.left) found.push_back(std::move(need));
  }
  return found;
}

}  // namespace headstock::fleet

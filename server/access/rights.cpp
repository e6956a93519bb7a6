#include "server/access/rights.hpp"

#include <algorithm>

#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "db/user_store.hpp"
#include "server/access/audit.hpp"

namespace headstock::access {

bool Rights::holds(const Grant& grant, std::int64_t machine) const {
  if (!grant.machines) return true;
  if (machine == kAnyMachine) return !grant.machines->empty();
  return std::ranges::find(*grant.machines, machine) != grant.machines->end();
}

Role Rights::role_on(std::int64_t machine) const {
  Role role = base_;
  for (const Grant& grant : grants_)
    if (grant.role && holds(grant, machine)) role = std::max(role, *grant.role);
  return role;
}

bool Rights::may(Action action, std::int64_t machine) const {
  bool allowed = includes(role_on(machine), required(action));
  for (const Grant& grant : grants_) {
    if (grant.action != action) continue;
    // Forbidden on one machine says nothing about "any machine".
    if (!grant.allow && (!grant.machines || machine != kAnyMachine) && holds(grant, machine)) return false;
    if (grant.allow && holds(grant, machine)) allowed = true;
  }
  return allowed;
}

std::map<std::int64_t, Role> Rights::raised() const {
  std::map<std::int64_t, Role> found;
  const Role everywhere = role_on(kNoMachine);
  for (const Grant& grant : grants_)
    if (grant.role && grant.machines)
      for (const std::int64_t machine : *grant.machines)
        if (const Role role = role_on(machine); role > everywhere) found[machine] = role;
  return found;
}

std::shared_ptr<const Rights> rights_of(db::Database& db, std::int64_t user, Role base) {
  const auto rows = db::grants(db, user);
  std::vector<Rights::Grant> grants;
  const auto members = rows.empty() ? decltype(db::granted_members(db, user)){} : db::granted_members(db, user);
  for (const db::GrantRow& row : rows) {
    Rights::Grant grant;
    if (row.machine != 0) grant.machines = std::vector<std::int64_t>{row.machine};
    if (row.group != 0) {
      grant.machines.emplace();
      for (const auto& [group, machine] : members)
        if (group == row.group) grant.machines->push_back(machine);
    }
    if (!row.role.empty()) grant.role = role_from(row.role);
    if (!row.action.empty()) grant.action = action_from(row.action);
    grant.allow = row.allow;
    // An action that an older or newer version knew: nothing is allowed by it.
    if (!grant.role && !grant.action) continue;
    grants.push_back(std::move(grant));
  }
  return std::make_shared<const Rights>(base, std::move(grants));
}

namespace {

void demand_sound(db::Database& db, const db::GrantRow& grant) {
  if (grant.machine != 0 && grant.group != 0) throw db::Refusal("bad_value", "group");
  if (grant.machine != 0 && !db::machine(db, grant.machine))
    throw db::Refusal("not_found", "machine:" + std::to_string(grant.machine));
  if (grant.group != 0 && std::ranges::none_of(db::machine_groups(db), [&](const db::GroupRow& row) { return row.id == grant.group; }))
    throw db::Refusal("not_found", "group:" + std::to_string(grant.group));
  if (grant.role.empty() == grant.action.empty()) throw db::Refusal("bad_value", "action");
  if (!grant.role.empty() && (!role_from(grant.role) || grant.role == "viewer" || !grant.allow))
    throw db::Refusal("bad_role", grant.role);
  if (!grant.action.empty() && !action_from(grant.action)) throw db::Refusal("bad_value", grant.action);
}

/// Somebody must be left who can give the right back.
void demand_other_keeper(db::Database& db) {
  for (const db::UserRow& row : db::users(db)) {
    if (row.disabled) continue;
    if (rights_of(db, row.id, role_from(row.role).value_or(Role::viewer))->may(Action::manage_users, kNoMachine)) return;
  }
  throw db::Refusal("last_administrator");
}

std::string described(const db::GrantRow& grant) {
  std::string text = grant.allow ? "" : "not ";
  text += grant.role.empty() ? grant.action : grant.role;
  if (grant.machine != 0) text += " on machine:" + std::to_string(grant.machine);
  if (grant.group != 0) text += " on group:" + std::to_string(grant.group);
  return text;
}

}  // namespace

void set_grants(db::Database& db, const Actor& actor, std::int64_t user, const std::vector<db::GrantRow>& grants) {
  demand(actor, Action::manage_users);
  db::Transaction transaction(db);
  const auto row = db::user(db, user);
  if (!row) throw db::Refusal("not_found", subject("user", user));
  std::string all;
  for (const db::GrantRow& grant : grants) {
    demand_sound(db, grant);
    all += (all.empty() ? "" : "; ") + described(grant);
  }
  db::replace_grants(db, user, grants);
  demand_other_keeper(db);
  record(db, actor, "user.grants", subject("user", user), {{"user", row->user}, {"grants", all}});
  transaction.commit();
}

std::int64_t put_group(db::Database& db, const Actor& actor, const db::GroupRow& group) {
  demand(actor, Action::manage_users);
  if (group.name.empty() || group.name.size() > 100) throw db::Refusal("bad_name", "name");
  db::Transaction transaction(db);
  bool known = group.id == 0;
  for (const db::GroupRow& other : db::machine_groups(db)) {
    if (other.id == group.id) known = true;
    if (other.id != group.id && other.name == group.name) throw db::Refusal("name_taken", group.name);
  }
  if (!known) throw db::Refusal("not_found", "group:" + std::to_string(group.id));
  std::string members;
  for (const std::int64_t machine : group.machines) {
    if (!db::machine(db, machine)) throw db::Refusal("not_found", "machine:" + std::to_string(machine));
    members += (members.empty() ? "" : " ") + std::to_string(machine);
  }
  const std::int64_t id = db::put_machine_group(db, group);
  record(db, actor, "machine_group.put", subject("group", id), {{"name", group.name}, {"machines", members}});
  transaction.commit();
  return id;
}

void remove_group(db::Database& db, const Actor& actor, std::int64_t id) {
  demand(actor, Action::manage_users);
  db::Transaction transaction(db);
  const auto groups = db::machine_groups(db);
  const auto found = std::ranges::find(groups, id, &db::GroupRow::id);
  if (found == groups.end()) throw db::Refusal("not_found", subject("group", id));
  if (db.integer("SELECT 1 FROM alarm_rules WHERE group_id = ? AND removed_ms IS NULL", {id})) throw db::Refusal("in_use", found->name);
  db.execute("UPDATE alarm_rules SET group_id = NULL WHERE group_id = ?", {id});
  db::remove_machine_group(db, id);
  demand_other_keeper(db);
  record(db, actor, "machine_group.remove", subject("group", id), {{"name", found->name}});
  transaction.commit();
}

}  // namespace headstock::access

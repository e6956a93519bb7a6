#include "server/access/role.hpp"

#include <algorithm>
#include <array>

#include "db/refusal.hpp"
#include "server/access/rights.hpp"

namespace headstock::access {
namespace {

constexpr std::array<std::string_view, 5> kRoles = {"viewer", "operator", "programmer", "setter",
                                                    "administrator"};

// In the order of the enumeration; checked below.
constexpr Permission kPermissions[] = {
    {Action::look, "look", Role::viewer},
    {Action::change_own_password, "change_own_password", Role::viewer},
    {Action::command_machine, "command_machine", Role::operator_},
    {Action::select_program, "select_program", Role::operator_},
    {Action::open_drip, "open_drip", Role::operator_},
    {Action::cancel_transfer, "cancel_transfer", Role::operator_},
    {Action::upload_program, "upload_program", Role::programmer},
    {Action::arrange_programs, "arrange_programs", Role::programmer},
    {Action::check_program, "check_program", Role::programmer},
    {Action::send_program, "send_program", Role::programmer},
    {Action::delete_resident, "delete_resident", Role::programmer},
    {Action::release_program, "release_program", Role::setter},
    {Action::withdraw_release, "withdraw_release", Role::setter},
    {Action::edit_machine, "edit_machine", Role::setter},
    {Action::edit_offsets, "edit_offsets", Role::setter},
    {Action::edit_calendar, "edit_calendar", Role::setter},
    {Action::note_downtime, "note_downtime", Role::operator_},
    {Action::manage_machines, "manage_machines", Role::administrator},
    {Action::enrol_machine, "enrol_machine", Role::administrator},
    {Action::manage_users, "manage_users", Role::administrator},
    {Action::read_audit, "read_audit", Role::administrator},
    {Action::acknowledge_alarm, "acknowledge_alarm", Role::operator_},
    {Action::edit_alarm_rules, "edit_alarm_rules", Role::setter},
    {Action::backup_machine, "backup_machine", Role::setter},
    {Action::restore_machine, "restore_machine", Role::setter},
    {Action::manage_backups, "manage_backups", Role::administrator},
    {Action::change_settings, "change_settings", Role::administrator},
};

constexpr bool in_order() {
  for (std::size_t i = 0; i < std::size(kPermissions); ++i)
    if (static_cast<std::size_t>(kPermissions[i].action) != i) return false;
  return std::size(kPermissions) == static_cast<std::size_t>(Action::change_settings) + 1;
}
static_assert(in_order());

const Permission& permission(Action action) {
  return kPermissions[static_cast<std::size_t>(action)];
}

}  // namespace

std::string_view to_string(Role role) {
  return kRoles[static_cast<std::size_t>(role)];
}

std::optional<Role> role_from(std::string_view text) {
  const auto* found = std::ranges::find(kRoles, text);
  if (found == kRoles.end()) return std::nullopt;
  return static_cast<Role>(found - kRoles.begin());
}

std::span<const Permission> permissions() {
  return kPermissions;
}

Role required(Action action) {
  return permission(action).role;
}

std::optional<Action> action_from(std::string_view name) {
  const auto* found = std::ranges::find(kPermissions, name, &Permission::name);
  if (found == std::end(kPermissions)) return std::nullopt;
  return found->action;
}

void demand(const Actor& actor, Action action) {
  const auto may = [&](std::int64_t machine) { return actor.rights->may(action, machine); };
  const bool allowed = !actor.rights            ? includes(actor.role, required(action))
                       : actor.machines.empty() ? may(kNoMachine)
                                                : std::ranges::all_of(actor.machines, may);
  if (!allowed) throw db::Refusal("forbidden", std::string(permission(action).name));
}

}  // namespace headstock::access

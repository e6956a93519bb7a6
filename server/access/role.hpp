// The five roles, each including the ones before it, and the one table that says which action needs which.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace headstock::access {

enum class Role { viewer, operator_, programmer, setter, administrator };

std::string_view to_string(Role role);
std::optional<Role> role_from(std::string_view text);
/// Does a person with `has` do what `needs` may?
constexpr bool includes(Role has, Role needs) {
  return has >= needs;
}

enum class Action {
  look,
  change_own_password,
  command_machine,
  select_program,
  open_drip,
  cancel_transfer,
  upload_program,
  arrange_programs,
  check_program,
  send_program,
  delete_resident,
  release_program,
  withdraw_release,
  edit_machine,
  edit_offsets,
  edit_calendar,
  note_downtime,
  manage_machines,
  enrol_machine,
  manage_users,
  read_audit,
  acknowledge_alarm,
  edit_alarm_rules,
  backup_machine,
  restore_machine,
  manage_backups,
  change_settings
};

struct Permission {
  Action action;
  std::string_view name;
  Role role;
};
/// The whole table, for documentation and tests.
std::span<const Permission> permissions();
std::optional<Action> action_from(std::string_view name);
Role required(Action action);

class Rights;

/// Who does something: for permissions and for the audit trail.
struct Actor {
  std::int64_t user_id = 0;  ///< 0: the server itself
  std::string user = "server";
  Role role = Role::administrator;
  std::string address;  ///< where the request came from
  /// What was granted beyond the role; nothing: the role alone counts.
  std::shared_ptr<const Rights> rights{};
  /// The machines this is about, empty: none. `role` is the least the person has on them.
  std::vector<std::int64_t> machines{};
};
/// Throws Refusal{forbidden} when the actor may not.
void demand(const Actor& actor, Action action);

}  // namespace headstock::access

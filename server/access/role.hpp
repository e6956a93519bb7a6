// The five roles, each including the ones before it, and the one table that says which action needs which.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

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
  read_audit
};

struct Permission {
  Action action;
  std::string_view name;
  Role role;
};
/// The whole table, for documentation and tests.
std::span<const Permission> permissions();
Role required(Action action);

/// Who does something: for permissions and for the audit trail.
struct Actor {
  std::int64_t user_id = 0;  ///< 0: the server itself
  std::string user = "server";
  Role role = Role::administrator;
  std::string address;  ///< where the request came from
};
/// Throws Refusal{forbidden} when the actor may not.
void demand(const Actor& actor, Action action);

}  // namespace headstock::access

// Groups of machines, what persons may do on them, screens that only look, and addresses that guess passwords. Plain
// rows; the rules are in server/access. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"

namespace headstock::db {

struct GroupRow {
  std::int64_t id = 0;
  std::string name;
  std::vector<std::int64_t> machines;
};
std::vector<GroupRow> machine_groups(Database& db);
/// id 0: a new one. Replaces the members. @return its id.
std::int64_t put_machine_group(Database& db, const GroupRow& group);
/// With its members and grants.
void remove_machine_group(Database& db, std::int64_t id);

struct GrantRow {
  std::int64_t id = 0, user = 0;
  std::int64_t machine = 0, group = 0;  ///< both 0: everywhere
  std::string role;                     ///< empty: `action` is named instead
  std::string action;
  bool allow = true;  ///< false: may not, whatever the role says (actions only)
};
std::vector<GrantRow> grants(Database& db, std::int64_t user);
/// Replaces all of the user's.
void replace_grants(Database& db, std::int64_t user, const std::vector<GrantRow>& grants);
/// Machines of the groups that the user's grants name: (group, machine).
std::vector<std::pair<std::int64_t, std::int64_t>> granted_members(Database& db, std::int64_t user);

struct ViewTokenRow {
  std::int64_t id = 0;
  std::string name, token_sha256, by;
  std::int64_t created_ms = 0;
  std::optional<std::int64_t> expires_ms, last_used_ms;
};
std::vector<ViewTokenRow> view_tokens(Database& db);
std::int64_t insert_view_token(Database& db, const ViewTokenRow& token);
/// Not revoked; expiry is for the caller.
std::optional<ViewTokenRow> view_token(Database& db, const std::string& token_sha256);
void touch_view_token(Database& db, std::int64_t id, std::int64_t at_ms);
/// @return false when there is none.
bool revoke_view_token(Database& db, std::int64_t id, std::int64_t at_ms);

struct AddressRow {
  std::string address;
  std::int64_t failures = 0, locked_until_ms = 0, last_ms = 0;
};
std::optional<AddressRow> failing_address(Database& db, const std::string& address);
void put_failing_address(Database& db, const AddressRow& row);
void forget_failing_addresses(Database& db, std::int64_t before_ms);

std::optional<std::string> setting(Database& db, const std::string& key);
void put_setting(Database& db, const std::string& key, const std::string& value);

}  // namespace headstock::db

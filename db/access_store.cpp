#include "db/access_store.hpp"

#include <algorithm>

namespace headstock::db {

std::vector<GroupRow> machine_groups(Database& db) {
  std::vector<GroupRow> found;
  db.each("SELECT id, name FROM machine_groups ORDER BY name, id", {},
          [&](const Row& row) { found.push_back({row.integer(0), row.text(1), {}}); });
  db.each("SELECT group_id, machine_id FROM machine_group_members ORDER BY machine_id", {}, [&](const Row& row) {
    const auto group = std::ranges::find(found, row.integer(0), &GroupRow::id);
    if (group != found.end()) group->machines.push_back(row.integer(1));
  });
  return found;
}

std::int64_t put_machine_group(Database& db, const GroupRow& group) {
  Transaction transaction(db);
  std::int64_t id = group.id;
  if (id == 0)
    id = *db.integer("INSERT INTO machine_groups (name) VALUES (?) RETURNING id", {group.name});
  else
    db.execute("UPDATE machine_groups SET name = ? WHERE id = ?", {group.name, id});
  db.execute("DELETE FROM machine_group_members WHERE group_id = ?", {id});
  for (const std::int64_t machine : group.machines)
    db.execute("INSERT INTO machine_group_members (group_id, machine_id) VALUES (?, ?) ON CONFLICT DO NOTHING",
               {id, machine});
  transaction.commit();
  return id;
}

void remove_machine_group(Database& db, std::int64_t id) {
  Transaction transaction(db);
  db.execute("DELETE FROM machine_group_members WHERE group_id = ?", {id});
  db.execute("DELETE FROM grants WHERE group_id = ?", {id});
  db.execute("DELETE FROM machine_groups WHERE id = ?", {id});
  transaction.commit();
}

std::vector<GrantRow> grants(Database& db, std::int64_t user) {
  std::vector<GrantRow> found;
  db.each("SELECT id, user_id, machine_id, group_id, role, action, allow FROM grants WHERE user_id = ? ORDER BY id",
          {user}, [&](const Row& row) {
            found.push_back({row.integer(0), row.integer(1), row.integer(2), row.integer(3), row.text(4), row.text(5),
                             row.flag(6)});
          });
  return found;
}

void replace_grants(Database& db, std::int64_t user, const std::vector<GrantRow>& grants) {
  Transaction transaction(db);
  db.execute("DELETE FROM grants WHERE user_id = ?", {user});
  for (const GrantRow& grant : grants)
    db.execute("INSERT INTO grants (user_id, machine_id, group_id, role, action, allow) VALUES (?, ?, ?, ?, ?, ?)",
               {user, grant.machine != 0 ? Value(grant.machine) : Value(), grant.group != 0 ? Value(grant.group) : Value(),
                grant.role, grant.action, grant.allow});
  transaction.commit();
}

std::vector<std::pair<std::int64_t, std::int64_t>> granted_members(Database& db, std::int64_t user) {
  std::vector<std::pair<std::int64_t, std::int64_t>> found;
  db.each("SELECT m.group_id, m.machine_id FROM machine_group_members m WHERE m.group_id IN "
          "(SELECT group_id FROM grants WHERE user_id = ? AND group_id IS NOT NULL)",
          {user}, [&](const Row& row) { found.emplace_back(row.integer(0), row.integer(1)); });
  return found;
}

namespace {

constexpr const char* kViewToken =
    "SELECT id, name, token_sha256, by_user, created_ms, expires_ms, last_used_ms FROM view_tokens WHERE revoked_ms IS NULL";

ViewTokenRow view_token_of(const Row& row) {
  return {row.integer(0), row.text(1), row.text(2), row.text(3), row.integer(4), row.maybe_integer(5), row.maybe_integer(6)};
}

}  // namespace

std::vector<ViewTokenRow> view_tokens(Database& db) {
  std::vector<ViewTokenRow> found;
  db.each(std::string(kViewToken) + " ORDER BY id", {}, [&](const Row& row) { found.push_back(view_token_of(row)); });
  return found;
}

std::int64_t insert_view_token(Database& db, const ViewTokenRow& token) {
  return *db.integer(
      "INSERT INTO view_tokens (name, token_sha256, by_user, created_ms, expires_ms) VALUES (?, ?, ?, ?, ?) RETURNING id",
      {token.name, token.token_sha256, token.by, token.created_ms, token.expires_ms});
}

std::optional<ViewTokenRow> view_token(Database& db, const std::string& token_sha256) {
  std::optional<ViewTokenRow> found;
  db.each(std::string(kViewToken) + " AND token_sha256 = ?", {token_sha256},
          [&](const Row& row) { found = view_token_of(row); });
  return found;
}

void touch_view_token(Database& db, std::int64_t id, std::int64_t at_ms) {
  db.execute("UPDATE view_tokens SET last_used_ms = ? WHERE id = ?", {at_ms, id});
}

bool revoke_view_token(Database& db, std::int64_t id, std::int64_t at_ms) {
  return db.execute("UPDATE view_tokens SET revoked_ms = ? WHERE id = ? AND revoked_ms IS NULL", {at_ms, id}) > 0;
}

std::optional<AddressRow> failing_address(Database& db, const std::string& address) {
  std::optional<AddressRow> found;
  db.each("SELECT address, failures, locked_until_ms, last_ms FROM sign_in_failures WHERE address = ?", {address},
          [&](const Row& row) { found = AddressRow{row.text(0), row.integer(1), row.integer(2), row.integer(3)}; });
  return found;
}

void put_failing_address(Database& db, const AddressRow& row) {
  db.execute("INSERT INTO sign_in_failures (address, failures, locked_until_ms, last_ms) VALUES (?, ?, ?, ?) "
             "ON CONFLICT (address) DO UPDATE SET failures = excluded.failures, "
             "locked_until_ms = excluded.locked_until_ms, last_ms = excluded.last_ms",
             {row.address, row.failures, row.locked_until_ms, row.last_ms});
}

void forget_failing_addresses(Database& db, std::int64_t before_ms) {
  db.execute("DELETE FROM sign_in_failures WHERE last_ms < ? AND locked_until_ms < ?", {before_ms, before_ms});
}

std::optional<std::string> setting(Database& db, const std::string& key) {
  return db.text("SELECT value FROM settings WHERE key = ?", {key});
}

void put_setting(Database& db, const std::string& key, const std::string& value) {
  db.execute("INSERT INTO settings (key, value) VALUES (?, ?) ON CONFLICT (key) DO UPDATE SET value = excluded.value",
             {key, value});
}

}  // namespace headstock::db

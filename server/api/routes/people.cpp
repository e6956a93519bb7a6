// Rights beyond the role, groups of machines, screens that only look, and the rules of signing in.
#include "db/access_store.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/access/accounts.hpp"
#include "server/access/protection.hpp"
#include "server/access/view_tokens.hpp"
#include "server/api/http/session_cookie.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"

namespace headstock::api {

namespace {

using access::Action;
using boost::asio::awaitable;

json shape(const db::GrantRow& grant) {
  return {{"machine", grant.machine != 0 ? json(grant.machine) : json(nullptr)},
          {"group", grant.group != 0 ? json(grant.group) : json(nullptr)},
          {"role", grant.role.empty() ? json(nullptr) : json(grant.role)},
          {"action", grant.action.empty() ? json(nullptr) : json(grant.action)},
          {"allow", grant.allow}};
}

json shape(const db::GroupRow& group) {
  return {{"id", group.id}, {"name", group.name}, {"machines", group.machines}};
}

json shape(const db::ViewTokenRow& row) {
  return {{"id", row.id},
          {"name", row.name},
          {"by", row.by},
          {"created", time_json(row.created_ms)},
          {"expires", row.expires_ms ? time_json(*row.expires_ms) : json(nullptr)},
          {"last_used", row.last_used_ms ? time_json(*row.last_used_ms) : json(nullptr)}};
}

template <class Row>
json people_list(const std::vector<Row>& rows) {
  json items = json::array();
  for (const Row& row : rows) items.push_back(shape(row));
  return {{"items", std::move(items)}, {"next", nullptr}};
}

std::int64_t number_or_0(const json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || found->is_null()) return 0;
  if (!found->is_number_integer() || found->get<std::int64_t>() <= 0) throw Refused("bad_request", name);
  return found->get<std::int64_t>();
}

std::string text_or_empty(const json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || found->is_null()) return "";
  if (!found->is_string()) throw Refused("bad_request", name);
  return found->get<std::string>();
}

std::vector<db::GrantRow> grants_of(const Call& call) {
  const auto list = call.body.find("grants");
  if (list == call.body.end() || !list->is_array()) throw Refused("bad_request", "grants");
  std::vector<db::GrantRow> grants;
  for (const json& given : *list) {
    if (!given.is_object()) throw Refused("bad_request", "grants");
    db::GrantRow grant;
    grant.machine = number_or_0(given, "machine");
    grant.group = number_or_0(given, "group");
    grant.role = text_or_empty(given, "role");
    grant.action = text_or_empty(given, "action");
    const auto allow = given.find("allow");
    if (allow != given.end() && !allow->is_boolean()) throw Refused("bad_request", "allow");
    grant.allow = allow == given.end() || allow->get<bool>();
    grants.push_back(std::move(grant));
  }
  return grants;
}

db::GroupRow group_of(const Call& call, std::int64_t id) {
  db::GroupRow group{id, call.body_text("name"), {}};
  const auto machines = call.body.find("machines");
  if (machines == call.body.end() || !machines->is_array()) throw Refused("bad_request", "machines");
  for (const json& machine : *machines) {
    if (!machine.is_number_integer()) throw Refused("bad_request", "machines");
    group.machines.push_back(machine.get<std::int64_t>());
  }
  return group;
}

json permissions_json() {
  json items = json::array();
  for (const auto& row : access::permissions())
    items.push_back({{"action", row.name}, {"role", access::to_string(row.role)}});
  return {{"items", std::move(items)}, {"next", nullptr}};
}

json protection_json(const std::string& profile) {
  const auto levels = access::protection_levels(profile);
  if (levels.empty()) throw Refused("not_found", profile);
  json items = json::array();
  for (const auto& level : levels)
    items.push_back({{"level", level.level},
                     {"name", {{"en", level.name_en}, {"zh", level.name_zh}}},
                     {"may", {{"en", level.may_en}, {"zh", level.may_zh}}},
                     {"role", access::to_string(level.role)},
                     {"source", level.source}});
  return {{"items", std::move(items)}, {"next", nullptr}};
}

void grant_routes(Services& s, std::vector<Route>& routes) {
  const Need need = needs(Action::manage_users);
  routes.push_back({.method = Method::get, .pattern = "/permissions", .role = Role::viewer,
                    .summary = "Every action and the least role that may do it", .response = "Permissions",
                    .handler = [](Call&) -> awaitable<Reply> { co_return json_reply(permissions_json()); }});
  routes.push_back({.method = Method::get, .pattern = "/protection-levels", .role = Role::viewer,
                    .summary = "The password levels of a controller and the roles they become", .response = "ProtectionLevels",
                    .query = {{"profile", "string", "such as gsk-2000tc"}}, .errors = {"not_found"},
                    .handler = [](Call& call) -> awaitable<Reply> { co_return json_reply(protection_json(call.text("profile"))); }});
  routes.push_back({.method = Method::get, .pattern = "/users/{id}/grants", .role = need,
                    .summary = "What was granted or forbidden beyond the role", .response = "Grants",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto rows = co_await s.store.run([id](db::Database& db) { return db::grants(db, id); });
                      co_return json_reply(people_list(rows));
                    }});
  routes.push_back(
      {.method = Method::patch, .pattern = "/users/{id}/grants", .role = need,
       .summary = "Replace them: a role or an action, on a machine, a group, or everywhere", .takes = Takes::json,
       .request = "GrantsChange", .response = "Grants", .errors = {"bad_role", "bad_value", "last_administrator"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto id = call.id("id");
         const auto actor = actor_of(call);
         const auto grants = grants_of(call);
         const auto rows = co_await s.store.run([&](db::Database& db) {
           access::set_grants(db, actor, id, grants);
           return db::grants(db, id);
         });
         co_return json_reply(people_list(rows));
       }});
}

void group_routes(Services& s, std::vector<Route>& routes) {
  const Need need = needs(Action::manage_users);
  routes.push_back({.method = Method::get, .pattern = "/machine-groups", .role = Role::viewer,
                    .summary = "Groups of machines", .response = "MachineGroups",
                    .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto rows = co_await s.store.run([](db::Database& db) { return db::machine_groups(db); });
                      co_return json_reply(people_list(rows));
                    }});
  const auto put = [&s](Call& call, std::int64_t id, unsigned status) -> awaitable<Reply> {
    auto group = group_of(call, id);
    const auto actor = actor_of(call);
    group.id = co_await s.store.run([&](db::Database& db) { return access::put_group(db, actor, group); });
    co_return json_reply(shape(group), status);
  };
  routes.push_back({.method = Method::post, .pattern = "/machine-groups", .role = need, .summary = "A new group",
                    .takes = Takes::json, .request = "MachineGroupChange", .response = "MachineGroup", .status = 201,
                    .errors = {"bad_name", "name_taken", "not_found"},
                    .handler = [put](Call& call) -> awaitable<Reply> { co_return co_await put(call, 0, 201); }});
  routes.push_back({.method = Method::patch, .pattern = "/machine-groups/{id}", .role = need,
                    .summary = "Change its name and machines", .takes = Takes::json, .request = "MachineGroupChange",
                    .response = "MachineGroup", .errors = {"bad_name", "name_taken"},
                    .handler = [put](Call& call) -> awaitable<Reply> { co_return co_await put(call, call.id("id"), 200); }});
  routes.push_back({.method = Method::del, .pattern = "/machine-groups/{id}", .role = need,
                    .summary = "Remove a group and what was granted on it", .status = 204, .errors = {"in_use", "last_administrator"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto actor = actor_of(call);
                      co_await s.store.run([&](db::Database& db) { access::remove_group(db, actor, id); });
                      co_return empty_reply();
                    }});
}

void screen_routes(Services& s, std::vector<Route>& routes) {
  const Need need = needs(Action::manage_users);
  routes.push_back({.method = Method::get, .pattern = "/view-tokens", .role = need,
                    .summary = "Secrets of screens that only look", .response = "ViewTokens",
                    .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto rows = co_await s.store.run([](db::Database& db) { return db::view_tokens(db); });
                      co_return json_reply(people_list(rows));
                    }});
  routes.push_back({.method = Method::post, .pattern = "/view-tokens", .role = need,
                    .summary = "A new one; the secret is in this answer only", .takes = Takes::json,
                    .request = "NewViewToken", .response = "ViewTokenMade", .status = 201, .errors = {"bad_name", "bad_value"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto name = call.body_text("name");
                      std::optional<std::int64_t> expires;
                      if (const auto text = call.body_text("expires", ""); !text.empty()) {
                        expires = parse_time(text);
                        if (!expires) throw Refused("bad_request", "expires");
                      }
                      const auto actor = actor_of(call);
                      const auto made = co_await s.store.run([&](db::Database& db) {
                        return access::create_view_token(db, actor, name, expires, db::now_ms());
                      });
                      co_return json_reply({{"id", made.id}, {"name", name}, {"token", made.token}}, 201);
                    }});
  routes.push_back({.method = Method::del, .pattern = "/view-tokens/{id}", .role = need,
                    .summary = "Revoke it; a screen that uses it is signed out", .status = 204,
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto actor = actor_of(call);
                      co_await s.store.run(
                          [&](db::Database& db) { access::revoke_view_token(db, actor, id, db::now_ms()); });
                      co_return empty_reply();
                    }});
  routes.push_back(
      {.method = Method::post, .pattern = "/session/screen", .role = Role::none,
       .summary = "Use a screen's secret in this browser", .takes = Takes::json, .request = "ScreenSignIn", .status = 204,
       .errors = {"wrong_sign_in"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto token = call.body_text("token");
         const auto row = co_await s.store.run(
             [&](db::Database& db) { return access::find_view_token(db, token, db::now_ms()); });
         if (!row) throw Refused("wrong_sign_in");
         Reply reply = empty_reply();
         // A year: the screen hangs there; the secret itself can be revoked at any time.
         reply.headers.emplace_back("Set-Cookie", std::string(session_cookie) + "=" + token +
                                                      "; Path=/; HttpOnly; SameSite=Strict; Max-Age=31536000" +
                                                      (call.request.secure ? "; Secure" : ""));
         co_return reply;
       }});
}

void policy_routes(Services& s, std::vector<Route>& routes) {
  const Need need = needs(Action::change_settings);
  const auto shown = [](const access::PolicyChange& policy) {
    return json{{"session_hours", policy.session_hours},
                {"idle_minutes", policy.idle_minutes},
                {"least_password", policy.least_password}};
  };
  routes.push_back({.method = Method::get, .pattern = "/settings/sign-in", .role = need,
                    .summary = "How long sign-ins last, how long passwords are", .response = "SignInPolicy",
                    .handler = [&s, shown](Call&) -> awaitable<Reply> {
                      const auto policy = co_await s.store.run([](db::Database& db) { return access::policy_settings(db); });
                      co_return json_reply(shown(policy));
                    }});
  routes.push_back({.method = Method::patch, .pattern = "/settings/sign-in", .role = need, .summary = "Change them",
                    .takes = Takes::json, .request = "SignInPolicy", .response = "SignInPolicy", .errors = {"bad_value"},
                    .handler = [&s, shown](Call& call) -> awaitable<Reply> {
                      const access::PolicyChange change{call.body_number("session_hours"), call.body_number("idle_minutes"),
                                                        call.body_number("least_password")};
                      const auto actor = actor_of(call);
                      co_await s.store.run([&](db::Database& db) { access::set_policy(db, actor, change); });
                      co_return json_reply(shown(change));
                    }});
}

}  // namespace

std::vector<Route> people_routes(Services& s) {
  std::vector<Route> routes;
  grant_routes(s, routes);
  group_routes(s, routes);
  screen_routes(s, routes);
  policy_routes(s, routes);
  return routes;
}

}  // namespace headstock::api
